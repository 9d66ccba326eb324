#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "scheduler/solver/packing_lp.h"

namespace muster::scheduler {

/// Branch and bound over the columns of a linear program whose rows are UAVs, partners and sites,
/// in that order, and whose columns name theirs in that order (kNoRow: none). Branches on whether a
/// UAV takes a partner along, then whether a UAV or a partner goes to a site.
class Branching {
 public:
  struct Hooks {
    std::function<bool()> stop;
    /// Best objective known so far: branches whose bound is not above it are cut.
    std::function<double()> best;
    /// The program's solution is whole: keep it.
    std::function<void()> whole;
  };
  /// A share this close to 0 or 1 is whole.
  static constexpr double kWhole = 1e-3;

  /// `slack` is added to each bound. The program must outlive this, none of its columns closed.
  /// closed_cost: see PackingLp; 0: by what its columns are worth.
  Branching(PackingLp* lp, std::int32_t n_uavs, double slack, Hooks hooks, double closed_cost = 0);

  /// Returns a bound on the objective of every packing of the columns, at most `above`. Columns
  /// and rows are open again afterwards.
  double Search(double above, std::int64_t work_limit);
  std::int64_t work() const { return work_; }

 private:
  static std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }
  double Branch(double above);
  /// Rows that are to meet or to be kept apart; agent < 0: all is whole.
  struct Pick {
    double share = 0;
    std::int32_t agent = -1, other = -1;
    bool is_uav = false, by_site = false;
    double Miss() const { return share > 0.5 ? share - 0.5 : 0.5 - share; }
  };
  Pick Fraction();

  PackingLp& lp_;
  std::int32_t n_uavs_;
  double slack_;
  Hooks hooks_;
  std::int64_t work_ = 0, end_ = 0;
  struct Share {
    std::int32_t agent, other;
    double value;
  };
  std::vector<Share> shares_;
};

}  // namespace muster::scheduler
