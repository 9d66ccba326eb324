// Roads that the world closes and opens by itself: as planned, at the end of a closure, and when an
// agent stands before one that a fault has closed.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "model/order.h"
#include "tests/model/block.h"
#include "world/hidden_closures.h"
#include "world/order_desk.h"

namespace muster::world {
namespace {

using muster::testing::OnTheBlock;

Agents AgentsOf(const Scenario& scenario) {
  Agents agents;
  for (const AgentKind kind : kAgentKinds) {
    for (AgentSpec spec : scenario.agents(kind)) {
      spec.online_until_us = kNever;
      const auto id = static_cast<std::int32_t>(agents[kind].size());
      agents[kind].push_back(StartOf(kind, id, spec, *scenario.ways));
    }
  }
  return agents;
}

Scenario Planned(TimeUs from_us, TimeUs until_us) {
  Scenario scenario = OnTheBlock();
  ScenarioRoads roads = *scenario.roads;
  roads.closures = {{{RoadArea::Ids{{10}}}, "flood", from_us, until_us}};
  UseRoads(std::move(roads), "block.roads.json", &scenario);
  return scenario;
}

orders_t Decide(OrderDesk* desk, std::int64_t tick) {
  const std::vector<TaskStatus> status(desk->scenario().tasks.size(), TaskStatus::kOpen);
  orders_t said = desk->Decide(tick, status, AgentsOf(desk->scenario()));
  said.header.sender = process_name::kWorld;
  EXPECT_TRUE(Valid(said));
  desk->Take(said);
  return said;
}

TEST(PlannedClosures, CloseAndOpenAtTheFirstTickThatIsNotBefore) {
  // Ticks are 30 s.
  OrderDesk desk(Planned(45 * kSecondUs, 100 * kSecondUs), {});
  EXPECT_TRUE(desk.book().takes_orders());
  EXPECT_EQ(Decide(&desk, 0).n_taken, 0);
  EXPECT_EQ(Decide(&desk, 1).n_taken, 0);
  orders_t said = Decide(&desk, 2);
  ASSERT_EQ(said.n_taken, 1);
  EXPECT_EQ(said.taken[0].id, "closure:0");
  ASSERT_EQ(desk.scenario().closures.size(), 1);
  EXPECT_EQ(desk.scenario().closures[0].name, "flood");
  EXPECT_EQ(desk.scenario().closures[0].since_us, 60 * kSecondUs);
  EXPECT_EQ(Decide(&desk, 3).n_taken, 0);
  said = Decide(&desk, 4);
  ASSERT_EQ(said.n_taken, 1);
  EXPECT_EQ(said.taken[0].id, "open:closure:0");
  EXPECT_TRUE(desk.scenario().closures.empty());
}

/// A world that starts again knows from the book alone what it has still to open.
TEST(PlannedClosures, AreOpenedByAWorldThatStartsAgain) {
  OrderDesk desk(Planned(0, 100 * kSecondUs), {});
  for (int tick = 0; tick < 3; ++tick) Decide(&desk, tick);
  OrderDesk again(Planned(0, 100 * kSecondUs), {});
  ASSERT_TRUE(again.Take(desk.book().ToWire()));
  EXPECT_EQ(again.scenario().closures.size(), 1);
  EXPECT_EQ(Decide(&again, 3).n_taken, 0);
  EXPECT_EQ(Decide(&again, 4).taken[0].id, "open:closure:0");
}

TEST(PlannedClosures, WhatSomebodyHasOpenedIsNotOpenedAgain) {
  OrderDesk desk(Planned(0, 100 * kSecondUs), {});
  Decide(&desk, 0);
  desk.Give("mine", R"({"order": "road_open", "roads": [10]})");
  EXPECT_EQ(Decide(&desk, 1).n_taken, 1);
  const orders_t said = Decide(&desk, 4);
  EXPECT_EQ(said.n_taken + said.n_refused, 0);
}

class HiddenClosureTest : public ::testing::Test {
 protected:
  /// The worker sets out from the west end to the task at the east end at time 0, at 1 m/s.
  HiddenClosureTest() {
    action_.kind = ActionKind::kWorkerToTask;
    action_.worker = WorkerId(0);
    action_.task = TaskId(0);
    action_.to = {1000, 0};
  }
  bool IsKnown(TimeUs t, bool is_under_way = true) {
    Agents agents = AgentsOf(scenario_);
    const std::vector<Action> commanded = {action_};
    if (is_under_way) Begin(&agents.at(AgentKind::kWorker, 0), action_, 0, 0, {}, 0);
    return IsToldOrMet(closure_, t, scenario_, agents, {commanded, 0, 0});
  }

  const Scenario scenario_ = OnTheBlock();
  /// Of the street that begins after 400 m.
  HiddenClosure closure_{RoadArea{RoadArea::Ids{{11}}}, 350 * kSecondUs, kNever, "f"};
  Action action_;
};

TEST_F(HiddenClosureTest, IsKnownWhenAnAgentStandsBeforeIt) {
  EXPECT_FALSE(IsKnown(349 * kSecondUs));
  EXPECT_FALSE(IsKnown(399 * kSecondUs));
  EXPECT_TRUE(IsKnown(400 * kSecondUs));
  // An agent that has its command but has not reported yet counts as well.
  EXPECT_TRUE(IsKnown(400 * kSecondUs, false));
  // One that has passed by then does not.
  closure_.from_us = 1'000 * kSecondUs;
  EXPECT_FALSE(IsKnown(1'010 * kSecondUs));
}

TEST_F(HiddenClosureTest, IsToldAfterAWhileAndNotWhenItIsOver) {
  closure_.of = RoadArea{RoadArea::Ids{{20}}};  // nobody comes there
  EXPECT_FALSE(IsKnown(closure_.from_us + kToldAfterUs - 1));
  EXPECT_TRUE(IsKnown(closure_.from_us + kToldAfterUs));
  closure_.until_us = closure_.from_us + kToldAfterUs;
  EXPECT_FALSE(IsKnown(closure_.from_us + kToldAfterUs));
}

TEST_F(HiddenClosureTest, ItsOrderSaysSinceWhenWithinTheLastTick) {
  closure_.until_us = 600 * kSecondUs;
  const auto order_at = [&](TimeUs t) {
    Order order = ParseOrder(OrderOf(closure_, t, scenario_.rules), "order");
    order.id = OrderIdOf(closure_);
    Scenario scenario = scenario_;
    TakeInto(&scenario, order, t);  // is possible
    return order;
  };
  EXPECT_EQ(order_at(360 * kSecondUs).since_us, 350 * kSecondUs);
  EXPECT_EQ(order_at(420 * kSecondUs).since_us, 390 * kSecondUs);
  EXPECT_EQ(order_at(420 * kSecondUs).until_us, 600 * kSecondUs);
}

}  // namespace
}  // namespace muster::world
