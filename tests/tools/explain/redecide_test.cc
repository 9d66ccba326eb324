#include "tools/explain/redecide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "base/random.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "scheduler/policies/registry.h"
#include "tests/tools/explain/mission_log.h"

namespace muster::tools {
namespace {

Scenario SmallScenario() {
  GeneratorSettings settings = PresetByName("Random_10");
  settings.rules.limit_us = 60 * kMinuteUs;
  settings.disturbances = {{0.1, 0.4}, {100, 500}, {0.01, 0.05}, {0.05, 0.1}};
  return Generate(settings, 4);
}

/// Changes the schedule of one decision.
std::vector<Packet> Edited(std::vector<Packet> packets, std::int32_t decision,
                           const std::function<void(schedule_t&)>& edit) {
  for (Packet& packet : packets) {
    if (packet.channel != channel::kSchedule) continue;
    schedule_t schedule = *Decode<schedule_t>(packet.bytes);
    if (schedule.decision != decision) continue;
    edit(schedule);
    schedule.n = static_cast<std::int32_t>(schedule.actions.size());
    packet.bytes = Encode(schedule);
  }
  return packets;
}

TEST(Redecide, EveryPolicyDecidesAsItsLogSays) {
  for (const char* policy :
       {"mpq", "certified", "horizon", "ils", "mpq-uniform", "kwta", "rollout:expect=12.5",
        "rollout-steps:shifts=1:effort=3", "neighbours:reach=6:loss=0.1"}) {
    const auto decisions = Redecide(Logged(SimulatedPackets(SmallScenario(), policy)), "");
    ASSERT_EQ(decisions.size(), 6u) << policy;
    for (const Divergence& d : DivergencesOf(decisions)) {
      ADD_FAILURE() << policy << ", decision " << d.decision << ": " << d.what;
    }
    std::size_t actions = 0;
    for (const Redecided& d : decisions) actions += d.again.actions.size();
    EXPECT_GT(actions, 10u) << policy;
  }
}

TEST(Redecide, OrderRepeatsAndRestartsDoNotMatter) {
  std::vector<Packet> packets = SimulatedPackets(SmallScenario(), "mpq");
  // A scheduler and an agent process that were started again say the same under another start.
  std::vector<Packet> more;
  for (const Packet& packet : packets) {
    if (packet.channel == channel::kSchedule) {
      schedule_t again = *Decode<schedule_t>(packet.bytes);
      if (again.decision != 3) continue;
      again.header.boot_id = 1;
      again.header.seq = 0;
      again.solve_us += 17;
      more.push_back({packet.channel, Encode(again)});
    } else if (packet.channel == channel::kWorkers) {
      agent_states_t again = *Decode<agent_states_t>(packet.bytes);
      again.header.boot_id = 1;
      more.push_back({packet.channel, Encode(again)});
    }
  }
  packets.insert(packets.end(), more.begin(), more.end());
  const std::vector<Packet> twice = packets;
  packets.insert(packets.end(), twice.begin(), twice.end());
  Random random(1, Stream::kTest);
  for (std::size_t i = packets.size(); i > 1; --i) {
    std::swap(packets[i - 1], packets[random.Below(static_cast<std::uint32_t>(i))]);
  }
  const auto decisions = Redecide(Logged(packets), "");
  ASSERT_EQ(decisions.size(), 6u);
  EXPECT_EQ(decisions[3].logged.size(), 2u);
  for (const Divergence& d : DivergencesOf(decisions)) ADD_FAILURE() << d.decision << d.what;
}

TEST(Redecide, NamesTheFirstFieldThatDiffers) {
  const std::vector<Packet> packets = SimulatedPackets(SmallScenario(), "certified");
  struct Edit {
    const char* field;
    std::function<void(schedule_t&)> edit;
  };
  const Edit edits[] = {
      {"actions[1].weight is ",  // by the last bit
       [](schedule_t& s) { s.actions[1].weight = std::nextafter(s.actions[1].weight, 1e9); }},
      {"actions[0].x_m is ", [](schedule_t& s) { s.actions[0].x_m = -s.actions[0].x_m; }},
      {"actions[2].kind is ", [](schedule_t& s) { s.actions[2].kind = 9; }},
      {"n is ", [](schedule_t& s) { s.actions.pop_back(); }},
      {"weight is ", [](schedule_t& s) { s.weight = std::nextafter(s.weight, 0); }},
      {"bound is ", [](schedule_t& s) { s.bound = std::nan(""); }},
      {"candidates is ", [](schedule_t& s) { ++s.candidates; }},
  };
  for (const Edit& edit : edits) {
    const auto divergences = DivergencesOf(Redecide(Logged(Edited(packets, 2, edit.edit)), ""));
    ASSERT_EQ(divergences.size(), 1u) << edit.field;
    EXPECT_EQ(divergences[0].decision, 2);
    EXPECT_EQ(divergences[0].at_us, 20 * kMinuteUs);
    EXPECT_EQ(divergences[0].what.rfind(edit.field, 0), 0u) << divergences[0].what;
    EXPECT_NE(divergences[0].what.find("the log says"), std::string::npos);
  }
  // What a scheduler measures in wall time is no part of a decision.
  EXPECT_TRUE(DivergencesOf(
                  Redecide(Logged(Edited(packets, 2, [](schedule_t& s) { s.solve_us += 5; })), ""))
                  .empty());
}

TEST(Redecide, SaysWhatTheLogLacks) {
  std::vector<Packet> packets = SimulatedPackets(SmallScenario(), "mpq");
  const auto without = [&](const std::function<bool(const Packet&)>& which) {
    std::vector<Packet> rest = packets;
    std::erase_if(rest, which);
    return DivergencesOf(Redecide(Logged(rest), ""));
  };
  const auto states = without([](const Packet& packet) {
    if (packet.channel != channel::kUavs) return false;
    return Decode<agent_states_t>(packet.bytes)->tick == 40;  // of decision 2
  });
  ASSERT_EQ(states.size(), 1u);
  EXPECT_EQ(states[0].decision, 2);
  EXPECT_NE(states[0].what.find("the state of uav:0 and "), std::string::npos) << states[0].what;
  const auto world = without([](const Packet& packet) {
    return packet.channel == channel::kWorld && Decode<world_state_t>(packet.bytes)->tick == 20;
  });
  ASSERT_EQ(world.size(), 1u);
  EXPECT_EQ(world[0].what, "cannot be made again, the log lacks world_state_t");
  // A mission that was broken off has neither.
  std::erase_if(packets, [](const Packet& packet) {
    const auto header = DecodeHeader(packet);
    return header && header->sim_us >= 40 * kMinuteUs;
  });
  const auto decisions = Redecide(Logged(packets), "");
  EXPECT_EQ(decisions.size(), 4u);
  EXPECT_TRUE(DivergencesOf(decisions).empty());
}

TEST(Redecide, SaysWhichAltitudesTheLogLacks) {
  Scenario scenario = SmallScenario();
  UseAir({}, &scenario);
  std::vector<Packet> packets = SimulatedPackets(scenario, "mpq");
  EXPECT_TRUE(DivergencesOf(Redecide(Logged(packets), "")).empty());
  std::erase_if(packets, [](const Packet& packet) {
    return packet.channel == channel::kClearances &&
           Decode<clearances_t>(packet.bytes)->decision == 1;
  });
  const DecisionLog log = Logged(packets);
  EXPECT_EQ(WhatIsMissing(log.decisions.at(1), log), "");
  EXPECT_EQ(WhatIsMissing(log.decisions.at(2), log), "clearances_t of decision 1");
  EXPECT_FALSE(DivergencesOf(Redecide(log, "")).empty());
}

TEST(Redecide, AnotherPolicyDecidesInTheSameSituations) {
  const DecisionLog log = Logged(SimulatedPackets(SmallScenario(), "greedy-sum"));
  const auto decisions = Redecide(log, "certified");
  ASSERT_EQ(decisions.size(), 6u);
  for (const Redecided& d : decisions) {
    EXPECT_EQ(d.missing, "");
    EXPECT_EQ(d.again.policy, "certified");
    const auto situation = SituationOf(log.decisions.at(d.decision), log);
    ASSERT_TRUE(situation);
    const auto expected = scheduler::MakePolicy("certified")->Decide(*situation);
    EXPECT_EQ(d.again.weight, expected.weight);
    EXPECT_EQ(d.again.bound, expected.bound);
    EXPECT_EQ(d.again.actions.size(), expected.actions.size());
  }
  EXPECT_THROW(Redecide(log, "nonsense"), InputError);
}

TEST(Redecide, RunsNoProgramThatALogNames) {
  // Its answer would be a decision; it is there, and it is not asked.
  const std::string program = "external:sh -c 'read h; echo hello'";
  const std::vector<Packet> packets = SimulatedPackets(SmallScenario(), "mpq");
  const DecisionLog log = Logged(Edited(packets, 2, [&](schedule_t& s) { s.policy = program; }));
  EXPECT_THROW(Redecide(log, ""), InputError);
  EXPECT_EQ(Redecide(log, "mpq").size(), 6u);
}

TEST(Redecide, AnOutsideProgramDecidesAgainWhenTheUserSaysSo) {
  const std::string program =
      "external:sh -c 'read h; echo \"{\\\"type\\\":\\\"hello\\\",\\\"version\\\":1}\"; i=0; "
      "while read s; do i=$((i+1)); "
      "echo \"{\\\"type\\\":\\\"decision\\\",\\\"id\\\":$i,\\\"actions\\\":[]}\"; done'";
  const DecisionLog log = Logged(SimulatedPackets(SmallScenario(), program));
  const auto decisions = Redecide(log, program);
  ASSERT_EQ(decisions.size(), 6u);
  EXPECT_TRUE(DivergencesOf(decisions).empty());
}

TEST(Redecide, CountsActionsThatAreNotShared) {
  const auto action = [](int kind, int uav, int task) {
    action_t a{};
    a.kind = static_cast<std::int8_t>(kind);
    a.uav_id = uav;
    a.task_id = task;
    return a;
  };
  schedule_t one{}, two{};
  one.actions = {action(0, 5, -1), action(3, 1, 1), action(3, 2, 2), action(3, 3, 3)};
  two.actions = {action(3, 1, 1), action(3, 2, 3)};
  EXPECT_EQ(DifferenceOf(one, two).only_again, 2);  // the stay does not count
  EXPECT_EQ(DifferenceOf(one, two).only_logged, 1);
}

}  // namespace
}  // namespace muster::tools
