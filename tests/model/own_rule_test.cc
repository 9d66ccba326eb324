#include "model/own_rule.h"

#include <gtest/gtest.h>

#include <memory>

#include "model/generator.h"

namespace muster {
namespace {

/// Charging points at 3 km, 4 km and 4 km from where UAVs start; UAVs fly 10 m/s and have 30 km.
class OwnRule : public ::testing::Test {
 protected:
  OwnRule() {
    scenario_.width_m = scenario_.height_m = 20e3;
    scenario_.charging_points = {{{14e3, 10e3}, 1}, {{10e3, 13e3}, 1}, {{6e3, 10e3}, 1}};
    scenario_.ways = DefaultWays();
  }
  AgentState Uav(double range_m, Point at = {10e3, 10e3}) const {
    AgentSpec spec;
    spec.at = at;
    spec.speed_m_s = 10;
    spec.range_full_m = 30e3;
    spec.range_m = range_m;
    spec.online_until_us = scenario_.rules.limit_us;
    return StartOf(AgentKind::kUav, 4, spec, *scenario_.ways);
  }

  Scenario scenario_;
};

TEST_F(OwnRule, BelowHalfItsRangeAUavGoesToTheNearestChargingPoint) {
  const auto action = OwnAction(Uav(14'999), 0, scenario_);
  ASSERT_TRUE(action);
  EXPECT_EQ(action->kind, ActionKind::kUavToCharge);
  EXPECT_EQ(action->uav, UavId(4));
  EXPECT_EQ(action->charge, ChargeId(1));
  EXPECT_EQ(action->to, (Point{10e3, 13e3}));
  EXPECT_TRUE(HasItsIds(*action));
  EXPECT_FALSE(OwnAction(Uav(15'000), 0, scenario_));
}

TEST_F(OwnRule, OfTwoThatAreAsNearTheLowerIdCounts) {
  const auto action = OwnAction(Uav(9e3, {10e3, 5e3}), 0, scenario_);
  ASSERT_TRUE(action);
  EXPECT_EQ(action->charge, ChargeId(0));  // 6.4 km, as charge:2; charge:1 is 8 km away
}

TEST_F(OwnRule, ItStaysWhereItsRangeOrItsTimeIsTooShort) {
  EXPECT_TRUE(OwnAction(Uav(3'000), 0, scenario_));
  EXPECT_FALSE(OwnAction(Uav(2'999), 0, scenario_));
  const TimeUs limit = scenario_.rules.limit_us;
  EXPECT_TRUE(OwnAction(Uav(9e3), limit - 300 * kSecondUs, scenario_));
  EXPECT_FALSE(OwnAction(Uav(9e3), limit - 300 * kSecondUs + 1, scenario_));
}

TEST_F(OwnRule, ItStaysAtAChargingPoint) {
  EXPECT_FALSE(OwnAction(Uav(9e3, {10e3, 13e3}), 0, scenario_));
}

TEST_F(OwnRule, WhatIsBegunIsFinished) {
  AgentState busy = Uav(9e3);
  busy.busy_until_us = kMinuteUs;
  EXPECT_FALSE(OwnAction(busy, kMinuteUs - 1, scenario_));
  EXPECT_TRUE(OwnAction(busy, kMinuteUs, scenario_));
}

TEST_F(OwnRule, UavsThatAreKeptApartStay) {
  scenario_.air = std::make_shared<const ScenarioAir>();
  EXPECT_FALSE(OwnAction(Uav(9e3), 0, scenario_));
}

TEST_F(OwnRule, WorkersAndVehiclesStay) {
  for (const AgentKind kind : {AgentKind::kWorker, AgentKind::kVehicle}) {
    AgentSpec spec;
    spec.at = {10e3, 10e3};
    spec.speed_m_s = 5;
    spec.online_until_us = scenario_.rules.limit_us;
    EXPECT_FALSE(OwnAction(StartOf(kind, 0, spec, *scenario_.ways), 0, scenario_));
  }
}

}  // namespace
}  // namespace muster
