// Nothing but the seams (model/ways.h, and the audit's own) takes ways to be straight: whole
// missions by Manhattan ways pass the audit, and each of their decisions is made again.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "tests/cases.h"
#include "tests/model/manhattan_ways.h"
#include "tests/tools/trials/each_policy.h"
#include "tools/audit/ways.h"
#include "tools/trials/campaign.h"

namespace muster::tools {
namespace {

using muster::testing::InManhattan;

class AuditedManhattan : public audit::Ways {
 public:
  double Length(int, audit::Place from, audit::Place to) const override {
    return std::fabs(from.x_m - to.x_m) + std::fabs(from.y_m - to.y_m);
  }
  audit::Place After(int kind, audit::Place from, audit::Place to, double part) const override {
    const double east = std::fabs(to.x_m - from.x_m), north = std::fabs(to.y_m - from.y_m);
    const double gone = part * (east + north);
    if (gone < east) return audit::Ways::After(kind, from, {to.x_m, from.y_m}, gone / east);
    if (north == 0) return to;
    return audit::Ways::After(kind, {to.x_m, from.y_m}, to, (gone - east) / north);
  }
};

/// A third of Random_1, drawn where ways are as they are at that moment.
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
  mission.policy = policy;
  mission.fault_seed = seed;
  return mission;
}

class BentWays : public ::testing::TestWithParam<std::string> {};

TEST_P(BentWays, MissionsAreAuditedAndDecidedAgain) {
  const InManhattan bent;
  const audit::ScopedDefaultWays audited(std::make_shared<const AuditedManhattan>());
  for (const std::uint64_t seed : {1, 2}) {
    for (const std::string& finding : FindingsOf(MissionOf(GetParam(), seed))) {
      ADD_FAILURE() << "seed " << seed << ": " << finding;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, BentWays, ::testing::ValuesIn(AllPolicies()), PolicyAsTestName);

TEST(BentWays, MissionsWithKillsAndLossAreAuditedAndDecidedAgain) {
  const InManhattan bent;
  const audit::ScopedDefaultWays audited(std::make_shared<const AuditedManhattan>());
  for (std::uint64_t seed = 1; seed <= Cases(6, 15); ++seed) {
    // Not with free moves: a process that starts again finds the goal of one, but not where it
    // began, and so tells it anew from where it was last seen.
    CampaignSettings settings;
    settings.policy = seed % 3 == 0 ? "certified" : seed % 3 == 1 ? "horizon" : "rollout";
    for (const std::string& finding : FindingsOf(DrawMission(settings, seed))) {
      ADD_FAILURE() << "seed " << seed << ": " << finding;
    }
  }
}

TEST(BentWays, AnAuditByStraightWaysRefusesThem) {
  const InManhattan bent;
  EXPECT_FALSE(FindingsOf(MissionOf("horizon-steps", 1)).empty());
}

}  // namespace
}  // namespace muster::tools
