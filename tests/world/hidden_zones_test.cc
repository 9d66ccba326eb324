// Zones that a fault makes, of which nobody knows until a UAV comes to one.
#include <gtest/gtest.h>

#include <vector>

#include "model/order.h"
#include "world/hidden_closures.h"

namespace muster::world {
namespace {

/// A UAV flies to the east at 10 m/s, through a square of 200 m. With its margin of 30 m the square
/// begins after 370 m and ends after 630 m.
class HiddenZoneTest : public ::testing::Test {
 protected:
  HiddenZoneTest() {
    scenario_.width_m = scenario_.height_m = 2000;
    scenario_.uavs = {{.at = {0, 1000}, .speed_m_s = 10, .range_full_m = 9000, .range_m = 9000}};
    scenario_.workers = {{.at = {500, 1000}, .speed_m_s = 1}};
    scenario_.tasks = {{.at = {1000, 1000}, .cost_m = 100}};
    UseAir({}, &scenario_);
    action_.kind = ActionKind::kUavToTask;
    action_.uav = UavId(0);
    action_.task = TaskId(0);
    action_.to = {1000, 1000};
    scenario_.uavs[0].online_until_us = scenario_.workers[0].online_until_us = kNever;
    for (const AgentKind kind : {AgentKind::kUav, AgentKind::kWorker}) {
      agents_[kind].push_back(StartOf(kind, 0, scenario_.agents(kind)[0], *scenario_.ways));
    }
  }
  AgentState& uav() { return agents_.uavs[0]; }
  void SetOut() { Begin(&uav(), action_, 0, 0, {}, 0); }
  bool IsKnown(TimeUs t, const std::vector<Action>& commanded = {}) const {
    return IsToldOrMet(closure_, t, scenario_, agents_, {commanded, 0, 0});
  }

  Scenario scenario_;
  Action action_;
  Agents agents_;
  HiddenClosure closure_{Zone{"", {{{400, 900}, {600, 900}, {600, 1100}, {400, 1100}}}},
                         20 * kSecondUs, kNever, "f"};
};

TEST_F(HiddenZoneTest, IsKnownWhenAUavComesToIt) {
  SetOut();
  EXPECT_FALSE(IsKnown(36'900'000));
  EXPECT_TRUE(IsKnown(37'010'000));
  // Also of a UAV that was through it between two ticks.
  EXPECT_TRUE(IsKnown(80 * kSecondUs));
}

TEST_F(HiddenZoneTest, AUavThatHasItsCommandAndNotReportedCounts) {
  EXPECT_FALSE(IsKnown(37'010'000));
  EXPECT_FALSE(IsKnown(36'900'000, {action_}));
  EXPECT_TRUE(IsKnown(37'010'000, {action_}));
}

TEST_F(HiddenZoneTest, OneThatHasPassedOrFailedDoesNot) {
  SetOut();
  closure_.from_us = 63'100'000;
  EXPECT_FALSE(IsKnown(80 * kSecondUs));
  closure_.from_us = 62'900'000;
  EXPECT_TRUE(IsKnown(80 * kSecondUs));
  uav().failed = true;
  EXPECT_FALSE(IsKnown(80 * kSecondUs));
}

TEST_F(HiddenZoneTest, AUavThatStandsInsideCountsAndAWorkerDoesNot) {
  uav().from = uav().to = {369, 1000};
  EXPECT_FALSE(IsKnown(20 * kSecondUs));
  uav().from = uav().to = {371, 1000};
  EXPECT_FALSE(IsKnown(19 * kSecondUs));
  EXPECT_TRUE(IsKnown(20 * kSecondUs));
}

TEST_F(HiddenZoneTest, AnotherZoneDoesNotCount) {
  SetOut();
  Order other = ParseOrder(R"({"order": "zone_add", "circle_km": [0.2, 1, 0.1]})", "order");
  other.id = "known";
  TakeInto(&scenario_, other, 0);
  agents_.uavs[0] = StartOf(AgentKind::kUav, 0, scenario_.uavs[0], *scenario_.ways);
  SetOut();  // around the known zone
  EXPECT_FALSE(IsKnown(36'900'000));
  EXPECT_TRUE(IsKnown(45 * kSecondUs));
}

TEST_F(HiddenZoneTest, IsToldAfterAWhileAndNotWhenItIsOver) {
  EXPECT_FALSE(IsKnown(closure_.from_us + kToldAfterUs - 1));
  EXPECT_TRUE(IsKnown(closure_.from_us + kToldAfterUs));
  closure_.until_us = closure_.from_us + kToldAfterUs;
  EXPECT_FALSE(IsKnown(closure_.from_us + kToldAfterUs));
}

TEST_F(HiddenZoneTest, ItsOrderMakesTheZone) {
  closure_.until_us = 600 * kSecondUs;
  Order order = ParseOrder(OrderOf(closure_, 60 * kSecondUs, scenario_.rules), "order");
  order.id = OrderIdOf(closure_);
  EXPECT_EQ(order.until_us, 600 * kSecondUs);
  const double straight_m = scenario_.ways->Length(AgentKind::kUav, {0, 1000}, {1000, 1000});
  TakeInto(&scenario_, order, 60 * kSecondUs);
  EXPECT_EQ(straight_m, 1000);
  EXPECT_GT(scenario_.ways->Length(AgentKind::kUav, {0, 1000}, {1000, 1000}), 1020);
  EXPECT_EQ(scenario_.closures.at(0).zone->rings, std::get<Zone>(closure_.of).rings);
}

TEST_F(HiddenZoneTest, ACircleOfAFaultBecomesAZoneOrClosesRoads) {
  const RoadArea circle{RoadArea::Circle{{500, 1000}, 100}};
  const HiddenClosure zone = HiddenIn(FaultKind::kZoneUnknown, circle, 1, 2, "f");
  EXPECT_EQ(std::get<Zone>(zone.of).rings.at(0).size(), 16);
  EXPECT_TRUE(IsPossible(zone, scenario_));
  const HiddenClosure roads = HiddenIn(FaultKind::kRoadClosed, circle, 1, 2, "f");
  EXPECT_TRUE(std::holds_alternative<RoadArea>(roads.of));
  EXPECT_FALSE(IsPossible(roads, scenario_));
  scenario_.air = nullptr;
  EXPECT_FALSE(IsPossible(zone, scenario_));
}

}  // namespace
}  // namespace muster::world
