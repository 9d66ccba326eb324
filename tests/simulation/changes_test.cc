// Missions whose agents say what has changed: outcomes are those of missions told whole.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <tuple>

#include "agents/core/agent_process.h"
#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/cases.h"
#include "tests/simulation/archivist.h"
#include "tests/simulation/audited.h"
#include "tests/simulation/crew.h"
#include "tools/record/digest.h"

namespace muster::tools {
namespace {

using testing::Archivist;
using testing::Crew;
using testing::Lossy;

const std::vector<std::string> kNames = {"world", "uav", "worker", "vehicle", "scheduler"};

Scenario Undisturbed() { return Generate(PresetByName("Random_10"), 5); }

/// With wind, costs of communication, failures and failed matches.
Scenario Disturbed() {
  Scenario scenario = Undisturbed();
  scenario.disturbances.wind = {0.1, 0.4};
  scenario.disturbances.communication_m = {100, 500};
  scenario.disturbances.match_failure = {0.05, 0.1};
  scenario.disturbances.agent_failure = {0.01, 0.05};
  return scenario;
}

/// Each process of the mission, and somebody who looks at all that is said.
class Mission {
 public:
  Mission(const Scenario& scenario, const PacketFaults& faults, std::uint64_t seed,
          std::string policy = "mpq")
      : json_(ScenarioToJson(scenario)), policy_(std::move(policy)), crew_(faults, seed) {
    for (const std::string& name : kNames) Start(name);
  }

  void Start(const std::string& name) {
    crew_.Add(testing::StartProcess(name, boots_[name]++, json_, options_, policy_, 0));
  }
  void RunUntil(TimeUs limit_us, const std::function<bool()>& done) {
    crew_.Run(
        limit_us, [&] { return ended_ || done(); }, [&](const Packet& packet) { Hear(packet); });
  }
  void RunToEnd() {
    RunUntil(crew_.now_us() + 3600 * kSecondUs, [] { return false; });
  }
  void RunToTick(std::int64_t tick) {
    RunUntil(crew_.now_us() + 3600 * kSecondUs, [&] { return tick_ >= tick; });
  }
  void Hear(const Packet& packet) {
    ++sent_;
    changes_ += IsReports(packet.channel) &&
                DecodeMessage(packet)->index() == Message(agent_changes_t()).index();
    record_.Add(packet);
    audited_.Add(packet);
    if (packet.channel != channel::kClock) return;
    const auto clock = Decode<clock_t>(packet.bytes);
    tick_ = clock->tick;
    ended_ |= clock->phase == ClockPhase::kEnded;
  }

  Crew& crew() { return crew_; }
  const RunRecord& record() const { return record_; }
  bool ended() const { return ended_; }
  int sent() const { return sent_; }
  int changes() const { return changes_; }

 private:
  std::string json_, policy_;
  world::WorldOptions options_;
  Crew crew_;
  std::map<std::string, std::int64_t> boots_;
  RunRecord record_;
  Audited audited_;
  bool ended_ = false;
  int sent_ = 0, changes_ = 0;
  std::int64_t tick_ = -1;
};

std::string WholeDigest(const Scenario& scenario, const std::string& policy = "mpq") {
  RunRecord record;
  Simulate(ScenarioToJson(scenario), policy, [&](const Packet& packet) { record.Add(packet); });
  return Digest(record);
}

TEST(Changes, OutcomeIsThatOfWholeStatesWhateverThePolicy) {
  for (const Scenario& scenario : {Undisturbed(), Disturbed()}) {
    for (const char* policy : {"mpq", "certified", "horizon", "greedy-sum"}) {
      Mission mission(scenario, {}, 1, policy);
      mission.RunToEnd();
      EXPECT_TRUE(mission.record().CheckComplete().complete);
      EXPECT_EQ(Digest(mission.record()), WholeDigest(scenario, policy)) << policy;
      EXPECT_GT(mission.changes(), 900) << policy;  // of 361 ticks and 3 processes
    }
  }
}

TEST(Changes, ProcessesThatShareAClassSayNoMoreThanOne) {
  const Scenario scenario = Undisturbed();
  const std::string json = ScenarioToJson(scenario);
  const auto n = static_cast<std::int32_t>(scenario.uavs.size());
  const auto most_whole = static_cast<std::size_t>(n - 1);
  Crew crew;
  for (const char* name : {"world", "worker", "vehicle", "scheduler"}) {
    crew.Add(testing::StartProcess(name, 0, json));
  }
  for (const auto& [name, first, last] :
       {std::tuple("uav-1", 0, n / 2 - 1), std::tuple("uav-2", n / 2, n - 1)}) {
    crew.Add(std::make_unique<agents::AgentProcess>(Identity{1, name, 0}, 0, AgentKind::kUav,
                                                    std::pair(first, last), most_whole));
  }
  RunRecord record;
  int changes = 0;
  bool ended = false;
  crew.Run(
      3600 * kSecondUs, [&] { return ended; },
      [&](const Packet& packet) {
        record.Add(packet);
        changes += packet.channel == channel::kUavChanges;
        if (packet.channel != channel::kClock) return;
        ended |= Decode<clock_t>(packet.bytes)->phase == ClockPhase::kEnded;
      });
  EXPECT_EQ(Digest(record), WholeDigest(scenario));
  EXPECT_GT(changes, 600) << "of 361 ticks and 2 processes";
}

std::vector<Packet> StepAt(Process* process, TimeUs now_us, const std::vector<Packet>& arrived) {
  std::vector<Packet> out;
  process->Step(arrived, {now_us, now_us}, &out);
  return out;
}

std::vector<std::string> ChannelsOf(const std::vector<Packet>& packets) {
  std::vector<std::string> channels;
  for (const Packet& packet : packets) channels.push_back(packet.channel);
  return channels;
}

// The world repeats its clock to all while one class is still on its way.
TEST(Changes, WhoIsStillSpeakingDoesNotBeginAnew) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.workers = 600;
  const Scenario scenario = Generate(settings, 1);
  const auto world = testing::StartProcess("world", 0, ScenarioToJson(scenario));
  const std::vector<Packet> begin = StepAt(world.get(), 0, {});
  ASSERT_EQ(ChannelsOf(begin), (std::vector<std::string>{"MUSTER_SCENARIO", "MUSTER_CLOCK"}));
  agents::AgentProcess workers({1, "worker", 0}, 1, AgentKind::kWorker, {});
  EXPECT_EQ(ChannelsOf(StepAt(&workers, 0, begin)), std::vector<std::string>{"MUSTER_WORKERS"});
  EXPECT_TRUE(StepAt(&workers, 10'000, {begin.back()}).empty());
}

TEST(Changes, TheWorldDoesNotAskAgainWhileReportsCome) {
  const std::string json = ScenarioToJson(Undisturbed());
  const auto world = testing::StartProcess("world", 0, json);
  const std::vector<Packet> begin = StepAt(world.get(), 0, {});
  const auto report_of = [&](const char* name) {
    return StepAt(testing::StartProcess(name, 0, json).get(), 0, begin);
  };
  EXPECT_TRUE(StepAt(world.get(), 1'900, report_of("uav")).empty());
  EXPECT_TRUE(StepAt(world.get(), 11'000, report_of("worker")).empty());
  EXPECT_TRUE(StepAt(world.get(), 20'000, {}).empty());
  EXPECT_FALSE(StepAt(world.get(), 21'100, {}).empty()) << "the vehicles have not heard";
}

TEST(Changes, TheWorldAsksAgainAsSoonAsReportsHaveComeOfLate) {
  const std::string json = ScenarioToJson(Undisturbed());
  const auto world = testing::StartProcess("world", 0, json);
  std::vector<std::unique_ptr<Process>> others;
  for (const char* name : {"uav", "worker", "vehicle", "scheduler"}) {
    others.push_back(testing::StartProcess(name, 0, json));
  }
  // All that is said takes 50 us. A tick: the clock, the reports, at a decision the schedule.
  TimeUs now_us = 0;
  const auto is_clock = [](const Packet& packet) { return packet.channel == channel::kClock; };
  std::vector<Packet> of_world = StepAt(world.get(), now_us, {}), of_others;
  for (int ticks = 0; ticks < 12;) {
    now_us += 50;
    std::vector<Packet> heard = of_world;
    heard.insert(heard.end(), of_others.begin(), of_others.end());
    of_others.clear();
    for (const auto& other : others) {
      for (Packet& packet : StepAt(other.get(), now_us, heard)) of_others.push_back(packet);
    }
    now_us += 50;
    of_world = StepAt(world.get(), now_us, of_others);
    ticks += std::any_of(of_world.begin(), of_world.end(), is_clock);
    ASSERT_LT(now_us, kSecondUs);
  }
  const std::vector<Packet> report = StepAt(others.front().get(), now_us + 50, of_world);
  EXPECT_TRUE(StepAt(world.get(), now_us + 100, report).empty());
  EXPECT_TRUE(StepAt(world.get(), now_us + 2'000, {}).empty());
  EXPECT_FALSE(StepAt(world.get(), now_us + 2'200, {}).empty()) << "the others have not heard";
}

TEST(Changes, OutcomeDoesNotDependOnMeetings) {
  Scenario scenario = Undisturbed();
  scenario.rules.start_on_meeting = true;
  Mission mission(scenario, {}, 1, "horizon");
  mission.RunToEnd();
  EXPECT_EQ(Digest(mission.record()), WholeDigest(scenario, "horizon"));
}

TEST(Changes, AnAgentMayMeetAsItsPartnerFails) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.uavs = 6;
  settings.workers = 7;
  settings.vehicles = 4;
  settings.tasks = 40;
  settings.rules.limit_us = 60 * kMinuteUs;
  settings.rules.interval_us = 5 * kMinuteUs;
  settings.rules.start_on_meeting = true;
  settings.disturbances.agent_failure = {0.05, 0.2};
  for (const std::uint64_t seed : {15U, 23U}) {  // where it happens
    const Scenario scenario = Generate(settings, seed);
    const std::string expected = WholeDigest(scenario, "horizon");
    // Whoever is killed as it happens knows of it afterwards.
    for (const char* victim : {"world", "uav", "worker", "vehicle", "scheduler"}) {
      for (const std::int64_t tick : {50, 51, 52, 90, 91, 92}) {
        SCOPED_TRACE(fmt::format("seed {}: {} killed at tick {}", seed, victim, tick));
        Mission mission(scenario, {}, 1, "horizon");
        mission.RunToTick(tick);
        mission.crew().Kill(victim);
        mission.Start(victim);
        mission.RunToEnd();
        EXPECT_TRUE(mission.ended());
        EXPECT_EQ(Digest(mission.record()), expected);
      }
    }
  }
}

TEST(Changes, OutcomeDoesNotDependOnLossDuplicationOrOrder) {
  const std::string expected = WholeDigest(Disturbed());
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Mission mission(Disturbed(), Lossy(0.3, 0.1, 3000), seed);
    mission.RunToEnd();
    EXPECT_TRUE(mission.ended()) << "seed " << seed;
    EXPECT_EQ(Digest(mission.record()), expected) << "seed " << seed;
  }
}

TEST(Changes, AnyOneProcessMayBeKilledAtAnyTime) {
  const std::string expected = WholeDigest(Undisturbed());
  const PacketFaults faults = Lossy(0.1, 0, 150);
  Mission undisturbed(Undisturbed(), faults, 1);
  undisturbed.RunToEnd();
  Random random(1, Stream::kTest);
  for (const char* victim : {"world", "uav", "worker", "vehicle", "scheduler"}) {
    for (std::uint64_t i = 0; i < Cases(4, 12); ++i) {
      const auto at =
          static_cast<int>(random.Below(static_cast<std::uint32_t>(undisturbed.sent())));
      SCOPED_TRACE(fmt::format("{} killed after packet {}", victim, at));
      Mission mission(Undisturbed(), faults, 1);
      mission.RunUntil(3600 * kSecondUs, [&] { return mission.sent() >= at; });
      mission.crew().Kill(victim);
      mission.Start(victim);
      mission.RunToEnd();
      ASSERT_TRUE(mission.ended());
      ASSERT_EQ(Digest(mission.record()), expected);
    }
  }
}

TEST(Changes, AnyNumberOfProcessesMayBeKilledAtOnceWhereSomebodyListens) {
  const Scenario scenario = Undisturbed();
  const std::string expected = WholeDigest(scenario);
  Random random(2, Stream::kTest);
  for (std::uint64_t i = 0; i < Cases(12, 40); ++i) {
    std::vector<std::string> victims = kNames;
    random.Shuffle(victims);
    victims.resize(2 + random.Below(4));
    const auto tick = static_cast<std::int64_t>(random.Below(360));
    SCOPED_TRACE(fmt::format("{} killed at tick {}", fmt::join(victims, ", "), tick));
    Mission mission(scenario, Lossy(0, 0, 150), 1);
    mission.crew().Add(std::make_unique<Archivist>(scenario, false), PacketFaults{});
    mission.RunToTick(tick);
    for (const std::string& victim : victims) mission.crew().Kill(victim);
    for (const std::string& victim : victims) mission.Start(victim);
    mission.RunToEnd();
    ASSERT_TRUE(mission.ended());
    ASSERT_EQ(Digest(mission.record()), expected);
  }
}

}  // namespace
}  // namespace muster::tools
