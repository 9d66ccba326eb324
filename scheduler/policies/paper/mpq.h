#pragma once

#include <cstdint>

#include "scheduler/nodes.h"
#include "scheduler/policies/paper/ils.h"
#include "scheduler/solution.h"

namespace muster::scheduler::paper {

/// HoCs-MPQ: HoCs-ILS on a growing subgraph that takes the heaviest nodes of each agent first, K
/// more of each agent a round, K doubling after a round without gain, until every idle agent has a
/// node in the solution or no nodes are left. The draws of round r are those of
/// Random(seed, Stream::kPolicy, r, decision). Source: Alg. 5.
Solution MultiPriorityQueues(const Elements& elements, const std::vector<Node>& nodes,
                             std::uint64_t seed, std::int32_t decision,
                             int max_iterations = kMaxIterations);

}  // namespace muster::scheduler::paper
