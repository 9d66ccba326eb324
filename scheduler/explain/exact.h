#pragma once

#include <optional>
#include <vector>

#include "scheduler/situation.h"
#include "scheduler/solver/build.h"

namespace muster::scheduler {

/// A pair that a decision must hold: at that task, or with that agent, or both; with an agent alone
/// any pair of it will do.
struct Demand {
  TaskId task;      ///< invalid: any place
  ChargeId charge;  ///< invalid: any place; only with an agent
  std::optional<AgentKind> agent_kind;
  std::int32_t agent = -1;
};

/// A heaviest decision under the paper's weights.
struct Optimum {
  double weight = 0;
  double bound = 0;             ///< proven: none weighs more; at least weight
  std::vector<Action> actions;  ///< stays included
  /// Whether nothing but rounding lies between them.
  bool proven() const { return bound - weight <= 1e-6; }
};

/// Best decisions of one situation, with and without a demand, by the certified solver.
class ExactDecisions {
 public:
  explicit ExactDecisions(const Situation& situation);

  const Optimum& best() const { return best_; }
  /// The heaviest decision that meets the demand, as SolveWith.
  std::optional<Optimum> Forced(const Demand& demand) const;

 private:
  const Situation& situation_;
  BuiltInstance built_;
  Optimum best_;
};

}  // namespace muster::scheduler
