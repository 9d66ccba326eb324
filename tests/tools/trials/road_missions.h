#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <iterator>
#include <string>
#include <utility>

#include "base/random.h"
#include "model/generator.h"
#include "model/order.h"
#include "tests/model/street_grid.h"
#include "tools/trials/campaign.h"

namespace muster::tools {

/// Roads that there are.
inline RoadArea DrawArea(const Roads& roads, Random* random) {
  const auto km = [&] { return 14'000 * random->Uniform(); };
  for (;;) {
    RoadArea area;
    switch (random->Below(4)) {
      case 0:
        area.of = RoadArea::Circle{{km(), km()}, 2500 * random->Uniform()};
        break;
      case 1:
        area.of = RoadArea::Polygon{{{km(), km()}, {km(), km()}, {km(), km()}, {km(), km()}}};
        break;
      case 2:
        area.of = RoadArea::Ids{{100 + random->Below(40), 100 + random->Below(40)}};
        break;
      default:
        area.of = RoadArea::Nearest{{km(), km()}};
    }
    if (!RoadsIn(roads, area).empty()) return area;
  }
}

/// Roads are closed: as planned, by order, and unknown to all.
inline void DrawClosures(std::uint64_t seed, VirtualMission* mission) {
  Random random(seed, Stream::kTest, 1);
  const Roads& network = *mission->scenario.roads->network;
  const auto minute = [&] { return random.Below(85) * kMinuteUs; };
  ScenarioRoads roads = *mission->scenario.roads;
  for (std::uint32_t n = random.Below(4); n > 0; --n) {
    PlannedClosure& closure = roads.closures.emplace_back();
    closure.area = DrawArea(network, &random);
    closure.name = "flood \"north\"";
    closure.from_us = minute();
    if (random.Below(2) == 0) closure.until_us = closure.from_us + minute() + kSecondUs;
  }
  UseRoads(std::move(roads), "grid.roads.json", &mission->scenario);
  for (std::uint32_t n = random.Below(6); n > 0; --n) {
    const TimeUs at_us = minute();
    const bool opens = random.Below(3) == 0;
    std::string json = fmt::format("{{\"order\": \"{}\", \"id\": \"o{}\", \"at_min\": {}, {}",
                                   opens ? "road_open" : "road_close", n, at_us / kMinuteUs,
                                   RoadAreaToJson(DrawArea(network, &random)));
    if (!opens && random.Below(2) == 0) json += ", \"until_in_min\": 12.5";
    json += "}";
    mission->orders.push_back({ParseOrder(json, "order"), json});
  }
  for (std::uint32_t n = random.Below(4); n > 0; --n) {
    const std::string target =
        fmt::format("{}/{}/{}", random.Below(14), random.Below(14), 0.5 + 0.5 * random.Below(4));
    if (RoadsIn(network, *CircleFrom(target)).empty()) continue;
    PlannedFault& fault = mission->faults.emplace_back();
    fault.id = fmt::format("road{}", n);
    fault.kind = FaultKind::kRoadClosed;
    fault.target = target;
    fault.at_us = minute() + random.Below(60) * kSecondUs;
    if (random.Below(2) == 0) fault.for_us = 5 * kMinuteUs + minute();
  }
}

/// A third of Random_1, on streets.
inline VirtualMission RoadMission(const std::string& policy, std::uint64_t seed) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.width_km = settings.height_km = 14;
  settings.uavs = 9;
  settings.workers = 13;
  settings.vehicles = 6;
  settings.tasks = 34;
  settings.charging_points = 5;
  settings.full_range_km = 22;
  settings.start_fraction = {0.4, 1};
  settings.placement = seed % 2 == 0 ? Placement::kContinuous : Placement::kCellCentres;
  settings.rules.limit_us = 90 * kMinuteUs;
  VirtualMission mission;
  mission.scenario = Generate(settings, seed);
  ScenarioRoads roads;
  roads.file = "grid.roads.json";
  const int n = 4 + static_cast<int>(seed % 13);
  roads.text = RoadsToJson(muster::testing::StreetGrid(n, 14'000.0 / n, seed, seed % 4 == 1));
  // Some agents never leave the road, others cross the fields as fast as they like.
  const auto percent = [&](std::uint64_t by) {
    return seed % by == 0 ? 0 : seed % by == 1 ? 100 : 35;
  };
  roads.open_ground = {{}, {percent(11), 700}, {percent(7), seed % 3 == 0 ? 5000.0 : 600.0}};
  UseRoads(std::move(roads), "grid.roads.json", &mission.scenario);
  mission.policy = policy;
  mission.fault_seed = seed;
  return mission;
}

/// The same with kills, loss, a policy and, in two of three, closed roads that are drawn.
inline VirtualMission DrawRoadMission(std::uint64_t seed) {
  constexpr const char* kPolicies[] = {
      "certified",     "mpq",           "horizon",    "rollout",
      "rollout-steps", "horizon-steps", "greedy-sum", "neighbours:reach=4:loss=0.2"};
  CampaignSettings settings;
  settings.policy = kPolicies[seed % std::size(kPolicies)];
  settings.scenario = RoadMission("", seed).scenario;
  VirtualMission mission = DrawMission(settings, seed);
  if (seed % 3 > 0) DrawClosures(seed, &mission);
  return mission;
}

}  // namespace muster::tools
