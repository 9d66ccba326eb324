#include "tools/log/closed_roads.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace muster::tools {

std::vector<ClosedRoad> ClosedRoadsOf(const Scenario& scenario) {
  using Key = std::pair<std::string, std::int32_t>;  // order, road
  std::vector<ClosedRoad> closed;
  std::map<Key, std::size_t> in_force;  // index into closed
  for (const Scenario::WaysSince& change : scenario.changed_ways) {
    std::set<Key> still;
    for (const Closure& closure : change.closures) {
      for (const std::int32_t road : closure.roads) {
        still.insert({closure.order, road});
        if (!in_force.try_emplace({closure.order, road}, closed.size()).second) continue;
        closed.push_back({road, closure.order, closure.name, change.at_us, kNever});
      }
    }
    std::erase_if(in_force, [&](const auto& entry) {
      if (still.contains(entry.first)) return false;
      closed[entry.second].until_us = change.at_us;
      return true;
    });
  }
  return closed;
}

}  // namespace muster::tools
