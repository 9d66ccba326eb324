#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>

#include "scheduler/solver/instance.h"

namespace muster::scheduler {

struct SolverLimits {
  /// Elementary steps (arcs and columns looked at), about 2 ns each. Repeatable. 0: chosen by the
  /// size of the instance.
  std::int64_t work = 0;
  /// Wall time to stop at, for live use: an answer may then depend on the machine's speed.
  std::optional<std::chrono::steady_clock::time_point> deadline;
  int threads = 1;  ///< 1 or 2; no answer depends on it
};

struct SolverResult {
  Assignment assignment;  ///< valid
  double bound = 0;       ///< proven: no assignment weighs more; at least assignment.weight
  /// Value of the linear relaxation; NaN: not reached within the limits.
  double relaxation = std::numeric_limits<double>::quiet_NaN();
  std::int64_t work = 0;
  double bound_s = 0;   ///< wall time spent on prices
  double search_s = 0;  ///< on assignments
  double gap() const { return bound > 0 ? (bound - assignment.weight) / bound : 0; }
};

/// A heaviest independent set of the instance's conflict graph, or a heavy one with a proven bound.
/// In turn: the linear relaxation of the packing (Relaxation), where a round's bound is Lagrangian
/// (Dual) and holds whether or not the relaxation was solved to its end; its solution, integral in
/// nearly every decision, rounded and filled up; where the relaxation was hard, improved by
/// matchings of one class at a time (Matchings); else exact searches in small windows (Windows) and
/// ejection chains (Chains) where that loses against the bound; and, when a gap is left, one exact
/// search over all columns that a better assignment may hold (Branching, with Cliques where it is
/// long), which proves the optimum when it ends. Source: ours; the prices are those of Frieze and
/// Yadegar 1981, Poore and Robertson 1997, found by simplex steps (PackingLp) as subgradient steps
/// needed ten times longer for a thousandth of gap.
SolverResult Solve(const Instance& instance, const SolverLimits& limits = {});

}  // namespace muster::scheduler
