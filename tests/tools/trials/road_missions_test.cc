// Whole missions by road: each passes the audit, which finds its own ways, and each of their
// decisions is made again.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "model/generator.h"
#include "scheduler/policies/registry.h"
#include "tests/model/street_grid.h"
#include "tools/trials/soak.h"

namespace muster::tools {
namespace {

using muster::testing::StreetGrid;

void PutOnRoads(std::uint64_t seed, bool plain, Scenario* scenario) {
  const int n = 12;
  ScenarioRoads roads;
  roads.file = "grid.roads.json";
  roads.text = RoadsToJson(StreetGrid(n, scenario->width_m / n, seed, plain));
  roads.open_ground = {{}, {50, 700}, {30, 600}};
  UseRoads(std::move(roads), "grid.roads.json", scenario);
}

/// A third of Random_1, on streets.
VirtualMission MissionOf(const std::string& policy, std::uint64_t seed) {
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
  PutOnRoads(seed, seed % 2 == 1, &mission.scenario);
  mission.policy = policy;
  mission.fault_seed = seed;
  return mission;
}

class RoadMissions : public ::testing::TestWithParam<std::string> {};

TEST_P(RoadMissions, AreAuditedAndDecidedAgain) {
  for (const std::uint64_t seed : {1, 2}) {
    for (const std::string& finding : FindingsOf(MissionOf(GetParam(), seed))) {
      ADD_FAILURE() << "seed " << seed << ": " << finding;
    }
  }
}

std::vector<std::string> AllPolicies() {
  std::vector<std::string> names;
  for (const scheduler::PolicyInfo& policy : scheduler::Policies()) names.emplace_back(policy.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Policies, RoadMissions, ::testing::ValuesIn(AllPolicies()),
                         [](const auto& policy) {
                           std::string name = policy.param;
                           for (char& c : name) c = c == '-' || c == ':' || c == '.' ? '_' : c;
                           return name;
                         });

TEST(RoadMissions, WithKillsAndLossAreAuditedAndDecidedAgain) {
  const std::vector<std::string> policies = {"certified",     "horizon",       "rollout",
                                             "rollout-steps", "horizon-steps", "greedy-sum"};
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SoakSettings settings;
    settings.policy = policies[seed % policies.size()];
    settings.scenario = MissionOf("", seed).scenario;
    for (const std::string& finding : FindingsOf(DrawMission(settings, seed))) {
      ADD_FAILURE() << "seed " << seed << ", " << settings.policy << ": " << finding;
    }
  }
}

}  // namespace
}  // namespace muster::tools
