#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <iterator>
#include <string>
#include <utility>

#include "base/random.h"
#include "model/generator.h"
#include "model/order.h"
#include "tools/trials/campaign.h"
#include "tools/trials/draws.h"

namespace muster::tools {

inline void DrawClosures(std::uint64_t seed, VirtualMission* mission) {
  Random random(seed, Stream::kTest, 1);
  DrawClosures(&random, mission);
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
  DrawStreets(seed, &mission.scenario);
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
  settings.extras.clear();
  VirtualMission mission = DrawMission(settings, seed);
  if (seed % 3 > 0) DrawClosures(seed, &mission);
  return mission;
}

}  // namespace muster::tools
