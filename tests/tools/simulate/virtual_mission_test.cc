#include "tools/simulate/virtual_mission.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "model/generator.h"
#include "tests/simulation/audited.h"
#include "tools/record/digest.h"
#include "tools/record/summary.h"

namespace muster::tools {
namespace {

/// As event_t counts them.
constexpr int kProcessLost = 11;
constexpr int kProcessBack = 12;
constexpr int kFaultApplied = 13;
constexpr int kFaultEnded = 14;

VirtualMission MissionWith(const std::vector<std::string>& faults) {
  VirtualMission mission;
  mission.scenario = Generate(PresetByName("Random_10"), 5);
  mission.policy = "mpq";
  for (const std::string& text : faults) {
    mission.faults.push_back(ParseFaultFlag(text, mission.faults.size()));
  }
  return mission;
}

int Count(const RunRecord& record, int kind) {
  return static_cast<int>(std::count_if(record.events().begin(), record.events().end(),
                                        [&](const event_t& event) { return event.kind == kind; }));
}

/// It ended, its log is complete, each fault was seen, and the audit passes.
MissionResult RunSoundly(VirtualMission mission) {
  Audited audited;
  mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t) {
    audited.Add(*event.packet);
  };
  MissionResult result = RunVirtualMission(mission);
  EXPECT_EQ(ExitCodeOf(result), 0);
  for (const std::string& problem : result.problems) ADD_FAILURE() << problem;
  for (const std::string& line : result.without_effect) ADD_FAILURE() << line;
  EXPECT_TRUE(result.record.CheckComplete().complete);
  return result;
}

using LogLine = std::tuple<std::int64_t, TimeUs, std::string, std::vector<std::uint8_t>>;
std::vector<LogLine> LogOf(VirtualMission mission) {
  std::vector<LogLine> log;
  mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t start) {
    log.emplace_back(start, event.received_us, event.packet->channel, event.packet->bytes);
  };
  RunVirtualMission(mission);
  return log;
}

TEST(VirtualMission, WithoutFaultsIsTheFastOne) {
  const VirtualMission mission = MissionWith({});
  EXPECT_EQ(Digest(RunSoundly(mission).record), UndisturbedDigest(mission));
}

TEST(VirtualMission, ItsLogIsAFunctionOfItsSeeds) {
  VirtualMission mission = MissionWith({"loss:*@10=0.2", "process_killed:world@40",
                                        "process_killed:lcm-logger@60", "foreign:*@80+5"});
  const std::vector<LogLine> log = LogOf(mission);
  EXPECT_GT(log.size(), 2000u);
  EXPECT_EQ(std::get<0>(log.back()), 1) << "the second start of the logger";
  EXPECT_TRUE(log == LogOf(mission));
  mission.fault_seed = 2;
  EXPECT_FALSE(log == LogOf(mission));
}

TEST(VirtualMission, FaultsOnPacketsAreSeenAndChangeNothing) {
  for (const char* fault :
       {"loss:*@10+60=0.3", "duplication:uav@10+60=0.3", "delay:*@10+60=3",
        "reordering:world@10+60=0.3", "partition:uav+worker|world@30+0.3s", "foreign:*@10+60"}) {
    SCOPED_TRACE(fault);
    const VirtualMission mission = MissionWith({fault});
    const RunRecord record = RunSoundly(mission).record;
    EXPECT_EQ(Digest(record), UndisturbedDigest(mission));
    EXPECT_GT(Count(record, kFaultApplied), 0);
    EXPECT_EQ(Count(record, kFaultApplied), Count(record, kFaultEnded));
  }
}

TEST(VirtualMission, CorruptionIsSeen) {
  // A flipped bit inside a number may pass for a true message, so decisions may change.
  const MissionResult result = RunVirtualMission(MissionWith({"corruption:uav@10+20=0.01"}));
  EXPECT_TRUE(result.without_effect.empty());
  EXPECT_EQ(Count(result.record, kFaultEnded), 1);
}

TEST(VirtualMission, WhoeverIsKilledStartsAgain) {
  for (const char* name : {"world", "uav", "worker", "vehicle", "scheduler", "lcm-logger"}) {
    for (const char* duration : {"", "+0.4s"}) {
      SCOPED_TRACE(std::string(name) + duration);
      const VirtualMission mission =
          MissionWith({std::string("process_killed:") + name + "@45" + duration});
      const RunRecord record = RunSoundly(mission).record;
      EXPECT_EQ(Digest(record), UndisturbedDigest(mission));
      EXPECT_EQ(Count(record, kProcessLost), 1);
      EXPECT_EQ(Count(record, kProcessBack), 1);
    }
  }
}

TEST(VirtualMission, WhoeverIsStoppedNeitherStepsNorHearsUntilItGoesOn) {
  for (const char* name : {"world", "uav", "worker", "vehicle", "scheduler", "lcm-logger"}) {
    SCOPED_TRACE(name);
    const VirtualMission mission = MissionWith({std::string("process_stopped:") + name + "@45+2s"});
    const RunRecord record = RunSoundly(mission).record;
    EXPECT_EQ(Digest(record), UndisturbedDigest(mission));
    EXPECT_GT(record.wall_s(), 2.0) << "the mission waits for it";
  }
}

TEST(VirtualMission, AFullDiskKillsTheLoggerAndLosesNothing) {
  const VirtualMission mission = MissionWith({"disk_full:lcm-logger@60+0.5s"});
  const RunRecord record = RunSoundly(mission).record;
  EXPECT_EQ(Digest(record), UndisturbedDigest(mission));
  EXPECT_EQ(Count(record, kProcessLost), 1);
  EXPECT_GT(std::get<0>(LogOf(mission).back()), 0);
}

TEST(VirtualMission, AllMayDieAtOnce) {
  const VirtualMission mission = MissionWith(
      {"process_killed:world@45", "process_killed:uav@45", "process_killed:worker@45",
       "process_killed:vehicle@45", "process_killed:scheduler@45", "process_killed:lcm-logger@45"});
  const RunRecord record = RunSoundly(mission).record;
  EXPECT_EQ(Digest(record), UndisturbedDigest(mission));
  EXPECT_EQ(Count(record, kProcessBack), 6);
}

TEST(VirtualMission, FailingAgentsAreThoseOfTheFastOne) {
  const VirtualMission mission = MissionWith(
      {"agent_silent:uav:3@20+60", "agent_fails:worker:5@30", "process_killed:world@50"});
  const RunRecord record = RunSoundly(mission).record;
  EXPECT_EQ(Digest(record), UndisturbedDigest(mission));
  EXPECT_NE(Digest(record), UndisturbedDigest(MissionWith({})));
}

TEST(VirtualMission, GoesOnWithoutWhoeverIsLost) {
  for (const std::string fault :
       {"process_killed:uav@60+30", "process_stopped:worker@60+30", "partition:vehicle|world@60+30",
        "process_killed:scheduler@60+30"}) {
    SCOPED_TRACE(fault);
    VirtualMission mission = MissionWith({fault});
    mission.goes_on = true;
    mission.lost_after_us = kSecondUs / 2;
    std::string said;
    mission.say = [&](const std::string& line) { said += line + "\n"; };
    const RunRecord record = RunSoundly(mission).record;
    EXPECT_NE(Digest(record), UndisturbedDigest(mission));
    EXPECT_GT(Count(record, kProcessLost), 0);
    EXPECT_GT(Count(record, kProcessBack), 0);
    const std::string name =
        fault.substr(fault.find(':') + 1, fault.find_first_of("@|") - fault.find(':') - 1);
    EXPECT_NE(said.find(name + " is lost at 60.0 min: the mission goes on without it\n"),
              std::string::npos)
        << said;
    EXPECT_NE(said.find(name + " takes part again at "), std::string::npos) << said;
    EXPECT_EQ(Summary(record).find(" agents failed, ") == std::string::npos, name == "scheduler");
    EXPECT_NE(Summary(record).find("without " + name + " for a time\n"), std::string::npos)
        << Summary(record);
  }
}

TEST(VirtualMission, EndsWhenAskedTo) {
  VirtualMission mission = MissionWith({"process_stopped:uav@60+1s"});
  int asked = 0;
  mission.stops_asked = [&] { return asked++ > 1000 ? 1 : 0; };
  EXPECT_EQ(RunVirtualMission(mission).end, MissionEnd::kInterrupted);
}

TEST(VirtualMission, AFaultThatHitsNothingIsNamed) {
  const MissionResult result =
      RunVirtualMission(MissionWith({"reordering:scheduler@60+1=0.000001"}));
  ASSERT_EQ(result.without_effect.size(), 1u);
  EXPECT_EQ(ExitCodeOf(result), 4);
}

}  // namespace
}  // namespace muster::tools
