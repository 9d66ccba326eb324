// Missions that go on without a lost process, in virtual time.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/own_rule.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/cases.h"
#include "tests/simulation/archivist.h"
#include "tests/simulation/crew.h"
#include "tests/tools/explain/mission_log.h"
#include "tools/audit/auditor.h"
#include "tools/audit/report_check.h"
#include "tools/explain/redecide.h"
#include "tools/explain/story.h"
#include "tools/record/digest.h"
#include "tools/record/report_json.h"

namespace muster::tools {
namespace {

using testing::Crew;
using testing::Lossy;

constexpr int kProcessLost = 11;
constexpr int kProcessBack = 12;
constexpr int kStateUnknown = 25;

/// Five processes over a virtual network, and somebody who listens; the world goes on without those
/// that are lost for one second, unless told otherwise.
class LossyMission {
 public:
  explicit LossyMission(const PacketFaults& faults = {}, std::uint64_t seed = 1,
                        std::vector<world::Outage> outages = {}, TimeUs lost_after_us = kSecondUs)
      : outages_(std::move(outages)),
        lost_after_us_(lost_after_us),
        scenario_(Generate(PresetByName("Random_10"), 5)),
        json_(ScenarioToJson(scenario_)),
        network_(faults, seed) {
    for (const char* name : {"world", "uav", "worker", "vehicle", "scheduler"}) Start(name);
    // It hears everything, as the recorder does in the end: its senders repeat what the log lacks.
    network_.Add(std::make_unique<testing::Archivist>(scenario_, true), PacketFaults());
  }

  /// See AgentProcess.
  inline static std::size_t most_whole = agents::AgentProcess::kMostWhole;

  void Start(const std::string& name) {
    world::WorldOptions options;
    options.goes_on = true;
    options.lost_after_us = lost_after_us_;
    options.faults.outages = outages_;
    network_.Add(testing::StartProcess(name, boots_[name]++, json_, options, "mpq", most_whole));
  }
  void Kill(const std::string& name) { network_.Kill(name); }
  void Stop(const std::string& name, bool stopped) { network_.Stop(name, stopped); }
  void Isolate(const std::string& name, bool isolated) { network_.Isolate(name, isolated); }

  /// Until that mission time, or the end.
  bool RunTo(TimeUs mission_us) {
    return network_.Run(
        7200 * kSecondUs, [&] { return ended_ || now_us_ >= mission_us; },
        [&](const Packet& packet) { Observe(packet); });
  }
  /// Until that channel has carried a message of that mission time, or the end.
  bool RunUntilSaid(std::string_view name, TimeUs mission_us) {
    bool said = false;
    return network_.Run(
        7200 * kSecondUs, [&] { return ended_ || said; },
        [&](const Packet& packet) {
          Observe(packet);
          said |= packet.channel == name && DecodeHeader(packet)->sim_us == mission_us;
        });
  }
  bool RunToEnd() { return RunTo(kNever) && ended_; }
  /// What is still said after the end.
  void RunOn(TimeUs network_us) {
    network_.Run(
        network_.now_us() + network_us, [] { return false; },
        [&](const Packet& packet) { Observe(packet); });
  }
  TimeUs limit_us() const { return scenario_.rules.limit_us; }

  const RunRecord& record() const { return record_; }
  /// After ExpectSound().
  const DecisionLog& log() const { return log_; }
  int Count(int kind, const std::string& detail = "") const {
    int n = 0;
    for (const event_t& event : record_.events()) {
      n += event.kind == kind && (detail.empty() || event.detail == detail);
    }
    return n;
  }
  /// Commands for agents of that class in decisions [from, until) of mission time.
  int Commands(AgentKind kind, TimeUs from, TimeUs until) const {
    int n = 0;
    for (const auto& [d, schedule] : record_.schedules()) {
      const TimeUs t = d * scenario_.rules.interval_us;
      if (t < from || t >= until) continue;
      for (const action_t& action : schedule.actions) {
        n += ByKind(kind, action.uav_id, action.worker_id, action.vehicle_id) >= 0;
      }
    }
    return n;
  }
  /// Every invariant of the audit, its comparison with the report, and completeness; and every
  /// decision, made again from the log, is the same.
  void ExpectSound() {
    const RunRecord::Completeness complete = record_.CheckComplete();
    EXPECT_TRUE(complete.complete) << complete.n_missing << " missing, " << complete.repeated
                                   << " repeated, " << complete.gaps.size() << " gaps, first "
                                   << (complete.missing.empty() ? "" : complete.missing[0].owner);
    for (const audit::Violation& violation : auditor_.Finish()) {
      ADD_FAILURE() << violation.at_us << " us: " << violation.invariant << ": " << violation.text;
    }
    log_ = Logged(packets_);
    for (const Divergence& divergence : DivergencesOf(Redecide(log_, ""))) {
      ADD_FAILURE() << "decision " << divergence.decision << ": " << divergence.what;
    }
    if (!auditor_.facts()) return;
    for (const audit::Violation& violation :
         audit::CheckReportFile(Report(record_), *auditor_.facts())) {
      ADD_FAILURE() << violation.text;
    }
  }

 private:
  void Observe(const Packet& packet) {
    record_.Add(packet);
    auditor_.Add(packet);
    packets_.push_back(packet);
    if (packet.channel != channel::kClock) return;
    const auto clock = Decode<clock_t>(packet.bytes);
    now_us_ = std::max(now_us_, clock->tick_us);
    ended_ |= clock->phase == 2;
  }

  std::vector<world::Outage> outages_;
  TimeUs lost_after_us_;
  Scenario scenario_;
  std::string json_;
  Crew network_;
  std::map<std::string, std::int64_t> boots_;
  RunRecord record_;
  audit::Auditor auditor_;
  std::vector<Packet> packets_;
  DecisionLog log_;
  TimeUs now_us_ = -1;
  bool ended_ = false;
};

/// Whether agents are told whole at every tick or only what has changed of them.
class OnLoss : public ::testing::TestWithParam<std::size_t> {
 protected:
  void SetUp() override { LossyMission::most_whole = GetParam(); }
};
INSTANTIATE_TEST_SUITE_P(WholeOrChanges, OnLoss,
                         ::testing::Values(agents::AgentProcess::kMostWhole, std::size_t{0}));

std::string UndisturbedDigest() {
  RunRecord record;
  Simulate(ScenarioToJson(Generate(PresetByName("Random_10"), 5)), "mpq",
           [&](const Packet& packet) { record.Add(packet); });
  return Digest(record);
}

TEST_P(OnLoss, WhoIsBackAfterTheLastVerdictStandsWhereItSays) {
  for (const TimeUs since : {620, 1250, 1910, 2530, 3150}) {
    SCOPED_TRACE(since);
    LossyMission mission;
    ASSERT_TRUE(mission.RunTo(since * kSecondUs));
    mission.Isolate("uav", true);
    ASSERT_TRUE(mission.RunTo(mission.limit_us()));
    mission.Isolate("uav", false);
    ASSERT_TRUE(mission.RunToEnd());
    mission.RunOn(10 * kSecondUs);
    mission.ExpectSound();
  }
}

TEST_P(OnLoss, NothingChangesWhereNobodyIsLost) {
  const std::string expected = UndisturbedDigest();
  for (std::uint64_t seed = 101; seed <= Cases(103, 110); ++seed) {
    SCOPED_TRACE(seed);
    LossyMission mission(Lossy(0.3, 0.1, 2950), seed);
    ASSERT_TRUE(mission.RunToEnd());
    EXPECT_EQ(mission.Count(kProcessLost), 0);
    EXPECT_EQ(Digest(mission.record()), expected);
    mission.ExpectSound();
  }
}

TEST_P(OnLoss, TheMissionGoesOnWithoutAClassAndTakesItBack) {
  for (const AgentKind kind : kAgentKinds) {
    for (const double loss : {0.0, 0.2}) {
      const std::string name(ToString(kind));
      SCOPED_TRACE(name);
      LossyMission mission(Lossy(loss, 0, 150));
      ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
      mission.Kill(name);
      ASSERT_TRUE(mission.RunTo(75 * kMinuteUs));
      mission.Start(name);
      ASSERT_TRUE(mission.RunToEnd());
      EXPECT_EQ(mission.Count(kProcessLost, name), 1);
      EXPECT_EQ(mission.Count(kProcessBack, name), 1);
      EXPECT_GT(mission.Commands(kind, 0, 45 * kMinuteUs), 0);
      EXPECT_EQ(mission.Commands(kind, 50 * kMinuteUs, 75 * kMinuteUs), 0);
      EXPECT_GT(mission.Commands(kind, 80 * kMinuteUs, kNever), 0);
      mission.ExpectSound();
    }
  }
}

// Of those it waits for nobody speaks, and what it says itself it says ever less often: no pause
// that it makes of its own accord may count as one in which it could not listen.
TEST_P(OnLoss, AWorldThatWasHeldUpMissesThoseThatAreDead) {
  for (const bool starts_again : {false, true}) {
    SCOPED_TRACE(starts_again);
    LossyMission mission({}, 1, {}, kSecondUs / 2);
    ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
    for (const char* name : {"uav", "worker", "vehicle", "scheduler"}) mission.Kill(name);
    if (starts_again) {
      mission.Kill("world");
      mission.Start("world");
    }
    mission.RunOn(kSecondUs / 5);
    mission.Stop("world", true);
    mission.RunOn(2 * kSecondUs);
    mission.Stop("world", false);
    mission.RunOn(20 * kSecondUs);
    for (const char* name : {"uav", "worker", "vehicle"}) {
      EXPECT_EQ(mission.Count(kProcessLost, name), 1) << name;
    }
  }
}

// Where nobody is left who heard the last reports of a process that is lost, a world that starts
// again asked for them for ever.
TEST_P(OnLoss, WhatNobodyHeardOfTheLostIsGivenUp) {
  for (const char* name : {"uav", "worker"}) {
    SCOPED_TRACE(name);
    LossyMission mission;
    ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
    mission.Isolate("recorder", true);
    ASSERT_TRUE(mission.RunTo(46 * kMinuteUs));
    mission.Kill(name);
    ASSERT_TRUE(mission.RunTo(48 * kMinuteUs));
    mission.Isolate("recorder", false);
    ASSERT_TRUE(mission.RunTo(50 * kMinuteUs));
    mission.Kill("world");
    mission.Start("world");
    ASSERT_TRUE(mission.RunTo(75 * kMinuteUs));
    mission.Start(name);
    EXPECT_TRUE(mission.RunToEnd());
    EXPECT_EQ(mission.Count(kStateUnknown, name), 1);
    EXPECT_EQ(mission.Count(kProcessLost, name), 1);
    EXPECT_EQ(mission.Count(kProcessBack, name), 1);
  }
}

TEST_P(OnLoss, ACutOffProcessComesBackByItself) {
  for (const char* name : {"uav", "worker", "vehicle", "scheduler"}) {
    SCOPED_TRACE(name);
    LossyMission mission;
    ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
    mission.Isolate(name, true);
    ASSERT_TRUE(mission.RunTo(75 * kMinuteUs));
    mission.Isolate(name, false);
    ASSERT_TRUE(mission.RunToEnd());
    EXPECT_EQ(mission.Count(kProcessLost, name), 1);
    EXPECT_EQ(mission.Count(kProcessBack, name), 1);
    mission.ExpectSound();
  }
}

TEST_P(OnLoss, WithoutASchedulerDecisionsAreNotInForce) {
  LossyMission mission;
  ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
  mission.Kill("scheduler");
  ASSERT_TRUE(mission.RunTo(75 * kMinuteUs));
  mission.Start("scheduler");
  ASSERT_TRUE(mission.RunToEnd());
  // At 50, 60 and 70 min, and perhaps one or two more while it starts.
  const std::set<std::int32_t>& skipped = mission.record().skipped_decisions();
  EXPECT_EQ(*skipped.begin(), 5);
  EXPECT_GE(skipped.size(), 3u);
  EXPECT_LE(skipped.size(), 5u);
  EXPECT_EQ(mission.Count(kProcessLost, "scheduler"), 1);
  EXPECT_EQ(mission.Count(kProcessBack, "scheduler"), 1);
  EXPECT_EQ(mission.record().schedules().size(), 18u - skipped.size());
  mission.ExpectSound();
  // The story of an agent says so.
  const AgentStory story = TellAgent(mission.log(), "run", AgentKind::kUav, 0, {});
  for (std::int32_t d = 0; d < 18; ++d) {
    const auto& chapter = story.chapters.at(static_cast<std::size_t>(d));
    EXPECT_EQ(chapter.in_force, !skipped.contains(d)) << d;
    EXPECT_EQ(chapter.missing, "") << d;
    if (chapter.answer.did && !chapter.in_force) {
      EXPECT_EQ(chapter.answer.did->kind, ActionKind::kUavStays) << d;
    }
  }
  EXPECT_NE(ToText(story).find("no decision was in force: the scheduler was lost"),
            std::string::npos);
}

TEST_P(OnLoss, WithoutASchedulerUavsThatAreLowGoToCharge) {
  LossyMission mission;
  ASSERT_TRUE(mission.RunTo(65 * kMinuteUs));
  mission.Kill("scheduler");
  ASSERT_TRUE(mission.RunTo(155 * kMinuteUs));
  mission.Start("scheduler");
  ASSERT_TRUE(mission.RunToEnd());
  mission.ExpectSound();
  const Scenario& scenario = mission.log().scenario;
  const std::set<std::int32_t>& skipped = mission.record().skipped_decisions();
  ASSERT_GE(skipped.size(), 8u);
  int went = 0;
  for (const std::int32_t d : skipped) {
    const auto before = SituationOf(mission.log().decisions.at(d), mission.log());
    if (d + 1 == scenario.decisions() || !before) continue;
    const auto after = SituationOf(mission.log().decisions.at(d + 1), mission.log());
    ASSERT_TRUE(after) << d;
    for (const AgentState& uav : before->uavs) {
      const auto action = OwnAction(uav, before->now_us, scenario);
      if (!action) continue;
      const auto then = std::find_if(after->uavs.begin(), after->uavs.end(),
                                     [&](const AgentState& u) { return u.id == uav.id; });
      if (then == after->uavs.end()) continue;  // offline by then
      ++went;
      EXPECT_NEAR(Distance(then->to, action->to), 0, 1e-3) << "uav:" << uav.id << " at " << d;
      EXPECT_NEAR(RangeAt(*then, after->now_us, scenario.tasks),
                  RangeAt(uav, before->now_us, scenario.tasks) - Distance(uav.to, action->to),
                  1e-3);
      const AgentStory story = TellAgent(mission.log(), "run", AgentKind::kUav, uav.id, d);
      ASSERT_EQ(story.chapters.size(), 1u);
      ASSERT_TRUE(story.chapters.front().answer.did);
      EXPECT_EQ(*story.chapters.front().answer.did, *action);
    }
  }
  EXPECT_GE(went, 2);
}

TEST_P(OnLoss, EverybodyMayBeLostForGood) {
  for (const char* name : {"uav", "worker", "vehicle", "scheduler"}) {
    SCOPED_TRACE(name);
    LossyMission mission;
    ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
    mission.Kill(name);
    ASSERT_TRUE(mission.RunToEnd());
    EXPECT_EQ(mission.Count(kProcessLost, name), 1);
    mission.ExpectSound();
  }
  LossyMission mission;
  ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
  for (const char* name : {"uav", "worker", "vehicle", "scheduler"}) mission.Kill(name);
  ASSERT_TRUE(mission.RunToEnd());
  EXPECT_EQ(mission.Count(kProcessLost), 4);
  mission.ExpectSound();
}

TEST_P(OnLoss, AQuickRestartIsNoLoss) {
  const std::string expected = UndisturbedDigest();
  for (const char* name : {"world", "uav", "worker", "vehicle", "scheduler"}) {
    SCOPED_TRACE(name);
    LossyMission mission(Lossy(0.1, 0, 150));
    ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
    mission.Kill(name);
    mission.Start(name);
    ASSERT_TRUE(mission.RunToEnd());
    EXPECT_EQ(Digest(mission.record()), expected);
    mission.ExpectSound();
  }
}

TEST_P(OnLoss, AWorldThatStartsAgainKnowsWhichDecisionIsInForce) {
  LossyMission mission;
  ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
  mission.Kill("scheduler");
  ASSERT_TRUE(mission.RunTo(55 * kMinuteUs));
  mission.Kill("world");
  mission.Start("world");
  ASSERT_TRUE(mission.RunTo(57 * kMinuteUs));
  mission.Start("scheduler");
  ASSERT_TRUE(mission.RunToEnd());
  EXPECT_EQ(mission.record().skipped_decisions(), std::set<std::int32_t>{5});
  mission.ExpectSound();
}

// Killed when that message of a decision's tick was said: by nobody, by an agent, by itself, by the
// scheduler.
TEST_P(OnLoss, AWorldThatDiesInTheTickOfADecisionChangesNothing) {
  const std::string expected = UndisturbedDigest();
  for (const std::string_view said : {channel::kClock, channel::kWorkers, channel::kWorld,
                                      channel::kRulings, channel::kSchedule}) {
    for (std::uint64_t seed = 1; seed <= Cases(2, 6); ++seed) {
      SCOPED_TRACE(fmt::format("{}, seed {}", said, seed));
      LossyMission mission(Lossy(seed % 2 == 0 ? 0.2 : 0, 0, 150), seed);
      for (const int decision : {3, 4, 9}) {
        ASSERT_TRUE(mission.RunUntilSaid(said, decision * 10 * kMinuteUs));
        mission.Kill("world");
        mission.Start("world");
      }
      ASSERT_TRUE(mission.RunToEnd());
      EXPECT_EQ(mission.Count(kProcessLost), 0);
      EXPECT_EQ(mission.record().skipped_decisions().size(), 0U);
      EXPECT_EQ(Digest(mission.record()), expected);
      mission.ExpectSound();
    }
  }
}

// A process is lost from the microsecond after its last report on; an agent of it may be meant to
// fail at that very time, a moment earlier or later.
TEST_P(OnLoss, AnOutageMayBeginWhenTheProcessIsLost) {
  for (const TimeUs beside_us : {-1, 0, 1}) {
    for (const bool outlasts : {false, true}) {
      for (const bool world_dies : {false, true}) {
        SCOPED_TRACE(fmt::format("{} us, {}, {}", beside_us,
                                 outlasts ? "outlasts it" : "is shorter",
                                 world_dies ? "the world dies" : "the world lives"));
        const TimeUs last_us = 45 * kMinuteUs - 30 * kSecondUs;
        const TimeUs until_us = (outlasts ? 100 : 60) * kMinuteUs;
        LossyMission mission(
            {}, 1, {{AgentKind::kUav, 3, last_us + 1 + beside_us, until_us, {.by = "planned"}}});
        ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
        mission.Kill("uav");
        ASSERT_TRUE(mission.RunTo(55 * kMinuteUs));
        if (world_dies) {
          mission.Kill("world");
          mission.Start("world");
        }
        ASSERT_TRUE(mission.RunTo(75 * kMinuteUs));
        mission.Start("uav");
        ASSERT_TRUE(mission.RunToEnd());
        EXPECT_EQ(mission.Count(kProcessLost, "uav"), 1);
        EXPECT_EQ(mission.Count(kProcessBack, "uav"), 1);
        std::set<std::int32_t> back;
        TimeUs planned_back_us = 0;
        for (const event_t& event : mission.record().events()) {
          if (event.kind != NumberOf(EventKind::kAgentBack)) continue;
          back.insert(event.uav_id);
          if (event.uav_id == 3) planned_back_us = event.at_us;
        }
        EXPECT_GT(back.size(), 1U);
        if (back.contains(3)) {
          EXPECT_GE(planned_back_us, outlasts ? until_us : 75 * kMinuteUs);
        }
        mission.ExpectSound();
      }
    }
  }
}

TEST_P(OnLoss, AWorldThatStartsAgainGoesOnWithoutWhoeverIsLost) {
  const std::vector<std::vector<std::string>> cases = {{"uav"},
                                                       {"worker"},
                                                       {"vehicle"},
                                                       {"scheduler"},
                                                       {"uav", "worker", "vehicle"},
                                                       {"uav", "worker", "vehicle", "scheduler"}};
  for (const auto& lost : cases) {
    for (const bool for_good : {false, true}) {
      for (const TimeUs apart_us : {0 * kMinuteUs, 1 * kMinuteUs, 10 * kMinuteUs}) {
        SCOPED_TRACE(fmt::format("{} lost {}, the world {} us later", fmt::join(lost, ", "),
                                 for_good ? "for good" : "for 30 min", apart_us));
        LossyMission mission;
        ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
        for (const std::string& name : lost) mission.Kill(name);
        ASSERT_TRUE(mission.RunTo(45 * kMinuteUs + apart_us));
        mission.Kill("world");
        mission.Start("world");
        ASSERT_TRUE(mission.RunTo(75 * kMinuteUs));
        if (!for_good) {
          for (const std::string& name : lost) mission.Start(name);
        }
        ASSERT_TRUE(mission.RunToEnd());
        for (const std::string& name : lost) {
          // Nothing in the states says that the scheduler is lost: each world finds out by itself.
          EXPECT_GE(mission.Count(kProcessLost, name), 1) << name;
          EXPECT_LE(mission.Count(kProcessLost, name), name == "scheduler" ? 2 : 1) << name;
          EXPECT_EQ(mission.Count(kProcessBack, name), for_good ? 0 : 1) << name;
        }
        for (const AgentKind kind : kAgentKinds) {
          if (lost != std::vector<std::string>{std::string(ToString(kind))}) continue;
          EXPECT_EQ(mission.Commands(kind, 50 * kMinuteUs, 75 * kMinuteUs), 0);
          EXPECT_EQ(mission.Commands(kind, 80 * kMinuteUs, kNever) > 0, !for_good);
        }
        mission.ExpectSound();
      }
    }
  }
}

TEST_P(OnLoss, LossesAtRandomBreakNoInvariant) {
  Random random(1, Stream::kTest);
  for (std::uint64_t seed = 1; seed <= Cases(6, 20); ++seed) {
    SCOPED_TRACE(seed);
    LossyMission mission(Lossy(random.Uniform() * 0.3, 0, 450), seed);
    TimeUs t = 0;
    while (true) {
      t += static_cast<TimeUs>(random.Uniform(1, 40) * kMinuteUs);
      if (t > 175 * kMinuteUs) break;
      const char* const names[] = {"uav", "worker", "vehicle", "scheduler"};
      const std::string name = names[random.Below(4)];
      const bool cut = random.Below(2) == 0;
      ASSERT_TRUE(mission.RunTo(t));
      cut ? mission.Isolate(name, true) : mission.Kill(name);
      for (int i = 0; i < 2; ++i) {
        t += static_cast<TimeUs>(random.Uniform(0, 15) * kMinuteUs);
        ASSERT_TRUE(mission.RunTo(std::min(t, 175 * kMinuteUs)));
        if (i == 0 && random.Below(2) == 0) {
          mission.Kill("world");
          mission.Start("world");
        }
      }
      cut ? mission.Isolate(name, false) : mission.Start(name);
    }
    ASSERT_TRUE(mission.RunToEnd());
    mission.ExpectSound();
    if (HasFailure()) break;
  }
}

}  // namespace
}  // namespace muster::tools
