#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "simulation/start_process.h"
#include "world/planned_orders.h"
#include "world/referee.h"

namespace muster::tools {

/// Runs a whole mission in this process: the very cores of the mission's processes over an
/// in-memory bus that loses nothing, with no clock but a counter. `policy` is a policy's name.
/// Every published packet goes to `observe`, once, in order. The same decisions and outcomes as
/// `muster run`. Throws InputError on an impossible scenario or policy. `faults`: agents that fail
/// and roads that are closed by faults. `orders`: those given in its course. `drivers`: of measured
/// agents; it waits for them.
void Simulate(const ScenarioText& scenario, const std::string& policy,
              const std::function<void(const Packet&)>& observe,
              const world::WorldFaults& faults = {},
              const std::vector<world::PlannedOrder>& orders = {},
              const simulation::DriversOf& drivers = {});

}  // namespace muster::tools
