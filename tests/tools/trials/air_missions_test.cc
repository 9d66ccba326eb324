// Whole missions with zones: each passes the audit, which finds its own flights, and each of their
// decisions is made again.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/tools/trials/air_missions.h"
#include "tests/tools/trials/each_policy.h"
#include "tools/audit/auditor.h"
#include "tools/trials/campaign.h"

namespace muster::tools {
namespace {

class AirMissions : public ::testing::TestWithParam<std::string> {};

TEST_P(AirMissions, AreAuditedAndDecidedAgain) {
  // One in two policies on streets.
  const std::uint64_t seed = 3 + GetParam().size() % 2;
  for (const std::string& finding : FindingsOf(AirMission(GetParam(), seed))) {
    ADD_FAILURE() << "seed " << seed << ": " << finding;
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, AirMissions, ::testing::ValuesIn(AllPolicies()),
                         PolicyAsTestName);

// LongSoak has a thousand.
TEST(AirMissions, WithKillsAndLossAreAuditedAndDecidedAgain) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const VirtualMission mission = DrawAirMission(seed);
    for (const std::string& finding : FindingsOf(mission)) {
      ADD_FAILURE() << "seed " << seed << ", " << mission.policy << ": " << finding;
    }
  }
}

/// What the audit finds when the log says that a zone was larger than the one that UAVs flew
/// around.
TEST(AirMissions, AZoneThatUavsDoNotKeepOutOfIsFound) {
  int zones = 0, found = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    VirtualMission mission = RoadMission("certified", 2 * seed);
    mission.scenario.roads = nullptr;
    mission.scenario.ways = DefaultWays();
    ScenarioAir air;
    air.zones.push_back({{"", {CornersAround({7000, 7000}, 2500)}}, 20 * kMinuteUs, kNever});
    UseAir(std::move(air), &mission.scenario);
    audit::Auditor true_log, changed;
    Simulate(TextOf(mission.scenario), mission.policy, [&](const Packet& packet) {
      true_log.Add(packet);
      const auto orders = DecodeValid<orders_t>(packet.bytes);
      if (packet.channel != channel::kOrders || !orders || orders->n_taken == 0) {
        return changed.Add(packet);
      }
      ++zones;
      orders_t edited = *orders;
      edited.taken[0].json = R"({"order": "zone_add", "circle_km": [7, 7, 4.5]})";
      changed.Add({packet.channel, Encode(edited)});
    });
    for (const audit::Violation& v : true_log.Finish()) {
      ADD_FAILURE() << "seed " << seed << ": " << v.at_us << " us, " << v.invariant << ": "
                    << v.text;
    }
    found += changed.Finish().empty() ? 0 : 1;
  }
  EXPECT_EQ(zones, 6);
  EXPECT_GE(found, 5);
}

/// The world tells of it when a UAV comes there, or after ten minutes.
TEST(AirMissions, AZoneThatNobodyKnowsOfBecomesAnOrder) {
  VirtualMission mission = RoadMission("certified", 4);
  mission.scenario.roads = nullptr;
  mission.scenario.ways = DefaultWays();
  UseAir({}, &mission.scenario);
  const auto add = [&](const char* id, const char* circle) {
    PlannedFault& fault = mission.faults.emplace_back();
    fault.id = id;
    fault.kind = FaultKind::kZoneUnknown;
    fault.target = circle;
    fault.at_us = 20 * kMinuteUs;
  };
  add("busy", "7/7/4");
  add("lonely", "0.002/0.002/0.001");
  for (const std::string& finding : FindingsOf(mission)) ADD_FAILURE() << finding;

  std::map<std::string, double> told_min;
  mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t) {
    const auto orders = DecodeValid<orders_t>(event.packet->bytes);
    if (event.packet->channel != channel::kOrders || !orders) return;
    for (const taken_order_t& taken : orders->taken) {
      told_min[taken.id] = ToMinutes(mission.scenario.rules.TimeOf(orders->tick));
    }
  };
  RunVirtualMission(mission);
  ASSERT_EQ(told_min.count("fault:busy"), 1);
  EXPECT_GE(told_min["fault:busy"], 20);
  EXPECT_LT(told_min["fault:busy"], 25);
  EXPECT_EQ(told_min["fault:lonely"], 30);
}

}  // namespace
}  // namespace muster::tools
