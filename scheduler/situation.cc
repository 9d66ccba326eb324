#include "scheduler/situation.h"

#include <algorithm>
#include <limits>

#include "world/model/feasibility.h"

namespace muster::scheduler {

Site::Site(const Scenario& scenario)
    : tasks(scenario.tasks),
      charging_points(scenario.charging_points),
      rules(scenario.rules),
      width_m(scenario.width_m),
      height_m(scenario.height_m),
      seed(scenario.seed) {
  task_to_charge_m.reserve(tasks.size());
  for (const Task& task : tasks) {
    task_to_charge_m.push_back(NearestChargeDistance(task.at, charging_points));
  }
}

std::int32_t Situation::free_places(ChargeId charge) const {
  const auto& capacity = site->charging_points[charge.index()].capacity;
  if (!capacity) return std::numeric_limits<std::int32_t>::max();
  return std::max(0, *capacity - charging_load[charge.index()]);
}

}  // namespace muster::scheduler
