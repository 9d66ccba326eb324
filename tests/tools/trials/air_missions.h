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
#include "tests/model/drawn_zones.h"
#include "tests/tools/trials/road_missions.h"
#include "tools/trials/campaign.h"

namespace muster::tools {

/// Zones: concave, touching, with holes; for the whole mission, for a time, by order, lifted.
inline void DrawAir(std::uint64_t seed, VirtualMission* mission) {
  Random random(seed, Stream::kTest, 2);
  const auto minute = [&] { return random.Below(85) * kMinuteUs; };
  ScenarioAir air;
  air.margin_m = 5 + random.Below(80);
  for (Zone& zone : testing::DrawnZones(&random, 14'000, static_cast<int>(random.Below(6)))) {
    PlannedZone& planned = air.zones.emplace_back();
    planned.zone = std::move(zone);
    planned.zone.name = "airfield \"north\"";
    if (random.Below(2) == 0) planned.from_us = minute();
    if (random.Below(2) == 0) planned.until_us = planned.from_us + minute() + kSecondUs;
  }
  UseAir(std::move(air), &mission->scenario);
  std::uint32_t n = 0;
  for (const Zone& zone : testing::DrawnZones(&random, 14'000, static_cast<int>(random.Below(5)))) {
    std::string json = fmt::format("{{\"order\": \"zone_add\", \"id\": \"z{}\", \"at_min\": {}, {}",
                                   ++n, minute() / kMinuteUs, ZoneToJson(zone));
    if (random.Below(2) == 0) json += ", \"until_in_min\": 12.5";
    json += "}";
    mission->orders.push_back({ParseOrder(json, "order"), json});
    if (random.Below(2) > 0) continue;
    json = fmt::format(
        "{{\"order\": \"zone_lift\", \"id\": \"l{0}\", \"at_min\": {1}, \"zone\": \"z{0}\"}}", n,
        minute() / kMinuteUs);
    mission->orders.push_back({ParseOrder(json, "order"), json});
  }
}

/// A third of Random_1 with zones; on streets where the seed is odd.
inline VirtualMission AirMission(const std::string& policy, std::uint64_t seed) {
  VirtualMission mission = RoadMission(policy, seed);
  if (seed % 2 == 0) {
    mission.scenario.roads = nullptr;
    mission.scenario.ways = DefaultWays();
  }
  DrawAir(seed, &mission);
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
  VirtualMission mission = DrawMission(settings, seed);
  mission.orders.insert(mission.orders.end(), with_air.orders.begin(), with_air.orders.end());
  return mission;
}

}  // namespace muster::tools

#endif  // MUSTER_TESTS_TOOLS_TRIALS_AIR_MISSIONS_H_
