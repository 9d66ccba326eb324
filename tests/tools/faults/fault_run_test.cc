// Whole missions by the real `muster run` under a fault plan.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "model/generator.h"
#include "model/scenario_json.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/faults/mission_test.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

class FaultRunTest : public MissionTest {
 protected:
  /// The report of a mission with these faults.
  Json Run(const std::vector<std::string>& faults, const std::string& name = "run",
           const std::vector<std::string>& more = InTime()) {
    std::vector<std::string> arguments = {"run", scenario_, "--quiet", "--out", folder_.File(name)};
    for (const std::string& fault : faults) arguments.insert(arguments.end(), {"--fault", fault});
    arguments.insert(arguments.end(), more.begin(), more.end());
    Muster muster(folder_, name, arguments);
    EXPECT_EQ(muster.Wait(), 0) << muster.output();
    Json report = Report(name);
    for (const Json& fault : report["faults"]) {
      EXPECT_FALSE(fault["applied_s"].is_null()) << fault << muster.output();
    }
    EXPECT_EQ(report["faults"].size(), faults.size());
    EXPECT_TRUE(report["log"]["complete"].get<bool>()) << report["log"];
    return report;
  }
  void ExpectABadNetworkChangesNothing(const std::string& logger, int processes) {
    const Json report =
        Run({"loss:*@0=0.3", "duplication:*@0=0.1", "reordering:*@0=0.2", "delay:worker@60+10=3"},
            logger, InTime({"--logger", logger}));
    EXPECT_EQ(report["digest"], undisturbed_);
    // All processes' worth of three faults, and one.
    EXPECT_EQ(report["events"]["fault_applied"], 3 * processes + 1);
    EXPECT_EQ(report["events"]["fault_ended"], 3 * processes + 1);
    for (const Json& fault : report["faults"]) EXPECT_GT(fault["packets"], 0) << fault;
  }
};

TEST_F(FaultRunTest, LossDuplicationReorderingAndDelayChangeNoDecision) {
  ExpectABadNetworkChangesNothing("muster", 7);
}

using LongFaultRunTest = FaultRunTest;
TEST_F(LongFaultRunTest, LossDuplicationReorderingAndDelayChangeNoDecisionWithLcmLogger) {
  ExpectABadNetworkChangesNothing("lcm", 6);  // the launcher is the recorder
}

TEST_F(FaultRunTest, ForeignPacketsAreCountedAndChangeNothing) {
  const Json report = Run({"foreign:*@10+100"});
  EXPECT_EQ(report["digest"], undisturbed_);
  EXPECT_GT(report["faults"][0]["packets"], 0);
  for (const Json& process : report["processes"]) EXPECT_GT(process["rejected"], 0) << process;
}

TEST_F(FaultRunTest, AFaultThatHitsNothingFailsTheRun) {
  // Too small a share to hit one of the packets of that minute.
  Muster muster(folder_, "run",
                {"run", scenario_, "--quiet", "--out", folder_.File("run"), "--fault",
                 "reordering:scheduler@60+1=0.000001"});
  EXPECT_EQ(muster.Wait(), 4) << muster.output();
  EXPECT_NE(muster.output().find("fault flag0 (reordering scheduler): it hit no packet"),
            std::string::npos)
      << muster.output();
}

TEST_F(FaultRunTest, KilledStoppedAndCutOffProcessesChangeNoDecision) {
  for (const std::string logger : {"muster", "lcm"}) {
    const Json report =
        Run({"process_killed:uav@10", "process_killed:world@30", "process_stopped:vehicle@50+0.3s",
             "partition:uav+worker|world@70+0.3s", "process_killed:scheduler@90+0.5s",
             "process_killed:lcm-logger@110"},
            logger, InTime({"--logger", logger}));
    EXPECT_EQ(report["digest"], undisturbed_);
    EXPECT_EQ(report["events"]["process_lost"], 4);
    EXPECT_EQ(report["events"]["process_back"], 4);
  }
}

TEST_F(FaultRunTest, AFullDiskHoldsTheMissionAndLosesNothing) {
  for (const std::string logger : {"muster", "lcm"}) {
    const Json report = Run({"disk_full:lcm-logger@60+0.5s"}, logger, InTime({"--logger", logger}));
    EXPECT_EQ(report["digest"], undisturbed_);
    EXPECT_TRUE(std::filesystem::exists(folder_.File(logger) + "/mission.lcm.1"));
  }
}

TEST_F(FaultRunTest, AnAgentGoesSilentComesBackAndARestartedWorldKnows) {
  const Json report = Run({"agent_silent:uav:3@20+60", "agent_fails:worker:5@30"}, "one");
  EXPECT_EQ(report["events"]["agent_failed"], 2);
  EXPECT_EQ(report["events"]["agent_back"], 1);
  EXPECT_NE(report["digest"], undisturbed_);
  EXPECT_EQ(report["faults"][0]["applied_s"], 20 * 60);
  EXPECT_EQ(report["faults"][0]["ended_s"], 80 * 60);
  const Json again = Run({"agent_silent:uav:3@20+60", "agent_fails:worker:5@30",
                          "process_killed:world@50", "process_killed:world@100"},
                         "two");
  EXPECT_EQ(again["digest"], report["digest"]);
}

TEST_F(FaultRunTest, TheMissionGoesOnWithoutUavsForHalfAnHour) {
  const Json report = Run({"process_killed:uav@60+30"}, "killed", GoingOn());
  EXPECT_EQ(report["events"]["process_back"], 2) << "the launcher's and the world's word";
  EXPECT_EQ(report["events"]["agent_failed"], report["events"]["agent_back"]);
  EXPECT_GT(report["events"]["agent_back"], 0);
  int uavs_during = 0, uavs_after = 0;
  for (const Json& decision : report["decisions"]) {
    for (const Json& action : decision["actions"]) {
      const double min = decision["sim_s"].get<double>() / 60;
      if (action["uav"] < 0) continue;
      uavs_during += min > 60 && min < 90;
      uavs_after += min > 100;
    }
  }
  EXPECT_EQ(uavs_during, 0);
  EXPECT_GT(uavs_after, 0);
}

TEST_F(FaultRunTest, AWorldThatDiesMeanwhileGoesOnWithoutThoseThatAreLost) {
  const Json report = Run(
      {"process_killed:uav@60+30", "process_stopped:scheduler@65+30", "process_killed:world@75"},
      "killed", GoingOn());
  EXPECT_EQ(report["events"]["agent_failed"], report["events"]["agent_back"]);
  EXPECT_GT(report["events"]["agent_back"], 0);
  EXPECT_GE(report["skipped_decisions"].size(), 2u);
  EXPECT_GT(report["decisions"].back()["index"], 10);
}

TEST_F(FaultRunTest, TheMissionGoesOnWithoutAScheduler) {
  const Json report = Run({"process_stopped:scheduler@65+30"}, "stopped", GoingOn());
  EXPECT_GE(report["skipped_decisions"].size(), 2u) << report["skipped_decisions"];
  EXPECT_GT(report["decisions"].back()["index"], 10);
}

TEST_F(FaultRunTest, WhoIsStoppedOrCutOffForMinutesComesBack) {
  const Json report =
      Run({"process_stopped:worker@40+20", "partition:vehicle|world@90+20"}, "both", GoingOn());
  EXPECT_EQ(report["events"]["process_lost"], 2);
  EXPECT_EQ(report["events"]["process_back"], 2);
}

TEST_F(FaultRunTest, AMissionThatStandsSaysForWhom) {
  Muster muster(folder_, "run",
                {"run", scenario_, "--quiet", "--out", folder_.File("run"), "--fault",
                 "process_stopped:vehicle@60+4s", "--rate", "1800"});
  EXPECT_EQ(muster.Wait(), 0) << muster.output();
  const std::string said = muster.output();
  EXPECT_NE(said.find("it waits for vehicle (silent for"), std::string::npos) << said;
  // At which minute of the mission that was is looked up now and then: not before it stood.
  std::smatch minute;
  ASSERT_TRUE(std::regex_search(said, minute, std::regex("the mission goes on at ([0-9.]+) min")))
      << said;
  EXPECT_GE(std::stod(minute[1]), 60) << said;
}

TEST_F(FaultRunTest, ABadPlanIsRefusedBeforeAnythingIsWritten) {
  const std::string plan = folder_.File("plan.json");
  std::ofstream(plan) << R"({"version": 1, "faults": [
      {"kind": "process_killed", "target": "ufo", "at_min": 3}]})";
  Muster muster(folder_, "bad", {"run", scenario_, "--out", folder_.File("bad"), "--faults", plan});
  EXPECT_EQ(muster.Wait(), 2);
  EXPECT_NE(muster.output().find("faults[0]: target: found ufo"), std::string::npos)
      << muster.output();
  EXPECT_FALSE(std::filesystem::exists(folder_.File("bad") + "/scenario.json"));
}

}  // namespace
}  // namespace muster::tools
