#include <fmt/format.h>
#include <gtest/gtest.h>

#include "agents/core/agent_process.h"
#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "scheduler/process/scheduler_process.h"
#include "simulation/simulator.h"
#include "tests/cases.h"
#include "tests/simulation/archivist.h"
#include "tests/simulation/audited.h"
#include "tests/simulation/crew.h"
#include "tools/record/digest.h"
#include "world/world_process.h"

namespace muster::tools {
namespace {

using testing::Archivist;
using testing::Crew;
using testing::Lossy;
using testing::StartProcess;

Scenario SmallScenario() { return Generate(PresetByName("Random_10"), 5); }

std::string SimulatedDigest(const std::string& json, const std::string& policy = "mpq") {
  RunRecord record;
  Audited audited;
  Simulate(json, policy, [&](const Packet& packet) {
    record.Add(packet);
    audited.Add(packet);
  });
  return Digest(record);
}

struct Outcome {
  bool ended = false;
  std::string digest;
  int sent = 0;
};

/// Kills `victims` when `kill_at` packets have been sent, and starts them again, one after the
/// other.
struct Kill {
  std::vector<std::string> victims;
  int kill_at = 0;
  TimeUs apart_us = 0;
};

Outcome RunOver(const PacketFaults& faults, std::uint64_t seed, const std::string& json,
                const std::optional<Kill>& kill = {}, const std::string& policy = "mpq") {
  Crew network(faults, seed);
  for (const char* name : {"world", "uav", "worker", "vehicle", "scheduler"}) {
    network.Add(StartProcess(name, 0, json, {}, policy));
  }
  const Scenario scenario = ParseScenario(json, "scenario");
  if (kill && kill->victims.size() > 1) {  // What it loses the true one has repeated to it.
    network.Add(std::make_unique<Archivist>(scenario, false), PacketFaults{});
  }
  RunRecord record;
  Audited audited;
  Outcome outcome;
  bool ended = false;
  const auto observe = [&](const Packet& packet) {
    ++outcome.sent;
    record.Add(packet);
    audited.Add(packet);
    if (packet.channel == "MUSTER_CLOCK") ended |= Decode<clock_t>(packet.bytes)->phase == 2;
  };
  if (kill) {
    network.Run(
        3600 * kSecondUs, [&] { return ended || outcome.sent >= kill->kill_at; }, observe);
    for (const std::string& victim : kill->victims) network.Kill(victim);
    for (const std::string& victim : kill->victims) {
      network.Add(StartProcess(victim, 1, json, {}, policy));
      network.Run(
          network.now_us() + kill->apart_us, [&] { return ended; }, observe);
    }
  }
  outcome.ended = network.Run(
      3600 * kSecondUs, [&] { return ended; }, observe);
  outcome.digest = Digest(record);
  return outcome;
}

TEST(Lockstep, OutcomeDoesNotDependOnLossDuplicationOrOrder) {
  const std::string json = ScenarioToJson(SmallScenario());
  const std::string expected = SimulatedDigest(json);
  const PacketFaults none;
  EXPECT_EQ(RunOver(none, 1, json).digest, expected);
  const PacketFaults bad = Lossy(0.3, 0.1, 3000);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Outcome outcome = RunOver(bad, seed, json);
    EXPECT_TRUE(outcome.ended) << "seed " << seed;
    EXPECT_EQ(outcome.digest, expected) << "seed " << seed;
  }
}

TEST(Lockstep, AnyOneProcessMayBeKilledAtAnyTime) {
  const std::string json = ScenarioToJson(SmallScenario());
  const std::string expected = SimulatedDigest(json);
  for (const double loss : {0.0, 0.2}) {
    const PacketFaults faults = Lossy(loss, 0, 150);
    const int sent = RunOver(faults, 1, json).sent;
    Random random(1, Stream::kTest);
    for (const char* victim : {"world", "uav", "worker", "vehicle", "scheduler"}) {
      for (std::uint64_t i = 0; i < Cases(3, 8); ++i) {
        const int kill_at = static_cast<int>(random.Below(static_cast<std::uint32_t>(sent)));
        const Outcome outcome = RunOver(faults, 1, json, Kill{{victim}, kill_at});
        ASSERT_TRUE(outcome.ended)
            << victim << " killed after packet " << kill_at << ", loss " << loss;
        ASSERT_EQ(outcome.digest, expected)
            << victim << " killed after packet " << kill_at << ", loss " << loss;
      }
    }
  }
}

TEST(Lockstep, WhoIsKilledOnAFreeMoveGoesOnToTheSamePlace) {
  const std::string json = ScenarioToJson(SmallScenario());
  const PacketFaults faults = Lossy(0.1, 0, 150);
  Random random(3, Stream::kTest);
  for (const char* policy : {"greedy-sum", "horizon"}) {
    const std::string expected = SimulatedDigest(json, policy);
    const int sent = RunOver(faults, 1, json, {}, policy).sent;
    for (std::uint64_t i = 0; i < Cases(12, 24); ++i) {
      std::vector<std::string> victims = {i % 2 == 0 ? "uav" : "worker"};
      if (i % 4 >= 2) victims.push_back(i % 3 == 0 ? "scheduler" : "world");
      const auto kill_at = static_cast<int>(random.Below(static_cast<std::uint32_t>(sent)));
      SCOPED_TRACE(
          fmt::format("{}: {} killed after packet {}", policy, fmt::join(victims, ", "), kill_at));
      const Outcome outcome = RunOver(faults, 1, json, Kill{victims, kill_at}, policy);
      ASSERT_TRUE(outcome.ended);
      ASSERT_EQ(outcome.digest, expected);
    }
  }
}

TEST(Lockstep, AnyOneProcessMayBeKilledBeforeTheMissionBegins) {
  const std::string json = ScenarioToJson(SmallScenario());
  const std::string expected = SimulatedDigest(json);
  for (const char* victim : {"world", "uav", "worker", "vehicle", "scheduler"}) {
    for (int kill_at = 0; kill_at < 20; kill_at += static_cast<int>(Cases(4, 2))) {
      const Outcome outcome = RunOver({}, 1, json, Kill{{victim}, kill_at});
      ASSERT_TRUE(outcome.ended) << victim << " killed after packet " << kill_at;
      ASSERT_EQ(outcome.digest, expected) << victim << " killed after packet " << kill_at;
    }
  }
}

TEST(Lockstep, AnyNumberOfProcessesMayBeKilledAtOnceWhereSomebodyListens) {
  const std::string json = ScenarioToJson(SmallScenario());
  const std::string expected = SimulatedDigest(json);
  const PacketFaults faults = Lossy(0, 0, 150);
  const int sent = RunOver(faults, 1, json).sent;
  Random random(2, Stream::kTest);
  for (std::uint64_t i = 0; i < Cases(12, 36); ++i) {
    std::vector<std::string> victims = {"world", "uav", "worker", "vehicle", "scheduler"};
    random.Shuffle(victims);
    victims.resize(2 + random.Below(4));
    // Some before the first tick.
    const auto kill_at =
        static_cast<int>(random.Below(i % 4 == 0 ? 20 : static_cast<std::uint32_t>(sent)));
    const TimeUs apart_us = i % 3 == 0 ? 0 : random.Below(3'000'000);
    SCOPED_TRACE(fmt::format("{} killed after packet {}, {} us apart", fmt::join(victims, ", "),
                             kill_at, apart_us));
    const Outcome outcome = RunOver(faults, 1, json, Kill{victims, kill_at, apart_us});
    ASSERT_TRUE(outcome.ended);
    ASSERT_EQ(outcome.digest, expected);
  }
}

TEST(Lockstep, WhoHasJustBeenToldItsStateDoesNotSayThatNothingHasBegun) {
  const std::string json = ScenarioToJson(SmallScenario());
  Packet scenario, states;
  Simulate(json, "mpq", [&](const Packet& packet) {
    if (packet.channel == "MUSTER_SCENARIO") scenario = packet;
    if (packet.channel == "MUSTER_UAVS") states = packet;
  });
  const std::int64_t run_id = DecodeHeader(states)->run_id;
  agents::AgentProcess uav({run_id, "uav", 1}, 0, AgentKind::kUav, agents::IdRange());
  std::vector<Packet> out;
  uav.Step({scenario}, {1, 0}, &out);
  out.clear();
  uav.Step({}, {kSecondUs, 0}, &out);
  const auto question = Decode<request_t>(out.at(0).bytes);
  ASSERT_TRUE(question);
  answer_t answer = AnswerTo(*question, 0, states.bytes);
  answer.header.run_id = run_id;
  answer.header.sender = "recorder";
  request_t request{};
  request.header.run_id = run_id;
  request.header.sender = "world";
  request.channel = "MUSTER_UAVS";
  out.clear();
  uav.Step({{"MUSTER_ANSWER", Encode(answer)}, {"MUSTER_REQUEST", Encode(request)}},
           {kSecondUs + 1, 0}, &out);
  ASSERT_FALSE(out.empty());  // its states, again
  for (const Packet& packet : out) {
    if (packet.channel != "MUSTER_ANSWER") continue;
    EXPECT_FALSE(Decode<answer_t>(packet.bytes)->data.empty());
  }
}

// Another process of its class has answered first, and is one tick ahead of what ours has said.
TEST(Lockstep, WhatAnotherProcessOfTheClassSaysOfItsOwnAgentsIsNoStateToGoOnFrom) {
  const std::string json = ScenarioToJson(SmallScenario());
  Packet scenario;
  std::map<std::int64_t, agent_states_t> states;  // by tick
  Simulate(json, "mpq", [&](const Packet& packet) {
    if (packet.channel == "MUSTER_SCENARIO") scenario = packet;
    if (packet.channel != "MUSTER_UAVS") return;
    const auto told = Decode<agent_states_t>(packet.bytes);
    states[told->tick] = *told;
  });
  const auto newest = states.rbegin()->first;
  const auto share = [](agent_states_t all, bool first) {
    std::erase_if(all.agents, [&](const agent_t& agent) { return (agent.id < 5) != first; });
    all.n = static_cast<std::int32_t>(all.agents.size());
    return Encode(all);
  };
  const std::int64_t run_id = states.at(newest).header.run_id;
  const auto last = static_cast<std::int32_t>(SmallScenario().uavs.size()) - 1;
  agents::AgentProcess uav({run_id, "uav-2", 1}, 0, AgentKind::kUav, std::pair(5, last));
  std::vector<Packet> out;
  uav.Step({scenario}, {1, 0}, &out);
  out.clear();
  uav.Step({}, {kSecondUs, 0}, &out);
  const auto question = Decode<request_t>(out.at(0).bytes);
  ASSERT_TRUE(question);
  const auto answer = [&](std::int64_t tick, bool first) {
    answer_t wire = AnswerTo(*question, tick, share(states.at(tick), first));
    wire.header.run_id = run_id;
    wire.header.sender = first ? "uav-1" : "world";
    return Packet{"MUSTER_ANSWER", Encode(wire)};
  };
  uav.Step({answer(newest, true)}, {kSecondUs + 1, 0}, &out);
  EXPECT_EQ(uav.state(), ProcessState::kStarting);
  uav.Step({answer(newest - 1, false)}, {kSecondUs + 2, 0}, &out);
  EXPECT_EQ(uav.state(), ProcessState::kRunning);
}

// Who listens says again what a world that started again was told, to the next one, while those
// who know better are silent.
TEST(Lockstep, OldAnswersDoNotSendTheWorldBack) {
  const std::string json = ScenarioToJson(SmallScenario());
  Crew network;
  for (const char* name : {"world", "uav", "worker", "vehicle", "scheduler"}) {
    network.Add(StartProcess(name, 0, json));
  }
  RunRecord record;
  Audited audited;
  std::vector<Packet> old;
  std::int64_t tick = 0, boot = 0, first_tick = -1;
  bool ended = false;
  const auto observe = [&](const Packet& packet) {
    record.Add(packet);
    audited.Add(packet);
    if (packet.channel == "MUSTER_ANSWER" && boot == 1) old.push_back(packet);
    if (packet.channel != "MUSTER_CLOCK") return;
    const auto clock = Decode<clock_t>(packet.bytes);
    tick = clock->tick;
    if (clock->header.boot_id == 2 && first_tick < 0) first_tick = tick;
    ended |= clock->phase == 2;
  };
  const auto run_to = [&](std::int64_t until) {
    ASSERT_TRUE(network.Run(
        3600 * kSecondUs, [&] { return ended || tick >= until; }, observe));
  };
  const auto start_again = [&] {
    network.Kill("world");
    network.Add(StartProcess("world", ++boot, json));
  };
  run_to(10);
  start_again();
  run_to(40);
  ASSERT_GE(old.size(), 9U);
  const std::vector<std::string> knowing = {"uav", "worker", "vehicle"};
  for (const std::string& name : knowing) network.Stop(name, true);
  start_again();
  std::size_t said = 0;
  network.set_intruder([&](const Packet&) { return old[said++ % old.size()]; });
  network.Run(
      network.now_us() + kSecondUs, [] { return false; }, observe);
  EXPECT_GT(said, old.size());
  network.set_intruder({});
  for (const std::string& name : knowing) network.Stop(name, false);
  run_to(kNever);
  EXPECT_GE(first_tick, 39);
  EXPECT_EQ(Digest(record), SimulatedDigest(json));
}

TEST(Lockstep, AClassMayBeSplitOverProcesses) {
  const std::string json = ScenarioToJson(SmallScenario());
  Crew network({.loss = 0.1}, 1);
  for (const char* name : {"world", "worker", "vehicle", "scheduler"}) {
    network.Add(StartProcess(name, 0, json));
  }
  const agents::IdRange halves[] = {std::pair(0, 7), std::pair(8, 19)};
  for (int i = 0; i < 2; ++i) {
    network.Add(std::make_unique<agents::AgentProcess>(Identity{1, "uav-" + std::to_string(i), 0},
                                                       0, AgentKind::kUav, halves[i]));
  }
  RunRecord record;
  Audited audited;
  bool ended = false;
  network.Run(
      3600 * kSecondUs, [&] { return ended; },
      [&](const Packet& packet) {
        record.Add(packet);
        audited.Add(packet);
        if (packet.channel == "MUSTER_CLOCK") {
          ended |= Decode<clock_t>(packet.bytes)->phase == 2;
        }
      });
  EXPECT_EQ(Digest(record), SimulatedDigest(json));
}

TEST(Lockstep, TwoProcessesForOneAgentAreAnError) {
  const std::string json = ScenarioToJson(SmallScenario());
  Crew network({}, 1);
  network.Add(StartProcess("world", 0, json));
  for (const char* name : {"a", "b"}) {
    network.Add(std::make_unique<agents::AgentProcess>(Identity{1, name, 0}, 0, AgentKind::kUav,
                                                       agents::IdRange()));
  }
  EXPECT_THROW(network.Run(
                   10 * kSecondUs, [] { return false; }, [](const Packet&) {}),
               InputError);
}

TEST(Lockstep, OutcomeDoesNotDependOnTheTick) {
  Scenario scenario = SmallScenario();
  scenario.disturbances.wind = {0.1, 0.4};
  scenario.disturbances.communication_m = {100, 500};
  scenario.disturbances.match_failure = {0.05, 0.1};
  scenario.disturbances.agent_failure = {0.01, 0.05};
  std::vector<std::string> outcomes;
  for (const TimeUs tick_s : {10, 30, 600}) {
    scenario.rules.tick_us = tick_s * kSecondUs;
    RunRecord record;
    Audited audited;
    Simulate(ScenarioToJson(scenario), "mpq", [&](const Packet& packet) {
      record.Add(packet);
      audited.Add(packet);
    });
    outcomes.push_back(Digest(record));
  }
  EXPECT_EQ(outcomes[0], outcomes[1]);
  EXPECT_EQ(outcomes[0], outcomes[2]);
}

}  // namespace
}  // namespace muster::tools
