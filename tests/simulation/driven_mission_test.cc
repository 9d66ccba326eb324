// Missions of which agents are measured: the example's program for one of them, and many that tell
// the truth late, with orders, disturbances and faults.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "agents/driver/driver_programs.h"
#include "base/spawn.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/simulation/audited.h"
#include "tests/simulation/order_draws.h"
#include "tools/explain/redecide.h"
#include "tools/explain/story.h"
#include "tools/record/digest.h"
#include "tools/record/run_record.h"
#include "tools/simulate/virtual_mission.h"
#include "tools/trials/truthful_drivers.h"

namespace muster::tools {
namespace {

using agents::DriverPrograms;
using agents::DriverSession;

constexpr std::int32_t kDriven = 3;

/// Random_1 of seed 1 with UAV 3 driven by the example with those options; nullptr: computed.
/// `lost_after_us`: real time. What a busy machine needs is no silence.
RunRecord Fly(const char* arguments, bool measured = true, Packets* packets = nullptr,
              TimeUs lost_after_us = kMinuteUs) {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  scenario.uavs[kDriven].measured = measured;
  RunRecord record;
  Audited audited;
  DriverSession::Rules rules;
  rules.lost_after_us = lost_after_us;
  Simulate(
      ScenarioToJson(scenario), "horizon",
      [&](const Packet& packet) {
        record.Add(packet);
        audited.Add(packet);
        if (packets != nullptr) packets->all.push_back(packet);
      },
      {}, {},
      [&](AgentKind kind) -> std::unique_ptr<agents::DriverPort> {
        if (arguments == nullptr || kind != AgentKind::kUav) return nullptr;
        const std::string command =
            fmt::format("python3 {} {}", MUSTER_EXAMPLES "/uav.py", arguments);
        return std::make_unique<DriverPrograms>(
            std::vector<DriverPrograms::Command>{{kDriven, agents::DriverCommand(command)}}, rules);
      });
  EXPECT_TRUE(record.CheckComplete().complete);
  return record;
}

/// Its failures, as events tell them.
std::vector<std::string> FailuresOf(const RunRecord& record) {
  std::vector<std::string> list;
  for (const event_t& event : record.events()) {
    if (event.kind == EventKind::kAgentFailed) {
      list.push_back(fmt::format("uav:{} {}", event.uav_id, event.detail));
    }
  }
  return list;
}

/// When the driven one's sensing began.
std::vector<TimeUs> StartsOf(const RunRecord& record) {
  std::vector<TimeUs> list;
  for (const event_t& event : record.events()) {
    if (event.kind == EventKind::kSensingStarted && event.uav_id == kDriven) {
      list.push_back(event.at_us);
    }
  }
  return list;
}

class DrivenMission : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!FindProgram("python3")) GTEST_SKIP() << "no python3";
  }
};

TEST_F(DrivenMission, OnTimeItsOutcomesAreTheComputedOnes) {
  const RunRecord computed = Fly(nullptr, false), driven = Fly("");
  EXPECT_GE(StartsOf(computed).size(), 2U);
  EXPECT_EQ(Digest(driven), Digest(computed));
}

TEST(MeasuredMissions, WhomNobodyDrivesDoesAsComputed) {
  EXPECT_EQ(Digest(Fly(nullptr, true)), Digest(Fly(nullptr, false)));
}

TEST_F(DrivenMission, LateItMovesWhatItTakesPartIn) {
  const RunRecord computed = Fly(nullptr), driven = Fly("--late 20");
  EXPECT_TRUE(FailuresOf(driven).empty());
  ASSERT_GE(StartsOf(driven).size(), 2U);
  EXPECT_NE(Digest(driven), Digest(computed));
  EXPECT_GE(StartsOf(driven).front(), StartsOf(computed).front());
}

TEST_F(DrivenMission, UntilItIsReadyNobodyPlansWithIt) {
  Packets packets;
  const RunRecord driven = Fly("--ready 42", true, &packets);
  EXPECT_TRUE(FailuresOf(driven).empty());
  std::vector<std::string> waits;
  for (const event_t& event : driven.events()) {
    if (event.kind != EventKind::kDriverWaits) continue;
    EXPECT_EQ(event.uav_id, kDriven);
    waits.push_back(event.detail);
  }
  EXPECT_EQ(waits, std::vector<std::string>{"minute 42"});
  ASSERT_FALSE(StartsOf(driven).empty());
  EXPECT_GT(StartsOf(driven).front(), 42 * kMinuteUs);
  EXPECT_LT(StartsOf(Fly(nullptr)).front(), 42 * kMinuteUs);
  // It came online in minute 8.
  const std::string text =
      ToText(TellAgent(ReadDecisionLog(&packets), "run", AgentKind::kUav, kDriven, {}));
  EXPECT_NE(text.find("decision   1  0:10:00  not ready\n"), std::string::npos) << text;
  EXPECT_NE(text.find("driver waits uav:3: minute 42\n"), std::string::npos) << text;
  EXPECT_NE(text.find("decision   5  0:50:00  idle: "), std::string::npos) << text;
}

TEST_F(DrivenMission, WhatItSaysToPeopleIsHeardOnceAndChangesNothing) {
  Packets packets;
  const RunRecord driven = Fly("--calls 20", true, &packets);
  EXPECT_EQ(Digest(driven), Digest(Fly(nullptr)));
  std::vector<std::string> said;
  for (const event_t& event : driven.events()) {
    const auto kind = static_cast<EventKind>(event.kind);
    if (!IsOfDriver(kind)) continue;
    said.push_back(fmt::format("{} uav:{} {}", ToString(kind), event.uav_id, event.detail));
  }
  EXPECT_EQ(said, (std::vector<std::string>{"driver_calls uav:3 a rotor is loose",
                                            "driver_says uav:3 all right again"}));
  const std::string text =
      ToText(TellAgent(ReadDecisionLog(&packets), "run", AgentKind::kUav, kDriven, {}));
  EXPECT_NE(text.find("driver calls uav:3: a rotor is loose\n"), std::string::npos) << text;
}

TEST_F(DrivenMission, WhenItDiesItFailsWithTheReason) {
  EXPECT_EQ(FailuresOf(Fly("--dies 25")),
            std::vector<std::string>{"uav:3 its driver: its program exited with code 1"});
}

TEST_F(DrivenMission, WhenItIsSilentTheMissionDoesNotWaitForLong) {
  const auto failures = FailuresOf(Fly("--silent 25:35", true, nullptr, 3 * kSecondUs));
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_EQ(failures[0].find("uav:3 its driver: silent for 3 s while it was "), 0U) << failures[0];
}

/// Of a mission: what its log says, audited and decided again.
class Watched {
 public:
  void Add(const Packet& packet) {
    record_.Add(packet);
    audited_.Add(packet);
    packets_.all.push_back(packet);
  }
  void DecideAgain() {
    EXPECT_TRUE(record_.CheckComplete().complete);
    const std::vector<Redecided> again = Redecide(ReadDecisionLog(&packets_), "", {});
    EXPECT_EQ(again.size(), 10U);
    for (const Redecided& decision : again) {
      EXPECT_EQ(decision.missing, "");
      EXPECT_EQ(FirstDifference(decision.again, decision.logged.front()), "");
    }
  }
  /// Sensing that was given up because somebody was late.
  int late() const {
    int n = 0;
    for (const event_t& event : record_.events()) {
      n += event.detail.find(" late") != std::string::npos ? 1 : 0;
    }
    return n;
  }
  int said_to_fail() const {
    int n = 0;
    for (const event_t& event : record_.events()) {
      if (event.kind != EventKind::kAgentFailed) continue;
      n += event.detail == "its driver: tired" ? 1 : 0;
    }
    return n;
  }

 private:
  RunRecord record_;
  Audited audited_;
  Packets packets_;
};

Scenario DrawMeasured(std::uint64_t seed) {
  Scenario scenario = Draw(seed);
  scenario.rules.patience_us = kMinuteUs * TimeUs{seed % 3 == 0 ? 10 : 3};
  for (const AgentKind kind : kAgentKinds) {
    for (AgentSpec& agent : ByKind(kind, scenario.uavs, scenario.workers, scenario.vehicles)) {
      agent.measured = true;
    }
  }
  return scenario;
}

int Missions(int usual) {
  const char* const given = std::getenv("MUSTER_MEASURED_MISSIONS");
  return given == nullptr ? usual : std::atoi(given);
}

TEST(MeasuredMissions, WhoTellsTheTruthIsBelievedWhateverElseHappens) {
  int late = 0, failed = 0;
  TruthfulDrivers::Counts counts;
  const auto n = static_cast<std::uint64_t>(Missions(40));
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Watched watched;
    const Scenario scenario = DrawMeasured(seed);
    Simulate(
        ScenarioToJson(scenario), PolicyOf(seed),
        [&](const Packet& packet) { watched.Add(packet); }, {}, DrawOrders(seed),
        [&](AgentKind kind) {
          return std::make_unique<TruthfulDrivers>(seed, kind, scenario.n_agents(kind), &counts);
        });
    watched.DecideAgain();
    late += watched.late();
    failed += watched.said_to_fail();
    if (HasFailure()) return;
  }
  EXPECT_GT(late, static_cast<int>(n) / 4);
  EXPECT_EQ(failed, counts.failures);
  EXPECT_GT(counts.reports, 100 * static_cast<int>(n));
}

TEST(MeasuredMissions, AreWholeUnderFaults) {
  TruthfulDrivers::Counts counts;
  const auto n = static_cast<std::uint64_t>(Missions(40)) / 2;
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    VirtualMission mission;
    mission.scenario = DrawMeasured(seed);
    mission.policy = PolicyOf(seed);
    mission.orders = DrawOrders(seed);
    mission.fault_seed = seed;
    mission.drop = seed % 3 == 0 ? 0.1 : 0;
    mission.faults = DrawFaults(seed);
    mission.drivers = [&](AgentKind kind) {
      return std::make_unique<TruthfulDrivers>(seed, kind, mission.scenario.n_agents(kind),
                                               &counts);
    };
    Watched watched;
    mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t) {
      watched.Add(*event.packet);
    };
    const MissionResult result = RunVirtualMission(mission);
    EXPECT_EQ(result.end, MissionEnd::kComplete);
    watched.DecideAgain();
    if (HasFailure()) return;
  }
}

/// What the audit finds first when the report of UAV 3, whom nobody drives, is changed at one tick.
std::string FirstFinding(std::int64_t tick, const std::function<void(agent_t*)>& change) {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  scenario.uavs[kDriven].measured = true;
  audit::Auditor auditor;
  Simulate(ScenarioToJson(scenario), "horizon", [&](const Packet& packet) {
    auto states = packet.channel == channel::kUavs ? DecodeValid<agent_states_t>(packet.bytes)
                                                   : std::optional<agent_states_t>();
    if (!states || states->tick != tick) return auditor.Add(packet);
    for (agent_t& agent : states->agents) {
      if (agent.id == kDriven) change(&agent);
    }
    auditor.Add({packet.channel, Encode(*states)});
  });
  const auto findings = auditor.Finish();
  return findings.empty() ? "" : findings.front().invariant + ": " + findings.front().text;
}

TEST(MeasuredMissions, TheAuditSeesWhatCannotBeTold) {
  // It is on its way at tick 22 and senses at tick 36.
  constexpr std::int64_t kOnItsWay = 22, kSenses = 36;
  EXPECT_EQ(FirstFinding(kOnItsWay, [](agent_t*) {}), "");
  const auto starts_with = [](const std::string& text, std::string_view what) {
    EXPECT_EQ(text.substr(0, what.size()), what) << text;
  };
  starts_with(FirstFinding(kOnItsWay, [](agent_t* a) { a->x_m += 20'000; }),
              "speed: uav:3 says to make ");
  starts_with(FirstFinding(kOnItsWay, [](agent_t* a) { a->arrive_us -= 60 * kSecondUs; }),
              "speed: uav:3 says to make ");
  starts_with(FirstFinding(kOnItsWay, [](agent_t* a) { a->range_left_m += 800; }),
              "range: uav:3 says to have ");
  starts_with(FirstFinding(kOnItsWay, [](agent_t* a) { a->target_id ^= 1; }), "motion: uav:3 ");
  starts_with(
      FirstFinding(kOnItsWay, [](agent_t* a) { a->status = NumberOf(AgentStatus::kFailed); }),
      "rulings: uav:3 says that it cannot go on, and is not ruled to have failed");
  // At tick 19 it has been free, and is commanded at tick 20.
  starts_with(FirstFinding(20,
                           [](agent_t* a) {
                             a->busy_until_us = kNever;
                             a->status = NumberOf(AgentStatus::kNotReady);
                           }),
              "idle-agents-only: decision 1, ");
  starts_with(FirstFinding(kSenses, [](agent_t* a) { a->busy_until_us -= kSecondUs; }),
              "motion: uav:3 ");
}

}  // namespace
}  // namespace muster::tools
