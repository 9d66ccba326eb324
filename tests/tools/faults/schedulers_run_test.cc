// Missions of real processes with several schedulers, and with one that takes its time.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "tests/tools/faults/mission_test.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

class SchedulersRunTest : public MissionTest {
 protected:
  Json Run(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"run", scenario_, "--quiet", "--out",
                                          folder_.File("run")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Muster muster(folder_, "run", arguments);
    EXPECT_EQ(muster.Wait(), 0) << muster.output();
    said_ = muster.output();
    return Report();
  }
  /// How many heartbeats in the log have that state.
  int Heartbeats(ProcessState state) const {
    EventLogReader reader(folder_.File("run") + "/mission.lcm", EventLogReader::Tail::kFinal);
    int n = 0;
    while (const auto event = reader.Next()) {
      if (event->packet.channel != channel::kProcess) continue;
      const auto status = DecodeValid<process_status_t>(event->packet.bytes);
      n += status && status->state == state;
    }
    return n;
  }
  std::string said_;
};

TEST_F(SchedulersRunTest, EachOfThreeMayDie) {
  const Json report = Run(
      InTime({"--processes", "scheduler=3", "--fault", "process_killed:scheduler-1@30", "--fault",
              "process_killed:scheduler-2@60", "--fault", "process_killed:scheduler-3@90"}));
  EXPECT_EQ(report["digest"], undisturbed_);
  EXPECT_EQ(report["events"]["process_lost"], 3) << said_;
  EXPECT_FALSE(report["events"].contains("decisions_differ")) << said_;
}

TEST_F(SchedulersRunTest, WithoutASchedulerEachProcessOfAgentsMayDie) {
  const Json report =
      Run(InTime({"--policy", "neighbours", "--reach", "8", "--processes", "worker=2", "--fault",
                  "process_killed:uav@30", "--fault", "process_killed:worker-2@60", "--fault",
                  "process_killed:world@75", "--fault", "process_killed:vehicle@90", "--fault",
                  "loss:scheduler-1@100+20=0.4"}));
  EXPECT_EQ(report["digest"], Undisturbed("neighbours:reach=8"));
  EXPECT_EQ(report["events"]["process_lost"], 4) << said_;
  EXPECT_FALSE(report["events"].contains("decisions_differ")) << said_;
  EXPECT_FALSE(std::filesystem::exists(folder_.File("run") + "/scheduler.stderr"));
  EXPECT_TRUE(std::filesystem::exists(folder_.File("run") + "/worker-2.stderr"));
}

TEST_F(SchedulersRunTest, ASchedulerThatIsPartOfAProcessIsKilledWithIt) {
  Muster muster(folder_, "run",
                {"run", scenario_, "--quiet", "--out", folder_.File("run"), "--policy",
                 "neighbours", "--fault", "process_killed:scheduler-1@30"});
  EXPECT_EQ(muster.Wait(), 2);
  EXPECT_NE(muster.output().find("--fault: found process_killed scheduler-1, expected uav: the "
                                 "target runs inside that process"),
            std::string::npos)
      << muster.output();
  EXPECT_FALSE(std::filesystem::exists(folder_.File("run")));
}

TEST_F(SchedulersRunTest, OneThatLiesIsOverruledAndNamed) {
  const Json report = Run({"--processes", "scheduler=3", "--policy", "certified", "--program",
                           std::string("scheduler-2=") + MUSTER_ODD_SCHEDULER});
  EXPECT_EQ(report["digest"], Undisturbed("certified"));
  EXPECT_GT(report["events"]["decisions_differ"], 5) << said_;
}

TEST_F(SchedulersRunTest, OneThatDecidesForLongIsNotTakenForLost) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.rules.limit_us = 25 * kMinuteUs;
  std::ofstream(scenario_) << ScenarioToJson(Generate(settings, 1));
  const Json report =
      Run({"--policy", "mpq", "--program", std::string("scheduler=") + MUSTER_ODD_SCHEDULER,
           "--on-loss", "continue", "--lost-after", "0.5"});
  EXPECT_EQ(report["digest"], Undisturbed("mpq"));
  EXPECT_EQ(report["events"]["process_lost"], 0) << said_;
  EXPECT_GT(Heartbeats(ProcessState::kDeciding), 10);
}

TEST_F(SchedulersRunTest, OneThatDiesWhileItDecidesIsLost) {
  const Json report =
      Run({"--policy", "mpq", "--program", std::string("scheduler=") + MUSTER_ODD_SCHEDULER,
           "--on-loss", "continue", "--lost-after", "0.5", "--fault",
           "process_killed:scheduler@20+30", "--limit", "60"});
  EXPECT_GT(report["events"]["process_lost"], 0) << said_;
}

}  // namespace
}  // namespace muster::tools
