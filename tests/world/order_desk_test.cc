#include "world/order_desk.h"

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

}  // namespace
}  // namespace muster::world
