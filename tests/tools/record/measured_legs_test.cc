#include "tools/record/measured_legs.h"

#include <gtest/gtest.h>

#include "model/agent.h"

namespace muster::tools {
namespace {

/// A decision every 10 min, a tick every minute; a measured UAV of 10 m/s and a computed worker.
Scenario OneMeasured() {
  Scenario scenario;
  scenario.rules.tick_us = kMinuteUs;
  scenario.uavs.resize(1);
  scenario.uavs[0].measured = true;
  scenario.workers.resize(1);
  return scenario;
}

agent_t StandsAt(double x_m, std::int32_t decision, TimeUs arrive_us) {
  agent_t agent{};
  agent.id = 0;
  agent.x_m = x_m;
  agent.speed_m_s = 10;
  agent.decision = decision;
  agent.arrive_us = arrive_us;
  agent.action = decision < 0 ? NumberOf(ActionKind::kNone) : NumberOf(ActionKind::kGoTo);
  agent.status = NumberOf(AgentStatus::kMoving);
  return agent;
}

schedule_t Sends(std::int32_t uav, std::int32_t worker, double x_m, std::int32_t task) {
  action_t action{};
  action.uav_id = uav;
  action.worker_id = worker;
  action.vehicle_id = action.charge_id = -1;
  action.task_id = task;
  action.x_m = x_m;
  schedule_t schedule{};
  schedule.actions = {action};
  schedule.n = 1;
  return schedule;
}

TEST(MeasuredLegs, ArePlannedFromWhereTheAgentWasAndArriveAsTold) {
  const Scenario scenario = OneMeasured();
  MeasuredLegs legs;
  // Sent 600 m away at once: planned for 60 s, told to be 95 s. Words on later ticks say the same.
  for (const std::int64_t tick : {3, 2, 0, 1}) {
    const bool is_there = tick >= 2;
    legs.Take(scenario, AgentKind::kUav, tick,
              StandsAt(is_there ? 600 : 0, tick == 0 ? -1 : 0,
                       tick == 1 ? 120 * kSecondUs : 95 * kSecondUs));
  }
  // Sent back 300 m at 10 min, and elsewhere before it was there.
  legs.Take(scenario, AgentKind::kUav, 10, StandsAt(600, -1, 0));
  legs.Take(scenario, AgentKind::kUav, 11, StandsAt(500, 1, 12 * kMinuteUs));
  const auto list = legs.List(scenario, {{0, Sends(0, -1, 600, 4)}, {1, Sends(0, -1, 300, -1)}});
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].task, 4);
  EXPECT_DOUBLE_EQ(list[0].way_m, 600);
  EXPECT_EQ(list[0].planned_us, 60 * kSecondUs);
  EXPECT_EQ(list[0].arrived_us, 95 * kSecondUs);
  EXPECT_EQ(list[1].sent_us, 10 * kMinuteUs);
  EXPECT_EQ(list[1].planned_us, 10 * kMinuteUs + 30 * kSecondUs);
  EXPECT_FALSE(list[1].arrived_us);
  EXPECT_EQ(
      ToJson(list).dump(),
      R"([{"agent":"uav:0","legs":[{"decision":0,"task":4,"charge":-1,"way_m":600.0,)"
      R"("sent_s":0.0,"planned_s":60.0,"arrived_s":95.0},{"decision":1,"task":-1,"charge":-1,)"
      R"("way_m":300.0,"sent_s":600.0,"planned_s":630.0,"arrived_s":null}]}])");
}

TEST(MeasuredLegs, LeaveOutComputedAgentsAndWhoWasThere) {
  const Scenario scenario = OneMeasured();
  MeasuredLegs legs;
  legs.Take(scenario, AgentKind::kWorker, 0, StandsAt(0, -1, 0));
  legs.Take(scenario, AgentKind::kWorker, 1, StandsAt(60, 0, kMinuteUs));
  legs.Take(scenario, AgentKind::kUav, 10, StandsAt(597, -1, 0));
  legs.Take(scenario, AgentKind::kUav, 11, StandsAt(600, 1, 10 * kMinuteUs));
  EXPECT_TRUE(legs.List(scenario, {{0, Sends(-1, 0, 60, -1)}, {1, Sends(0, -1, 600, 4)}}).empty());
}

TEST(MeasuredLegs, DoNotCountAnArrivalOfWhoHasFailed) {
  const Scenario scenario = OneMeasured();
  MeasuredLegs legs;
  legs.Take(scenario, AgentKind::kUav, 0, StandsAt(0, -1, 0));
  agent_t failed = StandsAt(100, 0, 30 * kSecondUs);
  failed.status = NumberOf(AgentStatus::kFailed);
  legs.Take(scenario, AgentKind::kUav, 1, failed);
  const auto list = legs.List(scenario, {{0, Sends(0, -1, 600, -1)}});
  ASSERT_EQ(list.size(), 1u);
  EXPECT_FALSE(list[0].arrived_us);
}

}  // namespace
}  // namespace muster::tools
