#pragma once

#include <cstdint>

#include "scheduler/policies/rollout/forward_model.h"

namespace muster::scheduler {

/// Imagines the tasks that are still to be reported, `per_hour` of them in the mean, at any time
/// from now to the limit, each like a task that is known now: its place, cost and priority, due and
/// gone as long after its report. Nothing is expected before a task is known. Tasks of the
/// scenario that are not reported yet have no part in it. Drawn by (seed, decision, `number`). The
/// situation of the future has them at the end of its tasks, not reported yet.
/// Source: ours; deciding with sampled futures is that of Bent and Van Hentenryck, "Scenario-Based
/// Planning for Partially Dynamic Vehicle Routing with Stochastic Customers" (2004).
Future ExpectTasks(const Situation& situation, double per_hour, std::uint32_t number);

}  // namespace muster::scheduler
