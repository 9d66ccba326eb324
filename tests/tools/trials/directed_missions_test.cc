// Whole missions in which the commander pins, forbids and sends: each passes the audit, which has
// its own rules for directives, and each of their decisions is made again.
#include <gtest/gtest.h>

#include <string>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "tests/simulation/order_draws.h"
#include "tests/tools/trials/directed_missions.h"
#include "tests/tools/trials/each_policy.h"
#include "tools/audit/auditor.h"
#include "tools/explain/story.h"
#include "tools/trials/campaign.h"

namespace muster::tools {
namespace {

class DirectedMissions : public ::testing::TestWithParam<std::string> {};

TEST_P(DirectedMissions, AreAuditedAndDecidedAgain) {
  const std::uint64_t seed = 5 + GetParam().size() % 2;
  for (const std::string& finding : FindingsOf(DirectedMission(GetParam(), seed))) {
    ADD_FAILURE() << "seed " << seed << ": " << finding;
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, DirectedMissions, ::testing::ValuesIn(AllPolicies()),
                         PolicyAsTestName);

TEST(DirectedMissions, WithKillsAndLossAreAuditedAndDecidedAgain) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const VirtualMission mission = DrawDirectedMission(seed);
    for (const std::string& finding : FindingsOf(mission)) {
      ADD_FAILURE() << "seed " << seed << ", " << mission.policy << ": " << finding;
    }
  }
}

TEST(DirectedMissions, AreExplainedFromTheTickOnAtWhichTheyWereDirected) {
  VirtualMission mission = RoadMission("certified", 2);
  mission.scenario.roads = nullptr;
  mission.scenario.ways = DefaultWays();
  AddRoom({1, {}}, &mission.scenario);
  const std::string go =
      R"({"id": "g", "at_min": 22, "order": "go_to", "agent": "worker:0", "x_km": 1, "y_km": 1})";
  mission.orders = {{ParseOrder(go, "order"), go}};
  Packets log;
  mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t) {
    log.all.push_back(*event.packet);
  };
  RunVirtualMission(mission);
  std::size_t before = 0, told = 0;
  for (const auto& chapter :
       TellAgent(ReadDecisionLog(&log), "", AgentKind::kWorker, 0, {}).chapters) {
    if (chapter.at_us >= 22 * kMinuteUs) {
      told += chapter.directives.size();  // none while it is on its way there
      continue;
    }
    ++before;
    EXPECT_TRUE(chapter.directives.empty()) << "decision " << chapter.decision;
  }
  EXPECT_GE(before, 2U);
  EXPECT_GE(told, 2U);
}

/// What the audit finds when the log says that other agents were pinned, or another task forbidden.
TEST(DirectedMissions, DirectivesThatAreNotKeptAreFound) {
  int changed_orders = 0, found = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    VirtualMission mission = RoadMission("certified", 2 * seed);
    mission.scenario.roads = nullptr;
    mission.scenario.ways = DefaultWays();
    AddRoom({1, {}}, &mission.scenario);
    mission.orders.clear();
    const std::string forbid =
        R"({"id": "f", "at_min": 10, "order": "forbid", "class": "vehicle", "circle_km": [1, 1, 0.1]})";
    mission.orders.push_back({ParseOrder(forbid, "order"), forbid});
    audit::Auditor true_log, changed;
    mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t) {
      true_log.Add(*event.packet);
      const auto orders = DecodeValid<orders_t>(event.packet->bytes);
      if (event.packet->channel != channel::kOrders || !orders || orders->n_taken == 0) {
        return changed.Add(*event.packet);
      }
      ++changed_orders;
      orders_t edited = *orders;
      edited.taken[0].json = R"({"order": "forbid", "class": "worker", "circle_km": [7, 7, 5]})";
      changed.Add({event.packet->channel, Encode(edited)});
    };
    RunVirtualMission(mission);
    EXPECT_TRUE(true_log.Finish().empty()) << "seed " << seed;
    for (const audit::Violation& violation : changed.Finish()) {
      found += violation.invariant == "directives" ? 1 : 0;
    }
  }
  EXPECT_EQ(changed_orders, 8);
  EXPECT_GE(found, 8);
}

}  // namespace
}  // namespace muster::tools
