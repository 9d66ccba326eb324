#include "world/order_desk.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "lcmtypes/bus/codec.h"
#include "model/generator.h"

namespace muster::world {
namespace {

class OrderDeskTest : public ::testing::Test {
 protected:
  OrderDeskTest() {
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentSpec& spec : scenario_.agents(kind)) {
        const auto id = static_cast<std::int32_t>(agents_[kind].size());
        agents_[kind].push_back(StartOf(kind, id, spec, StraightWays()));
      }
    }
  }
  static Scenario Roomy() {
    Scenario scenario = Generate(PresetByName("Random_1"), 1);
    AddRoom({1, {}}, &scenario);
    return scenario;
  }
  bool Hear(const std::string& id, const std::string& json) {
    order_t order{};
    order.id = id;
    order.issuer = "test";
    order.json = json;
    return desk_.Hear(order);
  }
  /// What is said at that tick, as a message.
  orders_t Decide(std::int64_t tick) {
    orders_t said = desk_.Decide(tick, status_, agents_);
    said.header.sender = process_name::kWorld;
    EXPECT_TRUE(Valid(said));
    desk_.Take(said);
    return said;
  }

  const Scenario scenario_ = Roomy();
  OrderDesk desk_{scenario_, {}};
  Agents agents_;
  std::vector<TaskStatus> status_ = std::vector<TaskStatus>(121, TaskStatus::kOpen);
};

TEST_F(OrderDeskTest, TakesEachOrderOnce) {
  const std::string add = R"({"order": "task_add", "task": {"x_km": 1, "y_km": 2}})";
  EXPECT_TRUE(Hear("a", add));
  EXPECT_TRUE(Hear("a", add));
  orders_t said = Decide(3);
  ASSERT_EQ(said.n_taken, 1);
  EXPECT_EQ(said.taken[0].task_id, 120);
  EXPECT_FALSE(Hear("a", add));
  EXPECT_EQ(desk_.AnsweredAt("a"), 3);
  EXPECT_TRUE(Hear("b", add));
  said = Decide(4);
  EXPECT_EQ(said.before, 1);
  ASSERT_EQ(said.n_refused, 1);
  EXPECT_EQ(said.refused[0].reason,
            "no room for another task: the mission was started without more");
}

TEST_F(OrderDeskTest, NobodyGivesAnOrderUnderAnIdOfTheWorld) {
  order_t order{};
  order.issuer = "somebody";
  order.json = R"({"order": "decide_now"})";
  for (const std::string begin :
       {"closure:", "decide:", "fault:", "lift:", "open:", "release:", "revisit:", "zone:"}) {
    order.id = begin + "3";
    EXPECT_FALSE(desk_.Admits(order, 0)) << order.id;
  }
  order.id = "decided";
  EXPECT_TRUE(desk_.Admits(order, 0));
}

TEST_F(OrderDeskTest, AnOrderAsksForADecision) {
  Hear("a", R"({"order": "decide_now"})");
  EXPECT_EQ(Decide(3).n_taken, 1);
  EXPECT_EQ(desk_.scenario().rules.extra_decisions, (std::vector<std::int64_t>{3}));
  Hear("b", R"({"order": "decide_now"})");
  EXPECT_EQ(Decide(20).n_taken, 1) << "there is one anyway";
  EXPECT_EQ(desk_.scenario().rules.extra_decisions.size(), 1u);
  Hear("c", R"({"order": "decide_now", "task": 3})");
  EXPECT_EQ(Decide(21).n_refused, 1);
  Hear("d", R"({"order": "decide_now"})");
  const orders_t said = Decide(360);
  ASSERT_EQ(said.n_refused, 1);
  EXPECT_EQ(said.refused[0].reason, "the mission is over");
}

/// Ids of what is taken at a tick by a desk that decides on emergencies at once. Task 5 is an
/// emergency that is reported at 5:00.
class EmergencyDeskTest : public OrderDeskTest {
 protected:
  static Scenario WithEmergency() {
    Scenario scenario = Roomy();
    scenario.rules.emergencies_at_once = true;
    scenario.tasks[5].priority = Priority::kEmergency;
    scenario.tasks[5].reported_us = 5 * kMinuteUs;
    return scenario;
  }
  std::vector<std::string> TakenAt(std::int64_t tick) {
    orders_t said = emergencies_.Decide(tick, status_, agents_);
    said.header.sender = process_name::kWorld;
    emergencies_.Take(said);
    std::vector<std::string> ids;
    for (const taken_order_t& taken : said.taken) ids.push_back(taken.id);
    return ids;
  }
  void Give(const std::string& id, const std::string& json) { emergencies_.Give(id, json); }
  static Event Aborted(std::int32_t task) {
    Event event;
    event.kind = Event::Kind::kSensingAborted;
    event.task = TaskId(task);
    return event;
  }

  OrderDesk emergencies_{WithEmergency(), {}};
  using Ids = std::vector<std::string>;
};

TEST_F(EmergencyDeskTest, AReportedEmergencyIsDecidedOnAtOnce) {
  status_[5] = TaskStatus::kUnreported;
  EXPECT_EQ(TakenAt(9), Ids{});
  EXPECT_EQ(TakenAt(10), Ids{"decide:10"});
  status_[5] = TaskStatus::kOpen;
  EXPECT_EQ(TakenAt(11), Ids{});
}

TEST_F(EmergencyDeskTest, AnEmergencyThatIsAddedChangedOrResumedToo) {
  status_[120] = TaskStatus::kUnreported;
  Give("a", R"({"order": "task_add", "task": {"x_km": 1, "y_km": 2, "priority": 3}})");
  EXPECT_EQ(TakenAt(12), (Ids{"a", "decide:12"}));
  status_[120] = TaskStatus::kOpen;
  Give("b", R"({"order": "task_change", "task": 7, "priority": 2})");
  EXPECT_EQ(TakenAt(13), Ids{"b"});
  Give("c", R"({"order": "task_change", "task": 7, "priority": 3})");
  EXPECT_EQ(TakenAt(14), (Ids{"c", "decide:14"}));
  status_[7] = TaskStatus::kSensing;
  Give("d", R"({"order": "task_change", "task": 7, "due_in_min": 3})");
  EXPECT_EQ(TakenAt(15), Ids{"d"}) << "it is being done";
  Give("e", R"({"order": "task_hold", "task": 5})");
  EXPECT_EQ(TakenAt(16), Ids{"e"});
  status_[5] = TaskStatus::kHeld;
  Give("f", R"({"order": "task_resume", "task": 5})");
  EXPECT_EQ(TakenAt(17), (Ids{"f", "decide:17"}));
  Give("g", R"({"order": "task_change", "task": 5, "due_in_min": 3})");
  EXPECT_EQ(TakenAt(20), Ids{"g"}) << "a decision is due";
  EXPECT_EQ(emergencies_.scenario().rules.extra_decisions, (std::vector<std::int64_t>{12, 14, 17}));
}

TEST_F(EmergencyDeskTest, AnEmergencyThatIsGivenBackIsDecidedOnInTheNextTick) {
  EXPECT_EQ(TakenAt(30), Ids{});
  emergencies_.DecideIfReopened(Aborted(4));
  EXPECT_EQ(TakenAt(31), Ids{}) << "no emergency";
  emergencies_.DecideIfReopened(Aborted(5));
  EXPECT_EQ(TakenAt(32), Ids{"decide:32"});
  EXPECT_EQ(TakenAt(39), Ids{});
  emergencies_.DecideIfReopened(Aborted(5));
  EXPECT_EQ(TakenAt(40), Ids{}) << "a decision is due";
}

std::string Withdraws(const std::string& id) {
  return fmt::format(R"({{"order": "withdraw", "withdraws": "{}"}})", id);
}

TEST_F(OrderDeskTest, AnOrderIsWithdrawnUntilItsTick) {
  const std::string hold = R"({"order": "task_hold", "task": 3})";
  Hear("a", hold);
  Hear("b", hold);
  Hear("w", Withdraws("a"));
  orders_t said = Decide(1);
  ASSERT_EQ(said.n_taken, 2);
  EXPECT_EQ(said.taken[0].id, "w");
  EXPECT_EQ(said.taken[1].id, "b");
  ASSERT_EQ(said.n_refused, 1);
  EXPECT_EQ(said.refused[0].id, "a");
  EXPECT_EQ(said.refused[0].reason, "withdrawn by order w");

  Hear("late", Withdraws("b"));
  Hear("again", Withdraws("a"));
  Hear("itself", Withdraws("w"));
  said = Decide(2);
  ASSERT_EQ(said.n_refused, 3);
  EXPECT_EQ(said.refused[0].reason, "order b has been answered already");
}

/// It may arrive before the order, and the world may start again between the two.
TEST_F(OrderDeskTest, AWithdrawalHoldsForAnOrderThatIsHeardLater) {
  Hear("w", Withdraws("a"));
  const orders_t first = Decide(1);
  ASSERT_EQ(first.n_taken, 1);
  OrderDesk anew(scenario_, {});
  anew.Take(first);
  order_t order{};
  order.id = "a";
  order.json = R"({"order": "task_hold", "task": 3})";
  anew.Hear(order);
  const orders_t second = anew.Decide(2, status_, agents_);
  ASSERT_EQ(second.n_refused, 1);
  EXPECT_EQ(second.refused[0].reason, "withdrawn by order w");
}

TEST_F(OrderDeskTest, AnOrderThatIsPlannedForLaterIsWithdrawn) {
  const std::string hold = R"({"order": "task_hold", "task": 3, "at_min": 2})";
  Order order = ParseOrder(hold, "order");
  order.id = "planned";
  OrderDesk desk(scenario_, {{order, hold}});
  order_t withdrawal{};
  withdrawal.id = "w";
  withdrawal.json = Withdraws("planned");
  desk.Hear(withdrawal);
  for (std::int64_t tick = 0; tick < 5; ++tick) {
    const orders_t said = desk.Decide(tick, status_, agents_);
    EXPECT_EQ(said.n_taken, tick == 0 ? 1 : 0);
    EXPECT_EQ(said.n_refused, tick == 4 ? 1 : 0);
    desk.Take(said);
  }
}

/// Where persons are known, each withdraws only what is their own.
TEST_F(OrderDeskTest, NobodyWithdrawsWhatAnotherHasOrdered) {
  Scenario scenario = Roomy();
  for (const char* name : {"Ann", "Bob"}) {
    scenario.persons.push_back({name, Role::kOrder, "", ""});
  }
  OrderDesk desk(scenario, {});
  const auto hear = [&](const std::string& id, const std::string& by, const std::string& json) {
    order_t order{};
    order.id = id;
    order.issuer = by;
    order.json = ToJson(SignedOrder{json, by, by, std::string(128, '0')});
    desk.Hear(order);
  };
  hear("a", "Ann", R"({"order": "task_hold", "task": 3})");
  hear("w1", "Bob", Withdraws("a"));
  hear("w2", "Bob", Withdraws("c"));
  orders_t said = desk.Decide(1, status_, agents_);
  desk.Take(said);
  ASSERT_EQ(said.n_refused, 1);
  EXPECT_EQ(said.refused[0].reason, "order a is of Ann");
  EXPECT_EQ(said.n_taken, 2);
  hear("c", "Ann", R"({"order": "task_hold", "task": 4})");
  said = desk.Decide(2, status_, agents_);
  EXPECT_EQ(said.n_taken, 1) << "what Bob has withdrawn is not his";
  desk.Take(said);

  // Nor does Bob's keep Ann from it.
  hear("w3", "Bob", Withdraws("d"));
  hear("w4", "Ann", Withdraws("d"));
  desk.Take(desk.Decide(3, status_, agents_));
  hear("d", "Ann", R"({"order": "task_hold", "task": 5})");
  said = desk.Decide(4, status_, agents_);
  ASSERT_EQ(said.n_refused, 1);
  EXPECT_EQ(said.refused[0].reason, "withdrawn by order w4");
}

TEST_F(OrderDeskTest, SaysWhyATaskOrAnAgentIsNotForThatOrder) {
  status_[1] = TaskStatus::kDone;
  status_[2] = TaskStatus::kSensing;
  agents_.uavs[4].failed = true;
  agents_.workers[5].online_until_us = 0;
  int tick = 0;
  const auto refusal = [&](const std::string& json) -> std::string {
    Hear(std::to_string(tick), json);
    const orders_t said = Decide(tick++);
    return said.n_refused == 1 ? said.refused[0].reason : "";
  };
  EXPECT_EQ(refusal(R"({"order": "task_cancel", "task": 1})"), "task 1 is done");
  EXPECT_EQ(refusal(R"({"order": "task_hold", "task": 2})"),
            "task 2 is sensing under way: cancel ends it");
  EXPECT_EQ(refusal(R"({"order": "task_resume", "task": 3})"), "task 3 is open, not held");
  EXPECT_EQ(refusal(R"({"order": "agent_leave", "agent": "uav:4"})"), "uav:4 has failed");
  EXPECT_EQ(refusal(R"({"order": "agent_recall", "agent": "worker:5"})"), "worker:5 has left");
  EXPECT_EQ(refusal(R"({"order": "task_cancel", "task": 3, "at_min": 5})"),
            "order: at_min: found 5, expected a time that has come: it is 2.5 now");
  EXPECT_EQ(refusal(R"({"order": "task_cancel", "task": 3})"), "");
}

/// Its reason is a message's text, whatever the order quotes.
TEST_F(OrderDeskTest, RefusesInWordsThatAMessageCanCarry) {
  const std::string two_bytes = "\xc3\xa4";
  std::string many;
  for (int i = 0; i < 3000; ++i) many += two_bytes;
  std::int64_t tick = 0;
  for (const std::string& text : {std::string("a\\u0007b"), std::string("\\u001b[2J"), many,
                                  "x" + many, std::string(9000, 'y')}) {
    for (const std::string& json :
         {R"({"order": ")" + text + R"("})", R"({")" + text + R"(": 1, "order": "task_hold"})",
          R"({"order": "agent_leave", "agent": ")" + text + R"("})", text}) {
      Hear(std::to_string(tick), json);
      EXPECT_EQ(Decide(tick++).n_refused, 1);
    }
  }
}

TEST_F(OrderDeskTest, ADirectiveThatCannotBeKeptIsRefusedWithTheReason) {
  for (const AgentKind kind : kAgentKinds) {
    for (AgentState& agent : agents_[kind]) {
      agent.online_from_us = 0;
      agent.online_until_us = 180 * kMinuteUs;
    }
  }
  int n = 0;
  const auto answer = [&](const std::string& json) -> std::string {
    Hear(fmt::format("d{}", ++n), json);
    const orders_t said = Decide(n);
    return said.n_refused == 1 ? said.refused[0].reason : "";
  };
  const std::string pin = R"({"order": "pin", "task": 7, "agents": ["uav:3", "worker:7"]})";
  AgentState& uav = agents_.at(AgentKind::kUav, 3);
  AgentState& worker = agents_.at(AgentKind::kWorker, 7);
  uav.from = uav.to = worker.from = worker.to = scenario_.tasks[7].at;
  uav.range_at_departure_m = 100;
  EXPECT_EQ(answer(pin).find("uav:3 lacks range for task 7: it needs "), 0U);
  uav.range_at_departure_m = uav.range_full_m;
  EXPECT_EQ(answer(R"({"order": "charge_now", "agents": ["uav:3"]})"), "uav:3 is charged already");
  worker.failed = true;
  EXPECT_EQ(answer(pin), "worker:7 has failed");
  worker.failed = false;
  worker.online_until_us = kMinuteUs;
  EXPECT_EQ(answer(pin), "worker:7 has left");
  worker.online_until_us = 180 * kMinuteUs;
  status_[7] = TaskStatus::kReserved;
  EXPECT_EQ(answer(pin), "task 7 is reserved: others are at it (task_hold or agent_recall)");
  status_[7] = TaskStatus::kOpen;
  EXPECT_EQ(answer(R"({"order": "forbid", "agent": "uav:3", "task": 7})"), "");
  EXPECT_EQ(answer(pin), "order d6 forbids uav:3 task 7");
  EXPECT_EQ(answer(R"({"order": "release", "directive": "d6"})"), "");
  EXPECT_EQ(answer(pin), "");
  EXPECT_EQ(answer(R"({"order": "forbid", "agent": "uav:3", "task": 7})"),
            "order d9 pins uav:3 to task 7: unpin it first");
  EXPECT_EQ(desk_.scenario().directives.size(), 1U) << "what is refused leaves nothing behind";
}

TEST_F(OrderDeskTest, WhatIsFulfilledIsReleasedByTheWorld) {
  agents_.at(AgentKind::kUav, 3).range_at_departure_m = 15'000;
  for (const AgentKind kind : kAgentKinds) {
    for (AgentState& agent : agents_[kind]) agent.online_until_us = 180 * kMinuteUs;
  }
  Hear("c", R"({"order": "charge_now", "agents": ["uav:3"]})");
  ASSERT_EQ(Decide(1).n_taken, 1);
  Event event;
  event.kind = Event::Kind::kChargingDone;
  event.uav = UavId(4);
  desk_.EndFulfilled(event);
  EXPECT_EQ(Decide(2).n_taken, 0);
  event.uav = UavId(3);
  desk_.EndFulfilled(event);
  const orders_t said = Decide(3);
  ASSERT_EQ(said.n_taken, 1);
  EXPECT_EQ(said.taken[0].id, "release:c");
  EXPECT_EQ(said.taken[0].issuer, "world");
  EXPECT_TRUE(desk_.scenario().directives.empty());
}

TEST_F(OrderDeskTest, APinEndsWithItsTask) {
  for (const AgentKind kind : kAgentKinds) {
    for (AgentState& agent : agents_[kind]) agent.online_until_us = 180 * kMinuteUs;
  }
  AgentState& uav = agents_.at(AgentKind::kUav, 3);
  uav.from = uav.to = scenario_.tasks[7].at;
  using Kind = Event::Kind;
  int tick = 0;
  const auto is_released = [&](Kind kind, int task) {
    Event event;
    event.kind = kind;
    event.uav = UavId(3);
    event.task = TaskId(task);
    desk_.EndFulfilled(event);
    return Decide(++tick).n_taken == 1;
  };
  for (const Kind end : {Kind::kSensingDone, Kind::kTaskExpired, Kind::kTaskCancelled}) {
    Hear(fmt::format("p{}", tick), R"({"order": "pin", "task": 7, "agents": ["uav:3"]})");
    ASSERT_EQ(Decide(++tick).n_taken, 1);
    EXPECT_FALSE(is_released(Kind::kSensingStarted, 7));
    EXPECT_FALSE(is_released(Kind::kSensingAborted, 7));
    EXPECT_FALSE(is_released(end, 8)) << "another task";
    EXPECT_TRUE(is_released(end, 7));
    EXPECT_TRUE(desk_.scenario().directives.empty());
  }
}

}  // namespace
}  // namespace muster::world
