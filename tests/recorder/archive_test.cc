#include "recorder/archive.h"

#include <gtest/gtest.h>

#include <memory>
#include <muster/agent_states_t.hpp>
#include <muster/rulings_t.hpp>
#include <muster/world_state_t.hpp>
#include <string>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "protocol/convert.h"

namespace muster::recorder {
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
    archive_->Add({std::string(channel), Encode(message)});
  }
  void AddStates(AgentKind kind, std::int64_t tick) {
    agent_states_t states{};
    states.kind = static_cast<std::int8_t>(kind);
    states.applied_decision = -1;
    for (std::size_t id = 0; id < scenario_.agents(kind).size(); ++id) {
      const auto agent =
          StartOf(kind, static_cast<std::int32_t>(id), scenario_.agents(kind)[id], *scenario_.ways);
      states.agents.push_back(ToWire(agent, scenario_.rules.TimeOf(tick), scenario_.tasks));
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
  std::vector<answer_t> Ask(std::string_view channel, TimeUs from_us = 0, std::int64_t boot_id = 1,
                            const std::string& who = "world") {
    request_t request{};
    request.header.sender = who;
    request.header.boot_id = boot_id;
    request.channel = channel;
    for (now_us_ = from_us; now_us_ < from_us + 10 * kSecondUs; now_us_ += kSecondUs / 10) {
      std::vector<answer_t> answers = archive_->Answer(request, now_us_);
      if (!answers.empty()) return answers;
    }
    return {};
  }

  Scenario scenario_ = Generate(PresetByName("Random_10"), 1);
  void GoOn() { archive_ = std::make_unique<Archive>(scenario_, kRun, true); }

  std::unique_ptr<Archive> archive_ = std::make_unique<Archive>(scenario_, kRun, false);
  std::int64_t run_ = kRun;
  std::int64_t seq_ = 0;
  TimeUs now_us_ = 0;
};

std::vector<std::int64_t> TicksOf(const std::vector<answer_t>& answers) {
  std::vector<std::int64_t> ticks;
  for (const answer_t& answer : answers) ticks.push_back(answer.tick);
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

TEST_F(ArchiveTest, KeepsWhereLostAgentsWereAndWhatBecameOfThem) {
  GoOn();
  for (const std::int64_t tick : {3, 4, 5}) AddTick(tick);
  for (std::int64_t tick = 6; tick <= 20; ++tick) {
    AddStates(AgentKind::kWorker, tick);
    AddStates(AgentKind::kVehicle, tick);
    AddVerdict(tick);
  }
  EXPECT_EQ(TicksOf(Ask(channel::kWorkers)), (std::vector<std::int64_t>{17, 18, 19, 20}));
  EXPECT_EQ(TicksOf(Ask(channel::kUavs)), (std::vector<std::int64_t>{3, 4, 5}));
  const std::vector<std::int64_t> verdicts{4, 5, 6, 17, 18, 19, 20};
  EXPECT_EQ(TicksOf(Ask(channel::kWorld)), verdicts);
  EXPECT_EQ(TicksOf(Ask(channel::kRulings)), verdicts);
  EXPECT_TRUE(Ask(channel::kUavs, 0, 1, "uav").empty()) << "the world knows where they are now";
}

TEST_F(ArchiveTest, TellsAWorldAtOnceWhatWasDecidedWithoutTheLost) {
  GoOn();
  for (const std::int64_t tick : {3, 4}) AddTick(tick);
  AddStates(AgentKind::kUav, 5);
  EXPECT_EQ(TicksOf(Ask(channel::kUavs, 100)), (std::vector<std::int64_t>{3, 4, 5}));
  EXPECT_EQ(now_us_, 100);
  EXPECT_EQ(TicksOf(Ask(channel::kWorld, 200)), (std::vector<std::int64_t>{3, 4}));
  EXPECT_EQ(now_us_, 200);
  EXPECT_EQ(TicksOf(Ask(channel::kUavs, 300, 1, "uav")), (std::vector<std::int64_t>{3, 4}));
  EXPECT_EQ(now_us_, 300 + kPatienceUs) << "others ask the living";
}

TEST_F(ArchiveTest, TakesNobodyForLostWhereTheMissionWaits) {
  for (const std::int64_t tick : {3, 4, 5}) AddTick(tick);
  AddStates(AgentKind::kWorker, 6);
  AddStates(AgentKind::kVehicle, 6);
  AddVerdict(6);
  AddStates(AgentKind::kWorker, 7);
  AddStates(AgentKind::kVehicle, 7);
  EXPECT_EQ(TicksOf(Ask(channel::kUavs)), std::vector<std::int64_t>{5});
}

TEST_F(ArchiveTest, GoesOnWithTheNewestVerdictWhereAllAreLost) {
  GoOn();
  for (const std::int64_t tick : {3, 4, 5}) AddTick(tick);
  for (std::int64_t tick = 6; tick <= 20; ++tick) AddVerdict(tick);
  for (const AgentKind kind : kAgentKinds) {
    EXPECT_EQ(TicksOf(Ask(ChannelOf(kind))), (std::vector<std::int64_t>{3, 4, 5}));
  }
}

TEST_F(ArchiveTest, BelievesNoTimeOutsideTheMission) {
  AddTick(6);
  AddTick(7);
  AddStates(AgentKind::kUav, 8);
  agent_states_t late{};
  late.header.run_id = kRun;
  late.header.sender = "uav";
  late.header.sim_us = kNever;
  archive_->Add({std::string(channel::kUavs), Encode(late)});
  late.header.sim_us = -1;
  archive_->Add({std::string(channel::kUavs), Encode(late)});
  EXPECT_EQ(TicksOf(Ask(channel::kUavs)), std::vector<std::int64_t>{7});
}

}  // namespace
}  // namespace muster::recorder
