#pragma once

#include <string>
#include <vector>

#include "model/scenario.h"
#include "tools/faults/fault_plan.h"

namespace muster::tools {

struct RandomPlanSettings {
  std::uint64_t seed = 1;
  double rate_per_hour = 4;      ///< faults per mission hour, on average
  std::vector<FaultKind> kinds;  ///< to draw from, not empty
  int schedulers = 1;
  int per_class = 1;     ///< processes of each agent class
  bool goes_on = false;  ///< some kills, stops and partitions last in mission time
};

/// Every kind but corruption, which may truly change decisions.
std::vector<FaultKind> AllSurvivableKinds();

/// Draws a plan: times from a Poisson process; kind, target, duration and strength uniformly. At
/// most one fault at a time holds a process: the world and the agents keep each other's state, and
/// with two of them gone it may be lost for good.
FaultPlan DrawPlan(const Scenario& scenario, const RandomPlanSettings& settings);

/// That share of each agent class, rounded, fails for good at that time. The seed decides which
/// agents fail; with the same seed a larger share includes the agents of a smaller one.
FaultPlan DropPlan(const Scenario& scenario, double share, TimeUs at_us, std::uint64_t seed);

}  // namespace muster::tools
