#include "scheduler/policies/learned/shape.h"

#include <fmt/format.h>

#include <cmath>

#include "model/generator.h"

namespace muster::scheduler::learned {

bool operator==(const Shape& a, const Shape& b) {
  return a.columns == b.columns && a.rows == b.rows && a.agents.uavs == b.agents.uavs &&
         a.agents.workers == b.agents.workers && a.agents.vehicles == b.agents.vehicles &&
         a.interval_us == b.interval_us && a.limit_us == b.limit_us;
}

Shape ShapeOf(const Scenario& scenario) {
  Shape shape;
  shape.columns = static_cast<int>(std::ceil(scenario.width_m / kCellM));
  shape.rows = static_cast<int>(std::ceil(scenario.height_m / kCellM));
  for (const AgentKind kind : kAgentKinds) {
    shape.agents[kind] = static_cast<int>(scenario.n_agents(kind));
  }
  shape.interval_us = scenario.rules.interval_us;
  shape.limit_us = scenario.rules.limit_us;
  return shape;
}

std::string ToString(const Shape& shape) {
  return fmt::format(
      "{} x {} km, {} UAVs, {} workers, {} vehicles, decisions every {:g} min for {:g} min",
      shape.columns, shape.rows, shape.agents.uavs, shape.agents.workers, shape.agents.vehicles,
      ToMinutes(shape.interval_us), ToMinutes(shape.limit_us));
}

}  // namespace muster::scheduler::learned
