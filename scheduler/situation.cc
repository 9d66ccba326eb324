#include "scheduler/situation.h"

#include <algorithm>
#include <limits>

#include "model/place_index.h"

namespace muster::scheduler {

Site::Site(const Scenario& scenario)
    : tasks(scenario.tasks),
      charging_points(scenario.charging_points),
      ways(scenario.ways),
      open_roads(scenario.roads ? scenario.roads->ways : nullptr),
      closures(scenario.closures),
      directives(scenario.directives),
      separation(scenario.separation() ? std::optional(*scenario.separation()) : std::nullopt),
      high_zones(HighZonesOf(scenario)),
      forbidden(ForbiddenPairs(directives)),
      rules(scenario.rules),
      width_m(scenario.width_m),
      height_m(scenario.height_m),
      seed(scenario.seed) {
  for (const AgentKind kind : kAgentKinds) {
    const std::vector<AgentSpec>& specs = scenario.agents(kind);
    for (std::size_t i = 0; i < specs.size(); ++i) {
      if (specs[i].online_from_us <= 0 || specs[i].online_until_us <= specs[i].online_from_us) {
        continue;
      }
      shifts.push_back({kind, static_cast<std::int32_t>(i), specs[i]});
    }
  }
  std::stable_sort(shifts.begin(), shifts.end(), [](const Shift& a, const Shift& b) {
    return a.spec.online_from_us < b.spec.online_from_us;
  });
  std::vector<Point> places;
  for (const ChargingPoint& point : charging_points) places.push_back(point.at);
  const PlaceIndex index(places, {ways.get(), AgentKind::kUav});
  task_to_charge_m.reserve(tasks.size());
  for (const Task& task : tasks) task_to_charge_m.push_back(index.NearestFrom(task.at));
}

std::int32_t Situation::free_places(ChargeId charge) const {
  const auto& capacity = site->charging_points[charge.index()].capacity;
  if (!capacity) return std::numeric_limits<std::int32_t>::max();
  return std::max(0, *capacity - charging_load[charge.index()]);
}

}  // namespace muster::scheduler
