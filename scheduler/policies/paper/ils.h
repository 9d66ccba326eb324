#pragma once

#include "base/random.h"
#include "scheduler/policies/paper/local_search.h"
#include "scheduler/solution.h"

namespace muster::scheduler::paper {

inline constexpr int kMaxIterations = 100;

/// Extends `solution` by the nodes of the graph that fit, in the order of label (2 first), weight
/// (largest first), id. Source: Alg. 2 line 1 ("greedy, hierarchical weight-based").
void ExtendGreedily(const WorkingGraph& graph, Solution* solution);

/// k of SCPA: 1 + floor(no_improvement / 10), at most 30 % of the solution's nodes (but 1).
/// Source: AdaptPerturbStrength of Alg. 2, whose rule the paper leaves open: ours.
int PerturbStrength(int no_improvement, std::size_t solution_size);

/// HoCs-ILS: iterated local search from `initial`. Returns the best solution found, never worse
/// than `initial`. Source: Alg. 2.
Solution IteratedLocalSearch(const WorkingGraph& graph, const Solution& initial, Random random,
                             int max_iterations = kMaxIterations);

}  // namespace muster::scheduler::paper
