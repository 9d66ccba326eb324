#include "tools/launch/archive.h"

#include <gtest/gtest.h>

#include <muster/agent_states_t.hpp>
#include <muster/rulings_t.hpp>
#include <muster/world_state_t.hpp>
#include <string>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/protocol/convert.h"
#include "world/model/generator.h"

namespace muster::tools {
namespace {

constexpr std::int64_t kRun = 5;
constexpr TimeUs kPatienceUs = 2 * kSecondUs;

class ArchiveTest : public ::testing::Test {
 protected:
  template <class T>
  void Add(std::string_view channel, const std::string& sender, std::int64_t tick, T message) {
    message.header.run_id = run_;
    message.header.sender = sender;
    message.header.boot_id = 0;
    message.header.seq = seq_++;
    message.header.sim_us = scenario_.rules.TimeOf(tick);
    message.header.wall_us = 0;
    message.tick = tick;
    archive_.Add({std::string(channel), Encode(message)});
  }
  void AddStates(AgentKind kind, std::int64_t tick) {
    agent_states_t states{};
    states.kind = static_cast<std::int8_t>(kind);
    states.applied_decision = -1;
    for (std::size_t id = 0; id < scenario_.agents(kind).size(); ++id) {
      states.agents.emplace_back().id = static_cast<std::int32_t>(id);
    }
    states.n = static_cast<std::int32_t>(states.agents.size());
    Add(ChannelOf(kind), std::string(ToString(kind)), tick, states);
  }
  void AddVerdict(std::int64_t tick) {
    world_state_t world{};
    world.n_tasks = static_cast<std::int32_t>(scenario_.tasks.size());
    world.task_status.assign(scenario_.tasks.size(), 0);
    Add(channel::kWorld, "world", tick, world);
    Add(channel::kRulings, "world", tick, rulings_t{});
  }
  void AddTick(std::int64_t tick) {
    for (const AgentKind kind : kAgentKinds) AddStates(kind, tick);
    AddVerdict(tick);
  }

  /// Asks every 0.1 s from `from_us` on, and returns the first answer within 10 s.
  std::vector<restore_t> Ask(std::string_view channel, TimeUs from_us = 0,
                             std::int64_t boot_id = 1) {
    request_t request{};
    request.header.sender = "world";
    request.header.boot_id = boot_id;
    request.channel = channel;
    for (now_us_ = from_us; now_us_ < from_us + 10 * kSecondUs; now_us_ += kSecondUs / 10) {
      std::vector<restore_t> answers = archive_.Answer(request, now_us_);
      if (!answers.empty()) return answers;
    }
    return {};
  }

  Scenario scenario_ = Generate(PresetByName("Random_10"), 1);
  Archive archive_{scenario_, kRun};
  std::int64_t run_ = kRun;
  std::int64_t seq_ = 0;
  TimeUs now_us_ = 0;
};

std::vector<std::int64_t> TicksOf(const std::vector<restore_t>& answers) {
  std::vector<std::int64_t> ticks;
  for (const restore_t& answer : answers) ticks.push_back(answer.tick);
  return ticks;
}

TEST_F(ArchiveTest, AnswersWithTheNewestTickThatItHasHeardWhole) {
  AddTick(7);
  AddTick(8);
  AddStates(AgentKind::kUav, 9);
  AddStates(AgentKind::kWorker, 9);
  for (const AgentKind kind : kAgentKinds) {
    const auto answers = Ask(ChannelOf(kind));
    EXPECT_EQ(TicksOf(answers), std::vector<std::int64_t>{8});
    const auto states = DecodeValid<agent_states_t>(answers.at(0).data);
    ASSERT_TRUE(states);
    EXPECT_EQ(states->tick, 8);
    EXPECT_EQ(states->kind, static_cast<std::int8_t>(kind));
  }
  EXPECT_EQ(TicksOf(Ask(channel::kWorld)), (std::vector<std::int64_t>{7, 8}));
  EXPECT_EQ(TicksOf(Ask(channel::kRulings)), (std::vector<std::int64_t>{7, 8}));
  EXPECT_TRUE(Ask(channel::kScenario).empty());
}

TEST_F(ArchiveTest, LeavesTheAnswerToTheLivingForTwoSeconds) {
  AddTick(0);
  ASSERT_FALSE(Ask(channel::kUavs).empty());
  EXPECT_EQ(now_us_, kPatienceUs);
  // The same start asks anew much later, and another one.
  ASSERT_FALSE(Ask(channel::kUavs, 100 * kSecondUs).empty());
  EXPECT_EQ(now_us_, 100 * kSecondUs + kPatienceUs);
  ASSERT_FALSE(Ask(channel::kUavs, now_us_, 2).empty());
  EXPECT_EQ(now_us_, 100 * kSecondUs + 2 * kPatienceUs);
}

TEST_F(ArchiveTest, SaysThatAMissionHasNotBegun) {
  AddStates(AgentKind::kUav, 0);
  const auto answers = Ask(channel::kWorkers);
  ASSERT_EQ(TicksOf(answers), std::vector<std::int64_t>{-1});
  EXPECT_TRUE(answers[0].data.empty());
  EXPECT_TRUE(Ask(channel::kWorld).empty());
}

TEST_F(ArchiveTest, SaysNothingOfAMissionThatItHasNotHeardWhole) {
  AddVerdict(3);
  AddStates(AgentKind::kUav, 4);
  AddStates(AgentKind::kWorker, 4);
  EXPECT_TRUE(Ask(channel::kUavs).empty());
  // Another run's states are not this one's.
  run_ = kRun + 1;
  AddStates(AgentKind::kVehicle, 4);
  EXPECT_TRUE(Ask(channel::kUavs, 100 * kSecondUs).empty());
  run_ = kRun;
  AddStates(AgentKind::kVehicle, 4);
  EXPECT_FALSE(Ask(channel::kUavs, 200 * kSecondUs).empty());
}

}  // namespace
}  // namespace muster::tools
