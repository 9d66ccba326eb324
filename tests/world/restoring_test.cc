#include "world/truth/restoring.h"

#include <gtest/gtest.h>

#include <functional>
#include <muster/agent_states_t.hpp>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "world/model/generator.h"

namespace muster::world {
namespace {

constexpr std::int64_t kRun = 5;

template <class T>
T Message(std::int64_t tick) {
  T message{};
  message.header.run_id = kRun;
  message.header.sender = "other";
  message.tick = tick;
  return message;
}

class RestoringTest : public ::testing::Test {
 protected:
  /// Another process' answer.
  template <class T>
  bool Take(std::string_view channel, const T& message) {
    restore_t restore{};
    restore.channel = channel;
    restore.data = Encode(message);
    restore.n = static_cast<std::int32_t>(restore.data.size());
    return restoring_.Take(restore);
  }
  bool TakeNothing(std::string_view channel) {
    restore_t restore{};
    restore.channel = channel;
    restore.tick = -1;
    return restoring_.Take(restore);
  }
  agent_states_t States(AgentKind kind, std::vector<std::int32_t> ids, std::int64_t tick) {
    auto states = Message<agent_states_t>(tick);
    states.kind = static_cast<std::int8_t>(kind);
    states.applied_decision = static_cast<std::int32_t>(tick + 100);
    for (const std::int32_t id : ids) states.agents.emplace_back().id = id;
    states.n = static_cast<std::int32_t>(ids.size());
    return states;
  }
  bool TakeStates(AgentKind kind, std::vector<std::int32_t> ids, std::int64_t tick) {
    return Take(ChannelOf(kind), States(kind, std::move(ids), tick));
  }
  bool TakeWorld(std::int64_t tick, std::size_t n_tasks = 3) {
    auto world = Message<world_state_t>(tick);
    world.task_status.assign(n_tasks, 0);
    world.task_status[1] = static_cast<std::int8_t>(tick % 4);
    world.n_tasks = static_cast<std::int32_t>(n_tasks);
    return Take(channel::kWorld, world);
  }
  bool TakeRulings(std::int64_t tick) {
    auto rulings = Message<rulings_t>(tick);
    ruling_t& ruling = rulings.rulings.emplace_back();
    ruling.agent_kind = static_cast<std::int8_t>(AgentKind::kWorker);
    ruling.at_us = tick;
    rulings.n = 1;
    return Take(channel::kRulings, rulings);
  }
  void TakeAllStates(std::int64_t tick) {
    EXPECT_TRUE(TakeStates(AgentKind::kUav, {0, 1}, tick));
    EXPECT_TRUE(TakeStates(AgentKind::kWorker, {0, 1}, tick));
    EXPECT_TRUE(TakeStates(AgentKind::kVehicle, {0, 1}, tick));
  }

  /// Two agents a class, three tasks, ticks 0 to 9.
  const Scenario scenario_ = [] {
    GeneratorSettings settings = PresetByName("Random_10");
    settings.uavs = settings.workers = settings.vehicles = 2;
    settings.tasks = 3;
    settings.charging_points = 1;
    Scenario scenario = Generate(settings, 1);
    scenario.rules.limit_us = 9 * kMinuteUs;
    scenario.rules.interval_us = scenario.rules.tick_us = kMinuteUs;
    return scenario;
  }();
  Restoring restoring_{scenario_, kRun};
};

TEST_F(RestoringTest, GoesOnWithTheOldestOfTheAgentsNewestTicks) {
  ASSERT_EQ(scenario_.rules.last_tick(), 9);
  EXPECT_TRUE(TakeStates(AgentKind::kUav, {0, 1}, 4));
  EXPECT_TRUE(TakeStates(AgentKind::kUav, {1}, 5));
  EXPECT_TRUE(TakeStates(AgentKind::kUav, {0}, 3));  // old news
  EXPECT_TRUE(TakeStates(AgentKind::kWorker, {0, 1}, 5));
  EXPECT_TRUE(TakeStates(AgentKind::kVehicle, {0, 1}, 4));
  for (const std::int64_t tick : {2, 3, 4}) {
    EXPECT_FALSE(restoring_.Newest()) << "the verdict on tick 3 lacks";
    EXPECT_TRUE(TakeWorld(tick));
  }
  EXPECT_TRUE(TakeRulings(4));
  EXPECT_FALSE(restoring_.Newest()) << "the rulings on tick 3 lack";
  EXPECT_TRUE(TakeRulings(3));
  const auto state = restoring_.Newest();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->tick, 4);
  EXPECT_EQ(state->applied_decision, 104);
  ASSERT_EQ(state->task_status.size(), 3u);
  EXPECT_EQ(state->task_status[1], static_cast<TaskStatus>(3));
  ASSERT_EQ(state->rulings.size(), 1u);
  EXPECT_EQ(state->rulings[0].at_us, 3);
}

TEST_F(RestoringTest, WaitsForEveryAgent) {
  EXPECT_TRUE(TakeWorld(3));
  EXPECT_TRUE(TakeRulings(3));
  EXPECT_TRUE(TakeStates(AgentKind::kUav, {0, 1}, 4));
  EXPECT_TRUE(TakeStates(AgentKind::kWorker, {0, 1}, 4));
  EXPECT_TRUE(TakeStates(AgentKind::kVehicle, {0}, 4));
  EXPECT_FALSE(restoring_.Newest());
  EXPECT_TRUE(TakeStates(AgentKind::kVehicle, {1}, 4));
  EXPECT_TRUE(restoring_.Newest());
}

TEST_F(RestoringTest, BeginsAtTheBeginning) {
  EXPECT_TRUE(TakeNothing(channel::kWorld)) << "no verdict yet";
  EXPECT_FALSE(restoring_.Newest());
  TakeAllStates(0);
  EXPECT_EQ(restoring_.Newest()->tick, 0) << "needs no verdict";
}

TEST_F(RestoringTest, BeginsAtTheBeginningWhereAnAgentHasSaidNothingYet) {
  EXPECT_TRUE(TakeStates(AgentKind::kUav, {0, 1}, 1));
  EXPECT_TRUE(TakeNothing(channel::kWorkers));
  EXPECT_EQ(restoring_.Newest()->tick, 0);
}

TEST_F(RestoringTest, RefusesWhatCannotBe) {
  TakeAllStates(4);
  EXPECT_TRUE(TakeRulings(3));
  const auto refuse = [&](const char* what, const std::function<void(agent_states_t*)>& change) {
    agent_states_t states = States(AgentKind::kUav, {0, 1}, 7);
    change(&states);
    EXPECT_FALSE(Take(channel::kUavs, states)) << what;
  };
  refuse("another run", [](agent_states_t* m) { m->header.run_id = 6; });
  refuse("another class", [](agent_states_t* m) { m->kind = 1; });
  refuse("an agent that is not", [](agent_states_t* m) { m->agents[1].id = 2; });
  refuse("after the last tick", [](agent_states_t* m) { m->tick = 10; });
  EXPECT_FALSE(Take(channel::kUavs, Message<rulings_t>(4))) << "another type";
  EXPECT_FALSE(Take(channel::kWorld, Message<rulings_t>(4))) << "another type";
  EXPECT_TRUE(TakeWorld(3, 2));
  EXPECT_FALSE(restoring_.Newest()) << "a verdict on two of three tasks";
}

/// A liar whose states are all of a tick after the last leaves nothing to go on with.
TEST_F(RestoringTest, KnowsTheLastTick) {
  for (const AgentKind kind : kAgentKinds) EXPECT_FALSE(TakeStates(kind, {0, 1}, 1000));
  EXPECT_TRUE(TakeWorld(8));
  EXPECT_TRUE(TakeRulings(8));
  EXPECT_FALSE(restoring_.Newest());
  TakeAllStates(9);
  EXPECT_EQ(restoring_.Newest()->tick, 9);
}

}  // namespace
}  // namespace muster::world
