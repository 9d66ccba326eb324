#include "scheduler/fusion.h"

#include <gtest/gtest.h>

namespace muster::scheduler {
namespace {

constexpr TimeUs kNow = 600 * kSecondUs;
constexpr std::int64_t kTick = 20;

/// Two of each agent, the second UAV 3 km from the task; two tasks, two charging points.
Scenario TwoOfEach() {
  Scenario scenario;
  scenario.width_m = scenario.height_m = 10'000;
  AgentSpec agent;
  agent.speed_m_s = 10;
  agent.range_full_m = agent.range_m = 20'000;
  agent.charge_rate_m_s = 50;
  agent.online_until_us = 3600 * kSecondUs;
  scenario.uavs = scenario.workers = scenario.vehicles = {agent, agent};
  scenario.tasks = {{{3000, 4000}, 600}, {{3000, 0}, 600}};
  scenario.charging_points = {{{0, 1000}, 1}, {{0, 2000}, 2}};
  return scenario;
}

agent_states_t States(const Scenario& scenario, const std::vector<AgentState>& agents,
                      std::int64_t tick = kTick) {
  agent_states_t states{};
  states.kind = static_cast<std::int8_t>(agents.front().kind);
  states.tick = tick;
  for (const AgentState& agent : agents) {
    states.agents.push_back(ToWire(agent, kNow, scenario.tasks));
  }
  states.n = static_cast<std::int32_t>(states.agents.size());
  return states;
}

std::vector<AgentState> Start(const Scenario& scenario, AgentKind kind) {
  std::vector<AgentState> agents;
  for (const AgentSpec& spec : scenario.agents(kind)) {
    agents.push_back(StartOf(kind, static_cast<std::int32_t>(agents.size()), spec, StraightWays()));
  }
  return agents;
}

world_state_t World(const std::vector<Activity>& activities = {}, std::int64_t tick = kTick) {
  world_state_t world{};
  world.tick = tick;
  world.task_status = {0, 0};
  world.n_tasks = 2;
  for (const Activity& activity : activities) world.activities.push_back(ToWire(activity));
  world.n_activities = static_cast<std::int32_t>(world.activities.size());
  return world;
}

rulings_t Rulings(const std::vector<Ruling>& rulings = {}, std::int64_t tick = kTick) {
  rulings_t message{};
  message.tick = tick;
  for (const Ruling& ruling : rulings) message.rulings.push_back(ToWire(ruling));
  message.n = static_cast<std::int32_t>(message.rulings.size());
  return message;
}

Ruling Failed(AgentKind kind, std::int32_t id) { return {kind, id, Ruling::Kind::kFailed, kNow}; }

class FusionTest : public ::testing::Test {
 protected:
  FusionTest() { fusion_.Start(kTick, kNow, 1); }

  void TakeAgents(AgentKind kind) {
    EXPECT_TRUE(fusion_.Take(States(scenario_, Start(scenario_, kind))));
  }
  void TakeAllAgents() {
    for (const AgentKind kind : kAgentKinds) TakeAgents(kind);
  }

  Scenario scenario_ = TwoOfEach();
  OrderBook book_{scenario_};
  Fusion fusion_{book_.scenario()};
};

TEST_F(FusionTest, IsCompleteWhenEveryAgentAndTheWorldHaveSpoken) {
  TakeAllAgents();
  EXPECT_FALSE(fusion_.complete());
  EXPECT_TRUE(fusion_.Take(World()));
  EXPECT_FALSE(fusion_.complete());
  EXPECT_TRUE(fusion_.Take(Rulings()));
  EXPECT_TRUE(fusion_.complete());
  const Situation situation = fusion_.Fuse(book_);
  EXPECT_EQ(situation.decision, 1);
  EXPECT_EQ(situation.now_us, kNow);
  for (const AgentKind kind : kAgentKinds) {
    ASSERT_EQ(situation.agents(kind).size(), 2u);
    EXPECT_EQ(situation.agents(kind)[1].id, 1);
  }
  EXPECT_EQ(situation.charging_load, (std::vector<std::int32_t>{0, 0}));
}

TEST_F(FusionTest, OrdersOfLaterTicksDoNotCount) {
  AddRoom({1, {}}, &scenario_);
  OrderBook book(scenario_);
  Fusion fusion(book.scenario());
  const auto say = [&](std::int64_t tick, std::int64_t before, const char* json) {
    orders_t said{};
    said.tick = tick;
    said.before = before;
    Scenario scenario = *book.scenario();
    said.taken = {ToWire(TakeInto(&scenario, ParseOrder(json, "order"), kNow), json)};
    said.taken.front().id = json;
    said.n_taken = 1;
    for (std::int64_t t = book.tick() + 1; t < tick; ++t) {
      orders_t none{};
      none.tick = t;
      none.before = before;
      ASSERT_TRUE(book.Take(none));
    }
    ASSERT_TRUE(book.Take(said));
  };
  const auto priority = [&] {
    fusion.Start(kTick, kNow, 1);
    for (const AgentKind kind : kAgentKinds) {
      EXPECT_TRUE(fusion.Take(States(scenario_, Start(scenario_, kind))));
    }
    world_state_t world = World();
    world.task_status.push_back(NumberOf(TaskStatus::kUnreported));
    world.n_tasks = static_cast<std::int32_t>(world.task_status.size());
    EXPECT_TRUE(fusion.Take(world) && fusion.Take(Rulings()));
    return fusion.Fuse(book).site->tasks[0].priority;
  };
  say(kTick, 0, R"({"order": "task_change", "task": 0, "priority": 2})");
  EXPECT_EQ(priority(), Priority::kHigh);
  say(kTick + 1, 1, R"({"order": "task_change", "task": 0, "priority": 3})");
  EXPECT_EQ(priority(), Priority::kHigh);
}

TEST_F(FusionTest, AnAgentThatSaysTheSameAgainCountsOnce) {
  TakeAgents(AgentKind::kUav);
  TakeAgents(AgentKind::kUav);
  TakeAgents(AgentKind::kUav);
  EXPECT_TRUE(fusion_.Take(World()));
  EXPECT_TRUE(fusion_.Take(Rulings()));
  EXPECT_FALSE(fusion_.complete());
}

TEST_F(FusionTest, WhatIsSaidOfAnotherTickIsLeftOut) {
  for (const AgentKind kind : kAgentKinds) {
    EXPECT_TRUE(fusion_.Take(States(scenario_, Start(scenario_, kind), kTick - 1)));
  }
  EXPECT_TRUE(fusion_.Take(World({}, kTick - 1)));
  EXPECT_TRUE(fusion_.Take(Rulings({}, kTick - 1)));
  EXPECT_FALSE(fusion_.complete());
  TakeAllAgents();
  EXPECT_FALSE(fusion_.complete());
  EXPECT_TRUE(fusion_.Take(World()));
  EXPECT_FALSE(fusion_.complete());
  EXPECT_TRUE(fusion_.Take(Rulings()));
  EXPECT_TRUE(fusion_.complete());
}

TEST_F(FusionTest, OnlyAnAgentThatHasFailedMayBeSilent) {
  std::vector<AgentState> first = Start(scenario_, AgentKind::kUav);
  first.pop_back();
  EXPECT_TRUE(fusion_.Take(States(scenario_, first)));
  TakeAgents(AgentKind::kWorker);
  TakeAgents(AgentKind::kVehicle);
  EXPECT_TRUE(fusion_.Take(World()));
  // The first UAV has spoken and failed; the second is released, which is no failure.
  EXPECT_TRUE(fusion_.Take(
      Rulings({Failed(AgentKind::kUav, 0), {AgentKind::kUav, 1, Ruling::Kind::kReleased, kNow}})));
  EXPECT_FALSE(fusion_.complete());

  fusion_.Start(kTick, kNow, 1);
  EXPECT_TRUE(fusion_.Take(States(scenario_, first)));
  TakeAgents(AgentKind::kWorker);
  TakeAgents(AgentKind::kVehicle);
  EXPECT_TRUE(fusion_.Take(World()));
  EXPECT_TRUE(fusion_.Take(Rulings({Failed(AgentKind::kUav, 1)})));
  ASSERT_TRUE(fusion_.complete());
  const Situation situation = fusion_.Fuse(book_);
  ASSERT_EQ(situation.uavs.size(), 1u);
  EXPECT_EQ(situation.uavs[0].id, 0);
}

TEST_F(FusionTest, WhoHasFailedIsNotOffered) {
  TakeAllAgents();
  EXPECT_TRUE(fusion_.Take(World()));
  EXPECT_TRUE(fusion_.Take(Rulings({Failed(AgentKind::kUav, 0), Failed(AgentKind::kWorker, 1),
                                    Failed(AgentKind::kVehicle, 0)})));
  const Situation situation = fusion_.Fuse(book_);
  const auto only = [](const std::vector<AgentState>& agents) {
    return agents.size() == 1 ? agents[0].id : -1;
  };
  EXPECT_EQ(only(situation.uavs), 1);
  EXPECT_EQ(only(situation.workers), 0);
  EXPECT_EQ(only(situation.vehicles), 1);
}

TEST_F(FusionTest, WhoIsOfflineIsOfferedOnlyWhileItIsBusy) {
  scenario_.uavs[0].online_until_us = scenario_.uavs[1].online_until_us = kNow;
  std::vector<AgentState> uavs = Start(scenario_, AgentKind::kUav);
  Action go;
  go.kind = ActionKind::kUavToTask;
  go.uav = UavId(1);
  go.task = TaskId(1);
  go.to = scenario_.tasks[1].at;  // 300 s
  Begin(&uavs[1], go, 0, kNow - 299 * kSecondUs, {}, 1);
  EXPECT_TRUE(fusion_.Take(States(scenario_, uavs)));
  TakeAgents(AgentKind::kWorker);
  TakeAgents(AgentKind::kVehicle);
  EXPECT_TRUE(fusion_.Take(World()));
  EXPECT_TRUE(fusion_.Take(Rulings()));
  const Situation situation = fusion_.Fuse(book_);
  ASSERT_EQ(situation.uavs.size(), 1u);
  EXPECT_EQ(situation.uavs[0].id, 1);
  EXPECT_FALSE(situation.uavs[0].idle(kNow));
  EXPECT_EQ(situation.charging_load, (std::vector<std::int32_t>{0, 0}));
}

TEST_F(FusionTest, AUavThatChargesTakesAPlaceUntilItsChargingHasEnded) {
  std::vector<AgentState> uavs = Start(scenario_, AgentKind::kUav);
  std::vector<AgentState> vehicles = Start(scenario_, AgentKind::kVehicle);
  std::vector<Activity> activities;
  for (std::int32_t i = 0; i < 2; ++i) {
    Action charge;
    charge.kind = ActionKind::kCharge;
    charge.uav = UavId(i);
    charge.vehicle = VehicleId(i);
    charge.charge = ChargeId(1);
    charge.to = scenario_.charging_points[1].at;
    const auto at = static_cast<std::size_t>(i);
    // 200 s of way, then 2 km at 50 m/s: until 240 s after it began.
    const TimeUs begin = kNow - (i == 0 ? 240 : 239) * kSecondUs;
    Begin(&uavs[at], charge, 0, begin, {}, 1);
    Begin(&vehicles[at], charge, 0, begin, {}, 1);
    activities.push_back(PlanActivity(uavs[at], vehicles[at], scenario_.tasks));
  }
  EXPECT_TRUE(fusion_.Take(States(scenario_, uavs)));
  EXPECT_TRUE(fusion_.Take(States(scenario_, vehicles)));
  TakeAgents(AgentKind::kWorker);
  EXPECT_TRUE(fusion_.Take(World(activities)));
  EXPECT_TRUE(fusion_.Take(Rulings()));
  const Situation situation = fusion_.Fuse(book_);
  EXPECT_TRUE(situation.uavs[0].idle(kNow));
  EXPECT_EQ(situation.range_m(situation.uavs[0]), 20'000);
  EXPECT_FALSE(situation.uavs[1].idle(kNow));
  EXPECT_EQ(situation.charging_load, (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(situation.free_places(ChargeId(0)), 1);
  EXPECT_EQ(situation.free_places(ChargeId(1)), 1);
}

TEST_F(FusionTest, OfAMessageThatCannotBeNothingIsTaken) {
  agent_states_t states = States(scenario_, Start(scenario_, AgentKind::kUav));
  states.agents[1].id = 2;
  EXPECT_FALSE(fusion_.Take(states));
  world_state_t world = World();
  world.task_status.pop_back();
  EXPECT_FALSE(fusion_.Take(world));
  world = World({{Activity::Kind::kSensing, UavId(0), 5, 0, 0, kNow}});
  EXPECT_FALSE(fusion_.Take(world));
  EXPECT_FALSE(fusion_.Take(Rulings({Failed(AgentKind::kUav, 2)})));
  TakeAgents(AgentKind::kWorker);
  TakeAgents(AgentKind::kVehicle);
  EXPECT_FALSE(fusion_.complete());
  TakeAgents(AgentKind::kUav);
  EXPECT_FALSE(fusion_.complete());
  EXPECT_TRUE(fusion_.Take(World()));
  EXPECT_FALSE(fusion_.complete());
  EXPECT_TRUE(fusion_.Take(Rulings()));
  EXPECT_TRUE(fusion_.complete());
}

TEST_F(FusionTest, TheFirstWordOfTheWorldStands) {
  TakeAllAgents();
  EXPECT_TRUE(fusion_.Take(World()));
  EXPECT_TRUE(fusion_.Take(Rulings()));
  EXPECT_TRUE(fusion_.Take(Rulings({Failed(AgentKind::kUav, 0)})));
  world_state_t other = World();
  other.task_status = {3, 3};
  EXPECT_TRUE(fusion_.Take(other));
  const Situation situation = fusion_.Fuse(book_);
  EXPECT_EQ(situation.uavs.size(), 2u);
  EXPECT_EQ(situation.task_status[0], TaskStatus::kOpen);
}

}  // namespace
}  // namespace muster::scheduler
