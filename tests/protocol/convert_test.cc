#include "protocol/convert.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace muster {
namespace {

Scenario TwoOfEach() {
  Scenario scenario;
  AgentSpec agent;
  agent.speed_m_s = 10;
  agent.range_full_m = agent.range_m = 20'000;
  agent.online_until_us = 3600 * kSecondUs;
  scenario.uavs = scenario.workers = scenario.vehicles = {agent, agent};
  scenario.tasks = {{{3000, 4000}, 600}, {{100, 0}, 600}};
  scenario.charging_points = {{{0, 1000}, 1}, {{0, 2000}, 1}};
  return scenario;
}

AgentState MovingUav(const Scenario& scenario) {
  AgentState uav = StartOf(AgentKind::kUav, 1, scenario.uavs[1]);
  Action action;
  action.kind = ActionKind::kSense;
  action.uav = UavId(1);
  action.worker = WorkerId(0);
  action.task = TaskId(0);
  action.to = scenario.tasks[0].at;
  Begin(&uav, action, 2, 100 * kSecondUs, scenario.disturbances, scenario.seed);
  return uav;
}

TEST(Convert, AnAgentUnderWayComesBackAsItWas) {
  const Scenario scenario = TwoOfEach();
  const WireLimits limits(scenario);
  const AgentState uav = MovingUav(scenario);
  for (const TimeUs t : {130 * kSecondUs, 600 * kSecondUs, 900 * kSecondUs}) {
    const auto back = FromWire(ToWire(uav, t, scenario.tasks), AgentKind::kUav, t, limits);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->to, uav.to);
    EXPECT_EQ(PositionAt(*back, 450 * kSecondUs), PositionAt(uav, 450 * kSecondUs));
    EXPECT_EQ(RangeAt(*back, t, scenario.tasks), RangeAt(uav, t, scenario.tasks));
    EXPECT_EQ(back->busy_until_us, kNever);
    EXPECT_EQ(back->partner, 0);
  }
}

TEST(Convert, AFreeMoveUnderWayIsExtrapolated) {
  const Scenario scenario = TwoOfEach();
  AgentState uav = StartOf(AgentKind::kUav, 0, scenario.uavs[0]);
  Action action;
  action.kind = ActionKind::kGoTo;
  action.uav = UavId(0);
  action.to = {600, 800};
  Begin(&uav, action, 0, 0, {}, 1);
  const auto back = FromWire(ToWire(uav, 30 * kSecondUs, scenario.tasks), AgentKind::kUav,
                             30 * kSecondUs, WireLimits(scenario));
  ASSERT_TRUE(back);
  EXPECT_NEAR(Distance(back->to, action.to), 0, 1e-6);
}

TEST(Convert, ImpossibleReportsAreRefused) {
  const Scenario scenario = TwoOfEach();
  const WireLimits limits(scenario);
  const TimeUs t = 200 * kSecondUs;
  const agent_t good = ToWire(MovingUav(scenario), t, scenario.tasks);
  ASSERT_TRUE(FromWire(good, AgentKind::kUav, t, limits));
  const std::vector<std::function<void(agent_t*)>> lies = {
      [](agent_t* a) { a->id = 2; },
      [](agent_t* a) { a->id = -1; },
      [](agent_t* a) { a->action = 42; },
      [](agent_t* a) { a->target_id = 2; },
      [](agent_t* a) { a->partner_id = -1; },
      [](agent_t* a) { a->depart_us = 201 * kSecondUs; },
      [](agent_t* a) { a->arrive_us = a->depart_us - 1; },
      [](agent_t* a) { a->speed_m_s = std::numeric_limits<double>::quiet_NaN(); },
      [](agent_t* a) { a->speed_m_s = 0; },
      [](agent_t* a) { a->range_left_m = -1; },
      [](agent_t* a) { a->range_at_departure_m = std::numeric_limits<double>::quiet_NaN(); },
  };
  for (std::size_t i = 0; i < lies.size(); ++i) {
    agent_t bad = good;
    lies[i](&bad);
    EXPECT_FALSE(FromWire(bad, AgentKind::kUav, t, limits)) << "lie " << i;
  }
  EXPECT_FALSE(FromWire(good, AgentKind::kVehicle, t, limits));
}

TEST(Convert, ActionsActivitiesAndRulingsRoundTrip) {
  const Scenario scenario = TwoOfEach();
  const WireLimits limits(scenario);
  Action action;
  action.kind = ActionKind::kCharge;
  action.uav = UavId(1);
  action.vehicle = VehicleId(0);
  action.charge = ChargeId(1);
  action.to = {0, 2000};
  action.weight = 12.5;
  EXPECT_EQ(FromWire(ToWire(action), limits), action);
  action_t foreign = ToWire(action);
  foreign.charge_id = 2;
  EXPECT_FALSE(FromWire(foreign, limits));

  const Activity activity{Activity::Kind::kCharging, UavId(0), 1, 1, 5, 9};
  EXPECT_EQ(FromWire(ToWire(activity), limits), activity);
  activity_t backwards = ToWire(activity);
  backwards.end_us = 4;
  EXPECT_FALSE(FromWire(backwards, limits));

  const Ruling ruling{AgentKind::kVehicle, 1, Ruling::Kind::kReleased, 77};
  EXPECT_EQ(FromWire(ToWire(ruling), limits), ruling);
  ruling_t unknown = ToWire(ruling);
  unknown.kind = 2;
  EXPECT_FALSE(FromWire(unknown, limits));
}

}  // namespace
}  // namespace muster
