#include "tools/top/attention.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/tools/fake_mission.h"
#include "tools/report/mission_feed.h"
#include "tools/top/top_view.h"

namespace muster::tools {
namespace {

std::vector<std::string> Told(const FakeLog& log, const std::vector<std::string>& silent = {}) {
  MissionFeed feed;
  for (const Packet& packet : Encoded(log)) feed.Add(packet);
  feed.Finish();
  std::vector<std::string> told;
  for (const Concern& c : Attention(feed.timeline(), silent)) {
    told.push_back(fmt::format("{}: {} {}", c.kind, c.who, c.note));
  }
  return told;
}

TEST(Attention, TellsNothingOfAMissionThatWentWell) {
  EXPECT_EQ(Told(MakeFakeMission()), std::vector<std::string>());
}

TEST(Attention, PutsTheMostHarmfulFirst) {
  FakeLog log = MakeFakeMission();
  ForEach<agent_states_t>(&log, [](agent_states_t& states) {
    for (agent_t& agent : states.agents) {
      if (states.tick < 20) continue;
      if (states.kind == NumberOf(AgentKind::kWorker) && agent.id == 0) {
        agent.status = NumberOf(AgentStatus::kFailed);
      }
      if (states.kind == NumberOf(AgentKind::kWorker) && agent.id == 1) {
        agent.status = NumberOf(AgentStatus::kWaiting);
      }
      if (states.kind == NumberOf(AgentKind::kUav)) {
        agent.status = NumberOf(AgentStatus::kIdle);
        agent.range_left_m = agent.id == 0 ? 0 : 0.1 * agent.range_full_m;
        if (agent.id == 0) agent.x_m = 0;
        if (agent.id == 1) agent.x_m = 6000;
        if (agent.id == 1) agent.y_m = 1000;
      }
    }
  });
  ForEach<world_state_t>(&log, [](world_state_t& world) {
    for (auto& status : world.task_status) status = 0;
  });
  const std::vector<std::string> told = Told(log, {"vehicle"});
  ASSERT_EQ(told.size(), 7u) << fmt::format("{}", fmt::join(told, "\n"));
  EXPECT_EQ(told[0], "processes silent: vehicle ");
  EXPECT_TRUE(told[1].starts_with("agents failed: worker:0 since 0:")) << told[1];
  EXPECT_TRUE(told[2].starts_with("cannot reach a charging point: uav:0 0.0 km left")) << told[2];
  EXPECT_EQ(told[3], "tasks not done: task 0 ");
  EXPECT_EQ(told[4], "tasks not done: task 1 ");
  EXPECT_TRUE(told[5].starts_with("waiting for a partner: worker:1 for ")) << told[5];
  EXPECT_TRUE(told[6].starts_with("low range: uav:1 ")) << told[6];
}

TEST(Attention, IsInTheDisplayAndInJson) {
  TopView view;
  FakeLog log = MakeFakeMission();
  ForEach<world_state_t>(&log, [](world_state_t& world) {
    for (auto& status : world.task_status) status = 0;
  });
  for (const Packet& packet : Encoded(log)) view.Add(packet);
  std::string text;
  for (const TopView::Line& line : view.Lines(0, 0)) text += line.text + "\n";
  EXPECT_NE(text.find("ATTENTION: 2\ntasks not done: 2  task 0; task 1\n"), std::string::npos)
      << text;
  EXPECT_NE(view.Json(0).find("\"kind\": \"tasks not done\""), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
