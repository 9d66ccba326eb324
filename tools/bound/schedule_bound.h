#pragma once

#include <cmath>
#include <cstdint>
#include <functional>

#include "model/scenario.h"

namespace muster::tools {

/// The most tasks that a bound leaves: linear programs round.
inline std::int64_t WholeTasks(double bound) {
  return static_cast<std::int64_t>(std::floor(bound + 1e-6));
}

/// Told after each round: how many are done, and the bound so far.
using BoundProgress = std::function<void(std::int64_t round, double bound)>;

/// No policy, not even one that knows everything beforehand, gets more of the scenario's tasks done
/// by its limit: as UpperBound(), but by what an agent can do one after the other. Source: ours.
///
/// For each done task there is a first decision that is not before its end. Then its UAV and its
/// worker are free again, neither sooner. So what an agent does is a list of visits (site,
/// decision). Whatever moves and waiting lie between, the next visit of a list ends no sooner than
/// the way takes from that decision on, and the sensing after it. A UAV has range for its ways and
/// its sensing and for the way on to a charging point; while it charges it gains range at the
/// fastest vehicle's rate. The linear program: the most tasks in the UAVs' lists, where each agent
/// has one list, each task is done once, and for each (site, decision) of a UAV there is a worker
/// or a vehicle with the same visit. Every mission is a solution of it. Its columns, the lists, are
/// made as they are needed: each round solves it and finds each agent's list that is worth most at
/// its prices. The sum of all prices and worths is a bound after any round (Lagrange; column
/// generation: Desrosiers and Luebbecke 2005).
///
/// Left out: disturbances, what a policy may know, capacities of charging points. All that only
/// takes tasks away. At rules.start_on_meeting pairs form between decisions; then, and with no
/// round, the bound is the number of tasks. It ends before `rounds` when more rounds lower the
/// whole number of tasks no further. Throws SystemError without Clp's library. Memory: O(tasks^2).
/// Time of a round: O(agents * tasks^2 * decisions that an agent is there).
double ScheduleBound(const Scenario& scenario, std::int64_t rounds,
                     const BoundProgress& progress = {});

}  // namespace muster::tools
