#pragma once

#include <cstdint>
#include <iterator>
#include <string>
#include <utility>

#include "model/generator.h"
#include "tests/model/street_grid.h"
#include "tools/trials/soak.h"

namespace muster::tools {

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

/// The same with kills, loss and a policy that are drawn.
inline VirtualMission DrawRoadMission(std::uint64_t seed) {
  constexpr const char* kPolicies[] = {"certified",     "mpq",           "horizon",   "rollout",
                                       "rollout-steps", "horizon-steps", "greedy-sum"};
  SoakSettings settings;
  settings.policy = kPolicies[seed % std::size(kPolicies)];
  settings.scenario = RoadMission("", seed).scenario;
  return DrawMission(settings, seed);
}

}  // namespace muster::tools
