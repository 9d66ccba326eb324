#pragma once

#include <cstdint>

#include "model/scenario.h"

namespace muster::tools {

/// No policy, not even one that knows everything beforehand, gets more of the scenario's tasks done
/// by its limit. Source: ours.
///
/// What every mission keeps to, whatever its policy:
/// 1. A task is done by one sensing of one UAV and one worker that are both idle and online at the
///    same decision, at times k * interval < limit, and that are commanded or meet then. So each of
///    them starts at most one activity a decision.
/// 2. No agent is anywhere sooner than on the straight line from where it starts, leaving at its
///    first decision online. With Rules::start_on_meeting its cell will do: the line is shorter by
///    that cell's diagonal.
/// 3. Sensing starts no sooner than the decision and either arrival, takes cost / UAV speed (a
///    worker's: at the fastest UAV's speed), and ends by the limit. In mode strict it also ends by
///    both downtimes.
/// 4. A UAV senses only what a full range allows with the way on to a charging point.
/// 5. No agent is idle again before its sensing has ended: with the shortest sensing of all, that
///    gives a largest number of tasks for each agent's time.
///
/// All else is left out: ways between tasks, ranges, charging, charging points, disturbances, what
/// a policy may know. Two relaxations hold, and the smaller is the bound: (a) the largest flow
/// UAV -> UAV's decision -> task -> worker's decision -> worker with the numbers of 5 and each
/// decision and task once, where the two decisions may differ; (b) the sum over the decisions of
/// the largest flow UAV -> task -> worker at that decision, where a task may be done again at
/// another one. A mission's done tasks are such a flow in both, as 1 to 5 say which arcs it uses.
///
/// Disturbances only take time, range, agents or matches away, so the bound holds under them too.
/// Time: O(agents * decisions * tasks) arcs, in practice linear in them.
std::int64_t UpperBound(const Scenario& scenario);

}  // namespace muster::tools
