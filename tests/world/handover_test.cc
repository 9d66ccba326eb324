#include "world/handover.h"

#include <gtest/gtest.h>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::world {
namespace {

const Identity kWorld{5, "world", 2};
const Now kNow{0, 77};

Packet Report(std::uint8_t byte) { return {std::string(channel::kUavs), {byte}}; }

TEST(Handover, HasTheReportsOfTheNewestJudgedTick) {
  Handover handover;
  handover.Add(AgentKind::kUav, Report(1));
  EXPECT_EQ(handover.tick(), -1);
  EXPECT_TRUE(handover.StatesOf(AgentKind::kUav, kWorld, kNow).empty());
  handover.Judge(3, 90, 1);
  handover.Add(AgentKind::kUav, Report(2));  // for the next tick
  EXPECT_EQ(handover.tick(), 3);
  using Bytes = std::vector<std::vector<std::uint8_t>>;
  EXPECT_EQ(handover.StatesOf(AgentKind::kUav, kWorld, kNow), (Bytes{{1}}));
  EXPECT_TRUE(handover.StatesOf(AgentKind::kWorker, kWorld, kNow).empty());
  handover.Judge(4, 120, 1);
  EXPECT_EQ(handover.StatesOf(AgentKind::kUav, kWorld, kNow), (Bytes{{2}}));
}

TEST(Handover, TellsOfUnreportedAgentsInTheWorldsName) {
  Handover handover;
  handover.Judge(3, 90, 1);
  agent_t agent{};
  agent.id = 4;
  handover.AddUnreported(AgentKind::kWorker, agent);
  const auto messages = handover.StatesOf(AgentKind::kWorker, kWorld, kNow);
  ASSERT_EQ(messages.size(), 1u);
  const auto states = Decode<agent_states_t>(messages[0]);
  ASSERT_TRUE(states);
  EXPECT_EQ(states->header.run_id, 5);
  EXPECT_EQ(states->header.sender, "world");
  EXPECT_EQ(states->header.boot_id, 2);
  EXPECT_EQ(states->header.sim_us, 90);
  EXPECT_EQ(states->header.wall_us, 77);
  EXPECT_EQ(states->tick, 3);
  EXPECT_EQ(states->applied_decision, 1);
  ASSERT_EQ(states->agents.size(), 1u);
  EXPECT_EQ(states->agents[0].id, 4);
  handover.Judge(4, 120, 1);
  EXPECT_TRUE(handover.StatesOf(AgentKind::kWorker, kWorld, kNow).empty());
}

}  // namespace
}  // namespace muster::world
