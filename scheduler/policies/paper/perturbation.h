#pragma once

#include <vector>

#include "base/random.h"
#include "scheduler/policies/paper/local_search.h"
#include "scheduler/solution.h"

namespace muster::scheduler::paper {

/// SCPA: takes up to `strength` random nodes of one label out of the solution (label 0, 1, 2 in
/// turn by `iteration` mod 3; of label 2 half as many) and puts in, in random order, nodes of other
/// labels that conflict with one of those and with nothing else: barriers against undoing it.
/// Returns the elements whose holders changed. Source: Alg. 4 and the constraints of A(R, C).
std::vector<int> Perturb(const WorkingGraph& graph, int iteration, int strength, Random* random,
                         Solution* solution);

}  // namespace muster::scheduler::paper
