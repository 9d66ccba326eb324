#include "world/restoring.h"

#include <gtest/gtest.h>

#include <functional>
#include <muster/agent_states_t.hpp>
#include <muster/clock_t.hpp>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"

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
  bool Take(std::string_view channel, T message) {
    message.header.seq = seq_++;
    answer_t answer{};
    answer.channel = channel;
    answer.data = Encode(message);
    answer.n = static_cast<std::int32_t>(answer.data.size());
    return restoring_.Take(answer);
  }
  bool TakeNothing(std::string_view channel) {
    answer_t answer{};
    answer.channel = channel;
    answer.tick = -1;
    return restoring_.Take(answer);
  }
  agent_states_t States(AgentKind kind, std::vector<std::int32_t> ids, std::int64_t tick) {
    auto states = Message<agent_states_t>(tick);
    states.header.sender = ToString(kind);
    states.kind = static_cast<std::int8_t>(kind);
    states.applied_decision = static_cast<std::int32_t>(tick + 100);
    for (const std::int32_t id : ids) {
      const AgentSpec& spec = scenario_.agents(kind)[static_cast<std::size_t>(id)];
      states.agents.push_back(ToWire(StartOf(kind, id, spec, *scenario_.ways),
                                     scenario_.rules.TimeOf(tick), scenario_.tasks));
    }
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
  /// Of these agents, if any, it says that they failed at that time, as `how` says.
  bool TakeRulings(std::int64_t tick, AgentKind kind = AgentKind::kWorker,
                   std::vector<std::int32_t> ids = {}, TimeUs failed_us = 0,
                   Ruling::Kind how = Ruling::Kind::kLost) {
    auto rulings = Message<rulings_t>(tick);
    for (const std::int32_t id : ids) {
      rulings.rulings.push_back(ToWire(Ruling{kind, id, how, failed_us}));
    }
    rulings.n = static_cast<std::int32_t>(ids.size());
    return Take(channel::kRulings, rulings);
  }
  bool TakeVerdict(std::int64_t tick, AgentKind kind, std::vector<std::int32_t> ids,
                   TimeUs failed_us, Ruling::Kind how = Ruling::Kind::kLost) {
    return TakeWorld(tick) && TakeRulings(tick, kind, std::move(ids), failed_us, how);
  }
  bool TakeClock(std::int64_t tick, std::int32_t required_decision) {
    auto clock = Message<clock_t>(tick);
    clock.phase = NumberOf(ClockPhase::kRunning);
    clock.tick_us = scenario_.rules.TimeOf(tick);
    clock.limit_us = scenario_.rules.limit_us;
    clock.decision = scenario_.rules.DecisionAt(tick);
    clock.required_decision = required_decision;
    return Take(channel::kClock, clock);
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
  std::int64_t seq_ = 0;
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
  EXPECT_TRUE(TakeRulings(3, AgentKind::kWorker, {0}, 3));
  const auto state = restoring_.Newest();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->tick, 4);
  EXPECT_EQ(state->applied_decision, 104);
  EXPECT_EQ(state->next_decision, 105);
  ASSERT_EQ(state->task_status.size(), 3u);
  EXPECT_EQ(state->task_status[1], static_cast<TaskStatus>(3));
  ASSERT_EQ(state->verdict.rulings().size(), 1u);
  EXPECT_EQ(state->verdict.rulings()[0].at_us, 3);
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
  refuse("an impossible state", [](agent_states_t* m) { m->agents[1].speed_m_s = 0; });
  refuse("after the last tick", [](agent_states_t* m) { m->tick = 10; });
  EXPECT_FALSE(Take(channel::kUavs, Message<rulings_t>(4))) << "another type";
  EXPECT_FALSE(Take(channel::kWorld, Message<rulings_t>(4))) << "another type";
  EXPECT_FALSE(TakeWorld(10)) << "after the last tick";
  EXPECT_FALSE(TakeRulings(10)) << "after the last tick";
  const auto clock_of = [&](std::int64_t run_id, TimeUs late_us) {
    auto clock = Message<clock_t>(3);
    clock.header.run_id = run_id;
    clock.phase = NumberOf(ClockPhase::kRunning);
    clock.tick_us = scenario_.rules.TimeOf(3) + late_us;
    clock.limit_us = scenario_.rules.limit_us;
    clock.decision = scenario_.rules.DecisionAt(3);
    return Take(channel::kClock, clock);
  };
  const std::int64_t run = Message<clock_t>(3).header.run_id;
  EXPECT_TRUE(clock_of(run, 0));
  EXPECT_FALSE(clock_of(run + 1, 0)) << "another run's";
  EXPECT_FALSE(clock_of(run, 1)) << "another mission's";
  EXPECT_TRUE(TakeWorld(3, 2));
  EXPECT_FALSE(restoring_.Newest()) << "a verdict on two of three tasks";
}

constexpr TimeUs kLostAfterTick2 = 2 * kMinuteUs + 1;

TEST_F(RestoringTest, GoesOnWithoutThoseThatWereLost) {
  EXPECT_TRUE(TakeStates(AgentKind::kUav, {0, 1}, 7));
  EXPECT_TRUE(TakeStates(AgentKind::kVehicle, {0, 1}, 6));
  EXPECT_TRUE(TakeStates(AgentKind::kWorker, {1}, 7));
  EXPECT_TRUE(TakeVerdict(2, AgentKind::kWorker, {}, 0));
  for (const std::int64_t tick : {5, 6}) {
    EXPECT_TRUE(TakeVerdict(tick, AgentKind::kWorker, {0}, kLostAfterTick2));
  }
  EXPECT_FALSE(restoring_.NewestWithoutLost()) << "where worker 0 is nobody knows";
  EXPECT_TRUE(TakeStates(AgentKind::kWorker, {0}, 1));
  EXPECT_FALSE(restoring_.NewestWithoutLost()) << "that was not its last report";
  EXPECT_TRUE(TakeStates(AgentKind::kWorker, {0}, 3));
  EXPECT_FALSE(restoring_.NewestWithoutLost()) << "cut off it went on, and nobody heard that";
  EXPECT_TRUE(TakeStates(AgentKind::kWorker, {0}, 2));
  EXPECT_FALSE(restoring_.NewestWithoutLost()) << "the verdict that says that it failed lacks";
  EXPECT_TRUE(TakeVerdict(3, AgentKind::kWorker, {0}, kLostAfterTick2));
  const auto state = restoring_.NewestWithoutLost();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->tick, 6);
  EXPECT_EQ(state->applied_decision, 106);
  EXPECT_EQ(state->reports.size(), 1u) << "the vehicles'";
  ASSERT_EQ(state->lost.size(), 1u);
  EXPECT_EQ(state->lost[0].agent.kind, AgentKind::kWorker);
  EXPECT_EQ(state->lost[0].agent.id, 0);
  EXPECT_TRUE(state->lost[0].agent.failed);
  EXPECT_EQ(state->lost[0].from_us, kLostAfterTick2);
  EXPECT_EQ(restoring_.OwnerOf(AgentKind::kWorker, 0), "worker");
}

TEST_F(RestoringTest, WhatAProcessSaysCountsThoughOneOfItsAgentsIsSilent) {
  TakeAllStates(2);
  EXPECT_TRUE(TakeStates(AgentKind::kUav, {0, 1}, 6));
  EXPECT_TRUE(TakeStates(AgentKind::kVehicle, {0, 1}, 6));
  EXPECT_TRUE(TakeStates(AgentKind::kWorker, {1}, 6));
  EXPECT_TRUE(TakeVerdict(2, AgentKind::kWorker, {}, 0));
  for (const std::int64_t tick : {3, 4, 5}) {
    EXPECT_TRUE(TakeVerdict(tick, AgentKind::kWorker, {0}, kLostAfterTick2));
  }
  const auto state = restoring_.NewestWithoutLost();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->tick, 6);
  ASSERT_EQ(state->lost.size(), 1u);
  EXPECT_EQ(state->lost[0].agent.id, 0);
  EXPECT_EQ(state->reports.size(), 3u) << "all classes', the workers' without that one";
}

TEST_F(RestoringTest, WhoFailedBeforeItWasLostDoesNotReturnWithItsProcess) {
  const TimeUs dry_us = kMinuteUs + 5;
  for (const std::int64_t tick : {1, 2}) EXPECT_TRUE(TakeStates(AgentKind::kUav, {0, 1}, tick));
  EXPECT_TRUE(TakeStates(AgentKind::kWorker, {0, 1}, 5));
  EXPECT_TRUE(TakeStates(AgentKind::kVehicle, {0, 1}, 5));
  for (const std::int64_t tick : {1, 2, 3, 4}) {
    auto rulings = Message<rulings_t>(tick);
    rulings.rulings.push_back(ToWire(Ruling{AgentKind::kUav, 0, Ruling::Kind::kFailed, dry_us}));
    rulings.rulings.push_back(
        ToWire(Ruling{AgentKind::kUav, 1, Ruling::Kind::kLost, kLostAfterTick2}));
    rulings.n = 2;
    EXPECT_TRUE(TakeWorld(tick));
    EXPECT_TRUE(Take(channel::kRulings, rulings));
  }
  const auto state = restoring_.NewestWithoutLost();
  ASSERT_TRUE(state);
  ASSERT_EQ(state->lost.size(), 2u);
  EXPECT_GT(state->lost[0].from_us, dry_us);
  EXPECT_EQ(state->lost[1].from_us, kLostAfterTick2);
}

TEST_F(RestoringTest, WhoWasLostAndHasReportedAgainReturns) {
  TakeAllStates(6);
  EXPECT_TRUE(TakeVerdict(5, AgentKind::kUav, {0, 1}, kLostAfterTick2));
  const auto state = restoring_.NewestWithoutLost();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->tick, 6);
  EXPECT_EQ(state->reports.size(), 3u);
  ASSERT_EQ(state->lost.size(), 2u);
  for (const Restoring::Lost& lost : state->lost) {
    EXPECT_TRUE(lost.returns);
    EXPECT_EQ(lost.from_us, kLostAfterTick2);
  }
}

/// Where a planned outage begins at the very microsecond at which its process would be lost.
TEST_F(RestoringTest, WhoFailsByAFaultIsNotLost) {
  for (const std::int64_t tick : {6, 7}) TakeAllStates(tick);
  for (const std::int64_t tick : {5, 6, 7}) {
    EXPECT_TRUE(TakeVerdict(tick, AgentKind::kUav, {0, 1}, kLostAfterTick2, Ruling::Kind::kFailed));
  }
  const auto state = restoring_.NewestWithoutLost();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->tick, 7);
  EXPECT_TRUE(state->lost.empty());
  EXPECT_EQ(state->reports.size(), 3u);
}

TEST_F(RestoringTest, NobodyIsLostWhoIsOneTickBehind) {
  EXPECT_TRUE(TakeStates(AgentKind::kUav, {0, 1}, 7));
  EXPECT_TRUE(TakeStates(AgentKind::kWorker, {0, 1}, 6));
  EXPECT_TRUE(TakeStates(AgentKind::kVehicle, {0, 1}, 7));
  EXPECT_TRUE(TakeVerdict(5, AgentKind::kWorker, {}, 0));
  ASSERT_TRUE(restoring_.NewestWithoutLost());
  EXPECT_EQ(restoring_.NewestWithoutLost()->tick, 6);
  EXPECT_TRUE(restoring_.NewestWithoutLost()->lost.empty());
  // Unless the next tick was judged without it: then it was not awaited.
  for (const std::int64_t tick : {6, 7}) {
    EXPECT_TRUE(TakeVerdict(tick, AgentKind::kWorker, {0, 1}, 6 * kMinuteUs + 1));
  }
  ASSERT_TRUE(restoring_.NewestWithoutLost());
  EXPECT_EQ(restoring_.NewestWithoutLost()->tick, 7);
  EXPECT_EQ(restoring_.NewestWithoutLost()->lost.size(), 2u);
}

TEST_F(RestoringTest, AVerdictThatWasGivenWithoutAnAgentIsGivenWithoutItAgain) {
  for (const std::int64_t tick : {6, 7}) TakeAllStates(tick);
  EXPECT_TRUE(TakeVerdict(6, AgentKind::kUav, {}, 0));
  ASSERT_TRUE(restoring_.NewestWithoutLost());
  EXPECT_TRUE(restoring_.NewestWithoutLost()->lost.empty());
  // What the UAVs said of tick 7 came too late.
  EXPECT_TRUE(TakeVerdict(7, AgentKind::kUav, {0, 1}, 6 * kMinuteUs + 1));
  const auto state = restoring_.NewestWithoutLost();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->tick, 7);
  EXPECT_EQ(state->lost.size(), 2u);
  EXPECT_EQ(state->reports.size(), 2u) << "the others'";
}

TEST_F(RestoringTest, WhereAllAreLostTheNewestVerdictCounts) {
  TakeAllStates(2);
  for (const std::int64_t tick : {2, 3, 6}) {
    auto rulings = Message<rulings_t>(tick);
    for (const AgentKind kind : kAgentKinds) {
      for (const std::int32_t id : {0, 1}) {
        rulings.rulings.push_back(ToWire(Ruling{kind, id, Ruling::Kind::kLost, kLostAfterTick2}));
      }
    }
    rulings.n = 6;
    EXPECT_TRUE(TakeWorld(tick));
    EXPECT_TRUE(Take(channel::kRulings, rulings));
  }
  EXPECT_TRUE(TakeClock(6, 5));
  const auto state = restoring_.NewestWithoutLost();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->tick, 7);
  EXPECT_EQ(state->lost.size(), 6u);
  EXPECT_EQ(state->applied_decision, 5) << "of the newest tick that it is known of";
}

TEST_F(RestoringTest, AClockTellsOfTheVerdictBeforeIt) {
  TakeAllStates(4);
  EXPECT_TRUE(TakeVerdict(3, AgentKind::kWorker, {}, 0));
  EXPECT_TRUE(TakeClock(4, 3));
  ASSERT_TRUE(restoring_.NewestWithoutLost());
  EXPECT_EQ(restoring_.NewestWithoutLost()->tick, 4);
  EXPECT_TRUE(TakeClock(6, 5));
  EXPECT_FALSE(restoring_.NewestWithoutLost()) << "there was a verdict on tick 5";
}

TEST_F(RestoringTest, WithoutVerdictsNobodyCanHaveBeenLost) {
  TakeAllStates(0);
  EXPECT_TRUE(TakeClock(0, -1));
  ASSERT_TRUE(restoring_.NewestWithoutLost());
  EXPECT_EQ(restoring_.NewestWithoutLost()->tick, 0);
  TakeAllStates(4);
  EXPECT_TRUE(TakeVerdict(3, AgentKind::kWorker, {}, 0));
  EXPECT_EQ(restoring_.NewestWithoutLost()->tick, 4);
  EXPECT_TRUE(TakeNothing(channel::kWorkers)) << "a process of workers has not begun";
  EXPECT_EQ(restoring_.NewestWithoutLost()->tick, 0);
}

TEST_F(RestoringTest, TheDecisionOfTheNextTickIsKnownFromWhoIsAhead) {
  TakeAllStates(4);
  EXPECT_TRUE(TakeVerdict(3, AgentKind::kWorker, {}, 0));
  EXPECT_FALSE(restoring_.Newest()->next_decision);
  EXPECT_TRUE(TakeStates(AgentKind::kUav, {0}, 5));
  EXPECT_EQ(restoring_.Newest()->next_decision, 105);
  EXPECT_EQ(restoring_.Newest()->applied_decision, 104);
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

TEST(ListenUs, IsLongerTheMoreMayStillBeSaid) {
  Restoring::State state;
  EXPECT_EQ(ListenUs(state, false, kSecondUs), 0);
  const TimeUs heard_all_us = ListenUs(state, true, kSecondUs);
  EXPECT_GT(heard_all_us, 0);
  state.lost.emplace_back();
  EXPECT_EQ(ListenUs(state, true, kSecondUs / 10), heard_all_us);
  EXPECT_EQ(ListenUs(state, true, kSecondUs), kSecondUs);
  state.is_certain = false;
  EXPECT_GT(ListenUs(state, true, kSecondUs), kSecondUs);
  EXPECT_EQ(ListenUs(state, true, kMinuteUs), kMinuteUs);
}

}  // namespace
}  // namespace muster::world
