// Every kind of fault with every target, in both modes: it runs to the mission's end, or is refused
// by a line that names both.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/check.h"
#include "model/generator.h"
#include "simulation/start_process.h"
#include "tests/cases.h"
#include "tools/record/digest.h"
#include "tools/simulate/virtual_mission.h"

namespace muster::tools {
namespace {

Scenario Small() {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.uavs = settings.workers = 3;
  settings.vehicles = 2;
  settings.tasks = 5;
  settings.charging_points = 1;
  settings.rules.limit_us = 30 * kMinuteUs;
  settings.online_min = Always(20);
  return Generate(settings, 1);
}

std::vector<std::string> Names() {
  std::vector<std::string> names = {process_name::kRecorder};
  for (const std::string& name : simulation::ProcessNames()) names.push_back(name);
  return names;
}

const std::vector<std::string> kTargets = {"world",
                                           "uav",
                                           "uav-1",
                                           "worker",
                                           "vehicle",
                                           "scheduler",
                                           "recorder",
                                           "lcm-logger",
                                           "launcher",
                                           "agents",
                                           "*",
                                           "uav:0",
                                           "vehicle:1",
                                           "worker:9",
                                           "uav|world",
                                           "world|recorder",
                                           "uav+scheduler|recorder",
                                           "uav|lcm-logger",
                                           "uav|uav"};

TEST(FaultPairs, EachRunsOrIsRefusedByName) {
  const Scenario scenario = Small();
  int ran = 0, refused = 0;
  for (const std::string_view kind : kNames<FaultKind>) {
    for (const std::string& target : kTargets) {
      for (const char* more : {"", "+5", "+2s", "=0.2", "+5=0.2", "+5=1", "+2s=1"}) {
        for (const bool goes_on : {false, true}) {
          const std::string text = fmt::format("{}:{}@10{}", kind, target, more);
          SCOPED_TRACE(text + (goes_on ? ", continue" : ", wait"));
          VirtualMission mission;
          try {
            mission.faults = {ParseFaultFlag(text, 0)};
            CheckFaultPlan(&mission.faults, Names(), scenario, goes_on);
          } catch (const InputError& error) {
            // A value or a duration that is missing or too much is refused before the pair is seen.
            const std::string why = error.what();
            if (why.find("target") != std::string::npos) {
              EXPECT_NE(why.find(kind), std::string::npos) << why;
              EXPECT_NE(why.find(target), std::string::npos) << why;
            }
            ++refused;
            continue;
          }
          mission.scenario = scenario;
          mission.policy = "mpq";
          mission.goes_on = goes_on;
          mission.lost_after_us = kSecondUs;
          const MissionResult result = RunVirtualMission(mission);
          EXPECT_EQ(result.end, MissionEnd::kComplete)
              << (result.problems.empty() ? "" : result.problems.front());
          EXPECT_TRUE(result.record.CheckComplete().complete);
          ++ran;
        }
      }
    }
  }
  EXPECT_GT(ran, 100);
  EXPECT_GT(refused, 100);
}

TEST(FaultPairs, TheRecorderIsNeitherKilledNorDamaged) {
  for (const char* text : {"process_killed:recorder@10", "process_stopped:recorder@10+2s",
                           "corruption:recorder@10=0.1"}) {
    FaultPlan plan = {ParseFaultFlag(text, 0)};
    EXPECT_THROW(CheckFaultPlan(&plan, Names(), Small(), false), InputError) << text;
  }
}

// One flipped bit in a name, a time or a number of starts must not last.
TEST(FaultPairs, MissionsWithDamagedPacketsEnd) {
  for (const char* target : {"world", "uav", "worker", "vehicle", "scheduler", "*"}) {
    for (std::uint64_t seed = 1; seed <= Cases(2, 6); ++seed) {
      VirtualMission mission;
      mission.scenario = Generate(PresetByName("Random_1"), 1);
      mission.policy = "mpq";
      mission.fault_seed = seed;
      mission.faults = {ParseFaultFlag(fmt::format("corruption:{}@10+60=0.05", target), 0)};
      const MissionResult result = RunVirtualMission(mission);
      EXPECT_EQ(result.end, MissionEnd::kComplete)
          << target << ", seed " << seed << ": "
          << (result.problems.empty() ? "" : result.problems.front());
    }
  }
}

TEST(FaultPairs, TheLogsDelayIsNobodysDeath) {
  for (const char* text : {"process_stopped:lcm-logger@10+25s", "process_killed:lcm-logger@10+25s",
                           "partition:recorder|world+uav+worker+vehicle+scheduler@10+25s"}) {
    VirtualMission mission;
    mission.scenario = Small();
    mission.policy = "mpq";
    mission.goes_on = true;
    const std::string undisturbed = UndisturbedDigest(mission);
    mission.faults = {ParseFaultFlag(text, 0)};
    std::string said;
    mission.say = [&](const std::string& line) { said += line + "\n"; };
    const MissionResult result = RunVirtualMission(mission);
    EXPECT_EQ(result.end, MissionEnd::kComplete) << text;
    EXPECT_EQ(Digest(result.record), undisturbed) << text;
    EXPECT_NE(said.find("it waits for"), std::string::npos) << text << said;
  }
}

}  // namespace
}  // namespace muster::tools
