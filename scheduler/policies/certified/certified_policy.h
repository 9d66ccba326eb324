#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "scheduler/policy.h"
#include "scheduler/solver/solver.h"

namespace muster::scheduler {

/// Where a decision's wall time went, seconds.
struct CertifiedProfile {
  double weights_s = 0;     ///< expected costs and gains
  double candidates_s = 0;  ///< finding and ordering the feasible ways
  double bound_s = 0;       ///< the linear relaxation and its bounds
  double search_s = 0;      ///< assignments
  std::int64_t work = 0;    ///< the solver's steps
  double relaxation = 0;    ///< value of the linear relaxation; NaN: not reached
};

/// One decision by BuildInstance and Solve, with its proven bound. Where that leaves a gap above
/// 1e-6, it is compared with kwta's and with the first local optima of ils and mpq (the latter two
/// up to two million nodes, all of them where every agent's way to every site fits in memory), and
/// the heaviest is taken. `profile` may be null.
Decision DecideCertified(const Situation& situation, const SolverLimits& limits,
                         CertifiedProfile* profile);

/// The policy `certified`: repeatable, as its limit is one of work unless there is a deadline. It
/// keeps nothing between calls.
class CertifiedPolicy : public Policy {
 public:
  /// Two threads where they pay, unless the limits say otherwise.
  CertifiedPolicy() { limits_.threads = 2; }
  explicit CertifiedPolicy(const SolverLimits& limits) : limits_(limits) {}
  Decision Decide(const Situation& situation) override;
  bool SetDeadline(std::chrono::steady_clock::duration deadline) override {
    deadline_ = deadline;
    return true;
  }

 private:
  SolverLimits limits_;
  std::optional<std::chrono::steady_clock::duration> deadline_;
};

}  // namespace muster::scheduler
