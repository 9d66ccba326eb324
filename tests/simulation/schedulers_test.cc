// Missions with several schedulers, in virtual time: some die, some decide otherwise.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/random.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/scheduler/odd_policies.h"
#include "tests/simulation/archivist.h"
#include "tests/simulation/crew.h"
#include "tests/tools/explain/mission_log.h"
#include "tools/audit/auditor.h"
#include "tools/explain/redecide.h"
#include "tools/record/digest.h"

namespace muster::tools {
namespace {

using scheduler::testing::Lie;
using scheduler::testing::LyingPolicy;
using testing::Crew;
using testing::Lossy;

constexpr const char* kPolicy = "mpq";

Scenario ReplicatedScenario(bool has_air = false) {
  GeneratorSettings settings = PresetByName("Random_10");
  settings.rules.limit_us = 90 * kMinuteUs;
  Scenario scenario = Generate(settings, 5);
  if (has_air) UseAir({}, &scenario);
  return scenario;
}

std::string DigestWithOne(const Scenario& scenario) {
  RunRecord record;
  Simulate(ScenarioToJson(scenario), kPolicy, [&](const Packet& packet) { record.Add(packet); });
  return Digest(record);
}

/// World, agents and so many schedulers over a virtual network.
class ReplicatedMission {
 public:
  explicit ReplicatedMission(int schedulers, Scenario scenario = ReplicatedScenario(),
                             const PacketFaults& faults = {}, std::uint64_t seed = 1,
                             bool goes_on = false)
      : scenario_(std::move(scenario)), json_(ScenarioToJson(scenario_)), network_(faults, seed) {
    options_.schedulers = schedulers;
    options_.goes_on = goes_on;
    options_.lost_after_us = kSecondUs;
    for (const std::string& name : simulation::ProcessNames(schedulers)) Start(name);
    network_.Add(std::make_unique<testing::Archivist>(scenario_, goes_on), PacketFaults());
  }

  void Start(const std::string& name) {
    network_.Add(testing::StartProcess(name, boots_[name]++, json_, options_, kPolicy));
  }
  /// In the place of that scheduler one that lies.
  void Replace(const std::string& name, Lie lie) {
    network_.Add(std::make_unique<scheduler::SchedulerProcess>(
        Identity{1, name, boots_[name]++}, 0, kPolicy, std::make_unique<LyingPolicy>(kPolicy, lie),
        [] { return TimeUs{0}; }));
  }
  void Kill(const std::string& name) { network_.Kill(name); }
  void Stop(const std::string& name, bool stopped) { network_.Stop(name, stopped); }

  /// Until that mission time, or the end.
  bool RunTo(TimeUs mission_us) {
    return network_.Run(
        7200 * kSecondUs, [&] { return ended_ || now_us_ >= mission_us; },
        [&](const Packet& packet) { Observe(packet); });
  }
  bool RunToEnd() { return RunTo(kNever) && ended_; }
  bool ended() const { return ended_; }

  std::string digest() const { return Digest(record_); }
  /// The details of events that schedulers differ.
  std::vector<std::string> Disputes() const {
    std::vector<std::string> disputes;
    for (const event_t& event : record_.events()) {
      if (event.kind == EventKind::kDecisionsDiffer) disputes.push_back(event.detail);
    }
    return disputes;
  }
  /// Network time from a decision's clock to the decision, the longest of all.
  TimeUs longest_us() const { return longest_us_; }
  std::size_t decisions() const { return record_.schedules().size(); }

  /// The audit finds nothing, and every decision made again is the same.
  void ExpectSound(const std::set<std::int32_t>& but = {}) {
    for (const audit::Violation& violation : auditor_.Finish()) {
      ADD_FAILURE() << violation.at_us << " us: " << violation.invariant << ": " << violation.text;
    }
    for (const Divergence& divergence : DivergencesOf(Redecide(Logged(packets_), ""))) {
      if (but.contains(divergence.decision)) continue;
      ADD_FAILURE() << "decision " << divergence.decision << ": " << divergence.what;
    }
  }
  const std::vector<Packet>& packets() const { return packets_; }

 private:
  void Observe(const Packet& packet) {
    record_.Add(packet);
    auditor_.Add(packet);
    packets_.push_back(packet);
    if (packet.channel == channel::kSchedule && asked_us_ >= 0) {
      longest_us_ = std::max(longest_us_, network_.now_us() - asked_us_);
      asked_us_ = -1;
    }
    if (packet.channel != channel::kClock) return;
    const auto clock = Decode<clock_t>(packet.bytes);
    if (clock->tick_us > now_us_ && clock->decision >= 0) asked_us_ = network_.now_us();
    now_us_ = std::max(now_us_, clock->tick_us);
    ended_ |= clock->phase == 2;
  }

  Scenario scenario_;
  std::string json_;
  world::WorldOptions options_;
  Crew network_;
  std::map<std::string, std::int64_t> boots_;
  RunRecord record_;
  audit::Auditor auditor_;
  std::vector<Packet> packets_;
  TimeUs now_us_ = -1, asked_us_ = -1, longest_us_ = 0;
  bool ended_ = false;
};

TEST(SeveralSchedulers, SeveralDecideWhatOneDecides) {
  for (const bool has_air : {false, true}) {
    const Scenario scenario = ReplicatedScenario(has_air);
    const std::string expected = DigestWithOne(scenario);
    for (const int n : {2, 3, 9}) {
      ReplicatedMission mission(n, scenario);
      ASSERT_TRUE(mission.RunToEnd()) << n;
      EXPECT_EQ(mission.digest(), expected) << n;
      EXPECT_EQ(mission.Disputes(), std::vector<std::string>());
      mission.ExpectSound();
    }
  }
}

TEST(SeveralSchedulers, LossChangesNothing) {
  const Scenario scenario = ReplicatedScenario(true);
  const std::string expected = DigestWithOne(scenario);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ReplicatedMission mission(3, scenario, Lossy(0.3, 0.1, 5000), seed);
    ASSERT_TRUE(mission.RunToEnd()) << seed;
    EXPECT_EQ(mission.digest(), expected) << seed;
    EXPECT_EQ(mission.Disputes(), std::vector<std::string>()) << seed;
    mission.ExpectSound();
  }
}

TEST(SeveralSchedulers, KilledInTurnAHundredTimesNobodyMissesThem) {
  const Scenario scenario = ReplicatedScenario();
  const std::string expected = DigestWithOne(scenario);
  int kills = 0;
  for (std::uint64_t seed = 1; kills < 100; ++seed) {
    Random random(seed, Stream::kTest);
    ReplicatedMission mission(3, scenario, {}, seed);
    TimeUs t = 0;
    while (!mission.ended()) {
      t += random.Below(8 * 60) * kSecondUs;
      ASSERT_TRUE(mission.RunTo(t)) << seed;
      const std::string name = fmt::format("scheduler-{}", 1 + random.Below(3));
      mission.Kill(name);
      ++kills;
      t += random.Below(8 * 60) * kSecondUs;
      ASSERT_TRUE(mission.RunTo(t)) << seed;
      mission.Start(name);
    }
    EXPECT_EQ(mission.digest(), expected) << seed;
    EXPECT_LT(mission.longest_us(), 20'000) << seed << ": two of three are enough, at once";
    EXPECT_EQ(mission.Disputes(), std::vector<std::string>()) << seed;
    mission.ExpectSound();
  }
}

TEST(SeveralSchedulers, TheLastOneIsEnoughAndWaitsOnceForTheOthers) {
  const Scenario scenario = ReplicatedScenario();
  ReplicatedMission mission(3, scenario);
  ASSERT_TRUE(mission.RunTo(15 * kMinuteUs));
  mission.Kill("scheduler-1");
  mission.Kill("scheduler-3");
  ASSERT_TRUE(mission.RunToEnd());
  EXPECT_EQ(mission.digest(), DigestWithOne(scenario));
  EXPECT_GE(mission.longest_us(), world::Ballot::kGraceUs);
  EXPECT_LT(mission.longest_us(), world::Ballot::kGraceUs + 50'000);
  mission.ExpectSound();
}

TEST(SeveralSchedulers, WhenAllAreGoneTheMissionWaitsOrGoesOn) {
  const Scenario scenario = ReplicatedScenario();
  for (const bool goes_on : {false, true}) {
    ReplicatedMission mission(2, scenario, {}, 1, goes_on);
    ASSERT_TRUE(mission.RunTo(15 * kMinuteUs));
    mission.Kill("scheduler-1");
    mission.Kill("scheduler-2");
    if (goes_on) {
      ASSERT_TRUE(mission.RunTo(45 * kMinuteUs));
    } else {
      EXPECT_FALSE(mission.RunTo(45 * kMinuteUs)) << "it has waited for two hours";
    }
    mission.Start("scheduler-2");
    if (!goes_on) continue;
    ASSERT_TRUE(mission.RunToEnd());
    EXPECT_LT(mission.decisions(), static_cast<std::size_t>(scenario.decisions()));
    mission.ExpectSound();
  }
}

TEST(SeveralSchedulers, TheWorldStartsAgainBetweenProposalAndDecision) {
  const Scenario scenario = ReplicatedScenario(true);
  const std::string expected = DigestWithOne(scenario);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    ReplicatedMission mission(3, scenario, Lossy(0.2, 0.1, 3000), seed);
    // At a decision's tick, with one scheduler or more on their way to it.
    for (const TimeUs t : {10 * kMinuteUs, 20 * kMinuteUs, 50 * kMinuteUs}) {
      ASSERT_TRUE(mission.RunTo(t));
      mission.Kill("world");
      mission.Start("world");
    }
    ASSERT_TRUE(mission.RunToEnd()) << seed;
    EXPECT_EQ(mission.digest(), expected) << seed;
    mission.ExpectSound();
  }
}

TEST(SeveralSchedulers, OneOfThreeThatLiesIsOverruledAndNamed) {
  const Scenario scenario = ReplicatedScenario(true);
  const std::string expected = DigestWithOne(scenario);
  for (const Lie lie : {Lie::kOneLess, Lie::kTwice}) {
    for (const char* liar : {"scheduler-1", "scheduler-2", "scheduler-3"}) {
      ReplicatedMission mission(3, scenario);
      mission.Replace(liar, lie);
      ASSERT_TRUE(mission.RunToEnd());
      EXPECT_EQ(mission.digest(), expected) << liar;
      const std::vector<std::string> disputes = mission.Disputes();
      EXPECT_GT(disputes.size(), mission.decisions() / 2);
      for (const std::string& dispute : disputes) {
        EXPECT_NE(dispute.find(std::string(liar) + " ("), std::string::npos) << dispute;
        const bool early = dispute.find(" is taken by majority, against ") != std::string::npos;
        const bool late = dispute.find(" comes later and differs") != std::string::npos;
        EXPECT_TRUE(early || late) << dispute;
      }
      mission.ExpectSound();
    }
  }
}

TEST(SeveralSchedulers, OfTwoTheCheckerFindsTheLiarElseTheHigherWeightCounts) {
  const Scenario scenario = ReplicatedScenario();
  const std::string expected = DigestWithOne(scenario);
  for (const Lie lie : {Lie::kOneLess, Lie::kTwice}) {
    for (const char* liar : {"scheduler-1", "scheduler-2"}) {
      ReplicatedMission mission(2, scenario);
      mission.Replace(liar, lie);
      ASSERT_TRUE(mission.RunToEnd());
      EXPECT_EQ(mission.digest(), expected) << liar;
      const std::vector<std::string> disputes = mission.Disputes();
      ASSERT_FALSE(disputes.empty());
      const char* how = lie == Lie::kTwice ? " is taken as it alone passes the checker, "
                                           : " is taken by weight, ";
      for (const std::string& dispute : disputes) {
        EXPECT_NE(dispute.find(how), std::string::npos) << dispute;
      }
      mission.ExpectSound();
    }
  }
}

/// What the audit says first of a log in which each message of that channel is changed.
template <class Message>
std::string FirstViolation(const std::vector<Packet>& packets, std::string_view channel,
                           const std::function<bool(Message&)>& keep) {
  audit::Auditor auditor;
  for (const Packet& packet : packets) {
    if (packet.channel != channel) {
      auditor.Add(packet);
      continue;
    }
    Message message = *Decode<Message>(packet.bytes);
    if (keep(message)) auditor.Add({packet.channel, Encode(message)});
  }
  for (const audit::Violation& violation : auditor.Finish()) {
    if (violation.invariant == "proposals") return violation.text;
  }
  return "";
}

TEST(SeveralSchedulers, TheAuditComparesProposalsAndDecision) {
  ReplicatedMission mission(3);
  mission.Replace("scheduler-2", Lie::kOneLess);
  ASSERT_TRUE(mission.RunToEnd());
  mission.ExpectSound();
  const auto proposals = [&](const std::function<bool(proposal_t&)>& keep) {
    return FirstViolation<proposal_t>(mission.packets(), channel::kProposal, keep);
  };
  EXPECT_EQ(proposals([](proposal_t& p) {
              if (p.schedule.decision == 2) p.schedule.weight += 1;
              return true;
            }),
            "decision 2 is what no scheduler proposed");
  EXPECT_EQ(proposals([](proposal_t& p) {
              return p.schedule.decision != 2 || p.header.sender != "scheduler-2";
            }),
            "decision 2 is said to be disputed, but all agree");
  EXPECT_EQ(FirstViolation<event_t>(mission.packets(), channel::kEvent,
                                    [](event_t& event) {
                                      return event.kind != EventKind::kDecisionsDiffer ||
                                             !event.detail.starts_with("decision 2: ");
                                    }),
            "scheduler-2 differs on decision 2, and no event says so");
  ReplicatedMission two(2);
  two.Replace("scheduler-2", Lie::kOneLess);
  ASSERT_TRUE(two.RunToEnd());
  const std::string text =
      FirstViolation<event_t>(two.packets(), channel::kEvent, [&](event_t& event) {
        const std::size_t at = event.detail.find("by weight");
        if (at != std::string::npos) event.detail.replace(at, 9, "by majority");
        return true;
      });
  EXPECT_NE(text.find("is taken by a majority of 1 of 2"), std::string::npos) << text;
}

}  // namespace
}  // namespace muster::tools
