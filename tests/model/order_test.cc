#include "model/order.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "base/check.h"
#include "base/random.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "tests/model/manhattan_ways.h"

namespace muster {
namespace {

constexpr TimeUs kNow = 30 * kMinuteUs;

Scenario Roomy() {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  AddRoom({2, {1, 1, 1}}, &scenario);
  return scenario;
}

std::string Refusal(Scenario* scenario, const std::string& json) {
  const std::string before = ScenarioToJson(*scenario);
  try {
    TakeInto(scenario, ParseOrder(json, "order"), kNow);
  } catch (const InputError& error) {
    EXPECT_EQ(ScenarioToJson(*scenario), before) << json;
    return error.what();
  }
  return "";
}

TEST(Order, AddsTasksInTheVacantPlaces) {
  Scenario scenario = Roomy();
  const std::size_t n = scenario.n_tasks();
  const std::string add =
      R"({"order": "task_add", "task": {"x_km": 3, "y_km": 4, "priority": 3, "due_in_min": 20,
          "expires_min": 90, "name": "School"}})";
  const TakenOrder first = TakeInto(&scenario, ParseOrder(add, "order"), kNow);
  EXPECT_EQ(first.task_id, static_cast<std::int32_t>(n));
  const Task& task = scenario.tasks[n];
  EXPECT_EQ(task.at, (Point{3000, 4000}));
  EXPECT_EQ(task.cost_m, 3000);
  EXPECT_EQ(task.reported_us, kNow);
  EXPECT_EQ(task.due_us, 50 * kMinuteUs);
  EXPECT_EQ(task.expires_us, 90 * kMinuteUs);
  EXPECT_EQ(task.priority, Priority::kEmergency);
  EXPECT_EQ(task.name, "School");
  EXPECT_EQ(scenario.n_tasks(), n + 1);
  EXPECT_EQ(Refusal(&scenario, add), "");
  EXPECT_EQ(Refusal(&scenario, add),
            "no room for another task: the mission was started without more");
}

TEST(Order, RefusesWhatTheScenarioFileWouldRefuse) {
  Scenario scenario = Roomy();
  EXPECT_EQ(Refusal(&scenario, R"({"order": "task_add", "task": {"x_km": 99, "y_km": 4}})"),
            "order: tasks[0].x_km: found 99, expected a number in [0, 30]");
  EXPECT_EQ(Refusal(&scenario,
                    R"({"order": "task_add", "task": {"x_km": 9, "y_km": 4, "expires_min": 30}})"),
            "order: expires_min: found 30, expected later than now (30)");
  EXPECT_EQ(Refusal(&scenario, R"({"order": "task_cancel", "task": 120})"),
            "there is no task 120: there are 120");
  EXPECT_EQ(Refusal(&scenario, R"({"order": "agent_leave", "agent": "uav:30"})"),
            "there is no uav:30: the last is 29");
  EXPECT_EQ(Refusal(&scenario, R"({"order": "agent_join", "class": "worker",
                                   "agent": {"x_km": 1, "y_km": 1, "speed_km_per_min": 0}})"),
            "order: workers[0].speed_km_per_min: found 0, expected a number in [1e-05, 1000000]");
}

TEST(Order, NamesAreFitForMessages) {
  const auto refusal = [](const std::string& json) -> std::string {
    try {
      ParseOrder(json, "order");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(R"({"id": "a\u0007", "order": "task_cancel", "task": 1})"),
            "order: id: found a\\x07, expected at most 200 bytes without control characters");
  EXPECT_EQ(refusal(R"({"id": "open:bridge", "order": "task_cancel", "task": 1})"),
            "order: id: found open:bridge, expected an id that does not begin with closure:, "
            "decide:, fault:, lift:, open:, release:, revisit:, zone:");
  EXPECT_EQ(
      refusal(R"({"issuer": ")" + std::string(201, 'x') +
              R"(", "order": "task_cancel", "task": 1})"),
      "order: issuer: found 201 bytes, expected at most 200 bytes without control characters");
  EXPECT_EQ(refusal(std::string(17'000, ' ')),
            "order: order: found 17000 bytes, expected at most 16000");
}

TEST(Order, ChangesWhatItNames) {
  Scenario scenario = Roomy();
  const Task before = scenario.tasks[7];
  TakeInto(
      &scenario,
      ParseOrder(R"({"order": "task_change", "task": 7, "priority": 2, "due_in_min": 5})", "o"),
      kNow);
  EXPECT_EQ(scenario.tasks[7].priority, Priority::kHigh);
  EXPECT_EQ(scenario.tasks[7].due_us, 35 * kMinuteUs);
  EXPECT_EQ(scenario.tasks[7].expires_us, before.expires_us);
  EXPECT_EQ(scenario.tasks[7].at, before.at);
}

TakenOrder UavJoins(Scenario* scenario) {
  constexpr const char* kJoin = R"({"order": "agent_join", "class": "uav",
      "agent": {"x_km": 5, "y_km": 6, "speed_km_per_min": 1, "full_range_km": 20}})";
  return TakeInto(scenario, ParseOrder(kJoin, "order"), kNow);
}

TEST(Order, WhoJoinsStandsThereAndWhoLeavesEndsItsWork) {
  Scenario scenario = Roomy();
  const TakenOrder joins = UavJoins(&scenario);
  EXPECT_EQ(joins.agent_id, 30);
  AgentState agent = StartOf(AgentKind::kUav, 30, AgentSpec(), StraightWays());
  Obey(&agent, joins, kNow, scenario);
  EXPECT_TRUE(agent.idle(kNow));
  EXPECT_EQ(PositionAt(agent, kNow), (Point{5000, 6000}));
  EXPECT_EQ(RangeAt(agent, kNow, scenario.tasks), 20'000);
  EXPECT_EQ(agent.online_until_us, scenario.rules.limit_us);

  const TakenOrder leaves =
      TakeInto(&scenario, ParseOrder(R"({"order": "agent_leave", "agent": "uav:30"})", "o"), kNow);
  agent.busy_until_us = kNow + 5;
  Obey(&agent, leaves, kNow, scenario);
  EXPECT_EQ(agent.online_until_us, kNow + 5);
  agent.busy_until_us = kNow - 5;
  Obey(&agent, leaves, kNow, scenario);
  EXPECT_EQ(agent.online_until_us, kNow);
}

TEST(Order, WhoJoinsGoesByTheWaysOfThatTick) {
  Scenario scenario = Roomy();
  const TakenOrder joins = UavJoins(&scenario);
  const std::shared_ptr<const Ways> before = scenario.ways;
  // An agent's process has taken the orders of the next tick before it lets the agent join.
  scenario.ways = std::make_shared<const testing::ManhattanWays>();
  scenario.changed_ways = {{0, before, {}}, {kNow + kMinuteUs, scenario.ways, {}}};
  AgentState agent = StartOf(AgentKind::kUav, 30, AgentSpec(), StraightWays());
  Obey(&agent, joins, kNow, scenario);
  EXPECT_EQ(agent.ways, before.get());
}

/// Ten thousand orders that are none, or that cannot be: each is refused with a reason, and changes
/// nothing.
TEST(Order, DirectivesAreInForceUntilTheyAreEnded) {
  Scenario scenario = Roomy();
  const auto take = [&](const std::string& id, const std::string& json) -> std::string {
    try {
      Order order = ParseOrder(json, "order");
      order.id = id;
      order.issuer = "chief";
      TakeInto(&scenario, order, kNow);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto in_force = [&] {
    std::string text;
    for (const Directive& one : scenario.directives) text += one.order + " " + ToString(one) + "\n";
    return text;
  };
  EXPECT_EQ(take("p", R"({"order": "pin", "task": 7, "agents": ["uav:3", "worker:7"]})"), "");
  EXPECT_EQ(take("q", R"({"order": "pin", "task": 7, "agents": ["uav:4"]})"),
            "task 7 is pinned already by order p: unpin it first");
  EXPECT_EQ(take("f", R"({"order": "forbid", "agent": "uav:3", "task": 8})"), "");
  EXPECT_EQ(take("a", R"({"order": "forbid", "class": "worker", "circle_km": [9, 9, 1]})"), "");
  EXPECT_EQ(take("c", R"({"order": "charge_now", "agents": ["uav:3", "vehicle:1"], "charge": 2})"),
            "");
  EXPECT_EQ(take("g", R"({"order": "go_to", "agent": "worker:7", "x_km": 1, "y_km": 2})"), "");
  // The later word about an agent stands.
  EXPECT_EQ(take("h", R"({"order": "go_to", "agent": "worker:7", "x_km": 3, "y_km": 4})"), "");
  EXPECT_EQ(in_force(),
            "p pin: uav:3 and worker:7 to task 7\nf forbid: uav:3 task 8\n"
            "a forbid: workers in an area\nc charge now: uav:3 and vehicle:1 at charge:2\n"
            "h go to: worker:7 to (3.000, 4.000) km\n");
  EXPECT_EQ(scenario.directives.front().issuer, "chief");
  EXPECT_TRUE(IsOffLimits(scenario.directives, AgentKind::kWorker, {9000, 9500}));
  EXPECT_FALSE(IsOffLimits(scenario.directives, AgentKind::kUav, {9000, 9500}));
  EXPECT_FALSE(IsOffLimits(scenario.directives, AgentKind::kWorker, {9000, 10'500}));

  for (const char* id : {"f", "a", "c", "h"}) {
    EXPECT_EQ(take("r", fmt::format(R"({{"order": "release", "directive": "{}"}})", id)), "");
  }
  EXPECT_EQ(take("u", R"({"order": "unpin", "task": 7})"), "");
  EXPECT_EQ(in_force(), "");
  EXPECT_EQ(take("u", R"({"order": "unpin", "task": 7})"), "task 7 is not pinned");
  EXPECT_EQ(take("r", R"({"order": "release", "directive": "p"})"),
            "no directive of an order p is in force");
  EXPECT_EQ(take("p", R"({"order": "pin", "task": 120, "agents": ["uav:3"]})"),
            "there is no task 120: there are 120");
  EXPECT_EQ(take("p", R"({"order": "pin", "task": 1, "agents": ["uav:30"]})"),
            "there is no uav:30: the last is 29");
  EXPECT_EQ(take("p", R"({"order": "pin", "task": 1, "agents": ["vehicle:1"]})"),
            "order: agents: found vehicle:1, expected an agent of a class that takes part in it");
  EXPECT_EQ(take("p", R"({"order": "pin", "task": 1, "agents": ["uav:1", "uav:2"]})"),
            "order: agents: found uav:2, expected one uav");
  EXPECT_EQ(take("p", R"({"order": "pin", "task": 1, "agents": []})"),
            "order: agents: found an array of 0, expected a list of agents, as [\"uav:3\"]");
  EXPECT_EQ(take("g", R"({"order": "go_to", "agent": "uav:1", "x_km": 31, "y_km": 2})"),
            "(31, 2) km is outside the area of 30 x 30 km");
  EXPECT_EQ(take("f", R"({"order": "forbid", "agent": "vehicle:1", "task": 2})"),
            "order: agent: found \"vehicle:1\", expected a UAV or a worker: vehicles do no tasks");
  EXPECT_EQ(in_force(), "");
}

TEST(Order, TenThousandMalformedOnesChangeNothing) {
  Scenario scenario = Roomy();
  const std::string good[] = {
      R"({"order": "task_add", "task": {"x_km": 3, "y_km": 4, "priority": 3, "name": "a"}})",
      R"({"order": "task_change", "task": 7, "priority": 2, "due_in_min": 5})",
      R"({"order": "agent_join", "class": "vehicle", "agent": {"x_km": 5, "y_km": 6,
          "speed_km_per_min": 1, "charge_km_per_min": 5}})",
      R"({"order": "agent_recall", "agent": "worker:3"})",
      R"({"order": "pin", "task": 7, "agents": ["uav:3", "worker:7"]})",
      R"({"order": "forbid", "class": "worker", "circle_km": [10, 10, 3]})",
      R"({"order": "go_to", "agent": "uav:3", "x_km": 5, "y_km": 6})"};
  int refused = 0;
  for (std::uint64_t seed = 0; refused < 10'000; ++seed) {
    Random random(seed, Stream::kTest);
    std::string text = good[random.Below(std::size(good))];
    const int changes = 1 + static_cast<int>(random.Below(4));
    for (int i = 0; i < changes && !text.empty(); ++i) {
      const std::size_t at = random.Below(static_cast<std::uint32_t>(text.size()));
      switch (random.Below(4)) {
        case 0:
          text.erase(at, 1 + random.Below(5));
          break;
        case 1:
          text[at] = static_cast<char>(random.Below(256));
          break;
        case 2:
          text.insert(at, std::to_string(random.Below(1u << 31)));
          break;
        default:
          text.insert(at, text.substr(random.Below(static_cast<std::uint32_t>(text.size())), 9));
      }
    }
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + text);
    Scenario copy = scenario;
    try {
      TakeInto(&copy, ParseOrder(text, "order"), kNow);
    } catch (const InputError& error) {
      ASSERT_FALSE(std::string(error.what()).empty());
      ++refused;
      if (refused % 100 == 0) {
        ASSERT_EQ(ScenarioToJson(copy), ScenarioToJson(scenario));
      }
    }
  }
}

}  // namespace
}  // namespace muster
