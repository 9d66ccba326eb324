#ifndef MUSTER_TESTS_TOOLS_TRIALS_AIR_MISSIONS_H_
#define MUSTER_TESTS_TOOLS_TRIALS_AIR_MISSIONS_H_

#include <fmt/format.h>

#include <cstdint>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "model/order.h"
#include "tests/tools/trials/road_missions.h"
#include "tools/trials/campaign.h"

namespace muster::tools {

/// A third of Random_1 with zones; on streets where the seed is odd.
inline VirtualMission AirMission(const std::string& policy, std::uint64_t seed) {
  VirtualMission mission = RoadMission(policy, seed);
  if (seed % 2 == 0) {
    mission.scenario.roads = nullptr;
    mission.scenario.ways = DefaultWays();
  }
  Random random(seed, Stream::kTest, 2);
  DrawZones(&random, &mission);
  return mission;
}

/// The same with kills, loss and a policy that are drawn.
inline VirtualMission DrawAirMission(std::uint64_t seed) {
  constexpr const char* kPolicies[] = {
      "certified",     "mpq",           "horizon",    "rollout",
      "rollout-steps", "horizon-steps", "greedy-sum", "neighbours:reach=4:loss=0.2"};
  const VirtualMission with_air = AirMission("", seed);
  CampaignSettings settings;
  settings.policy = kPolicies[seed % std::size(kPolicies)];
  settings.scenario = with_air.scenario;
  settings.extras.clear();
  VirtualMission mission = DrawMission(settings, seed);
  mission.orders.insert(mission.orders.end(), with_air.orders.begin(), with_air.orders.end());
  return mission;
}

}  // namespace muster::tools

#endif  // MUSTER_TESTS_TOOLS_TRIALS_AIR_MISSIONS_H_
