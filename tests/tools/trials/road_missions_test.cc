// Whole missions by road: each passes the audit, which finds its own ways, and each of their
// decisions is made again.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/tools/trials/each_policy.h"
#include "tests/tools/trials/road_missions.h"
#include "tools/audit/auditor.h"
#include "tools/trials/campaign.h"

namespace muster::tools {
namespace {

class RoadMissions : public ::testing::TestWithParam<std::string> {};

TEST_P(RoadMissions, AreAuditedAndDecidedAgain) {
  const std::uint64_t seed = 1 + GetParam().size() % 2;
  for (const std::string& finding : FindingsOf(RoadMission(GetParam(), seed))) {
    ADD_FAILURE() << "seed " << seed << ": " << finding;
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, RoadMissions, ::testing::ValuesIn(AllPolicies()),
                         PolicyAsTestName);

TEST_P(RoadMissions, WithClosedRoadsAreAuditedAndDecidedAgain) {
  const std::uint64_t seed = 3 + GetParam().size() % 2;
  VirtualMission mission = RoadMission(GetParam(), seed);
  DrawClosures(seed, &mission);
  for (const std::string& finding : FindingsOf(mission)) {
    ADD_FAILURE() << "seed " << seed << ": " << finding;
  }
}

/// What the audit finds when the log says that other roads were closed, or for longer, than agents
/// went by.
TEST(RoadMissions, AClosureThatAgentsDoNotKeepIsFound) {
  int closures = 0, found = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    VirtualMission mission = RoadMission("certified", seed);
    ScenarioRoads roads = *mission.scenario.roads;
    roads.closures = {{{RoadArea::Circle{{7000, 7000}, 2500}}, "", 20 * kMinuteUs, kNever}};
    UseRoads(std::move(roads), "grid.roads.json", &mission.scenario);
    audit::Auditor true_log, changed;
    Simulate(TextOf(mission.scenario), mission.policy, [&](const Packet& packet) {
      true_log.Add(packet);
      const auto orders = DecodeValid<orders_t>(packet.bytes);
      if (packet.channel != channel::kOrders || !orders || orders->n_taken == 0) {
        return changed.Add(packet);
      }
      ++closures;
      orders_t edited = *orders;
      std::string& json = edited.taken[0].json;
      json.replace(json.find("2.5]"), 4, "4.5]");
      changed.Add({packet.channel, Encode(edited)});
    });
    EXPECT_TRUE(true_log.Finish().empty()) << "seed " << seed;
    found += changed.Finish().empty() ? 0 : 1;
  }
  EXPECT_EQ(closures, 6);
  EXPECT_GE(found, 5);
}

// LongSoak has a thousand.
TEST(RoadMissions, WithKillsAndLossAreAuditedAndDecidedAgain) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const VirtualMission mission = DrawRoadMission(seed);
    for (const std::string& finding : FindingsOf(mission)) {
      ADD_FAILURE() << "seed " << seed << ", " << mission.policy << ": " << finding;
    }
  }
}

}  // namespace
}  // namespace muster::tools
