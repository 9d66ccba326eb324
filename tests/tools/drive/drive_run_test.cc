// Missions over LCM with drivers of their own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/spawn.h"
#include "tests/tools/faults/mission_test.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

class DriveRunTest : public MissionTest {
 protected:
  void SetUp() override {
    if (!FindProgram("python3")) GTEST_SKIP() << "no python3";
    MissionTest::SetUp();
  }
  static std::string DriverOf(const std::string& agent, const std::string& options = "") {
    return fmt::format("{}=python3 {} {}", agent, MUSTER_EXAMPLES "/uav.py", options);
  }
  /// Its report.json. It is audited and decided again. Without --rate it waits for its drivers: by
  /// default for 5 s, which may be too short for a python3 to start on a busy machine.
  Json Fly(std::vector<std::string> options, std::string* output = nullptr) {
    std::filesystem::remove_all(folder_.File("run"));
    options.insert(options.begin(), {"run", scenario_, "--quiet", "--out", folder_.File("run")});
    Muster mission(folder_, "mission", options);
    EXPECT_EQ(mission.Wait(), 0) << mission.output();
    if (output != nullptr) *output = mission.output();
    return Report();
  }
};

TEST_F(DriveRunTest, OnTimeTheMissionIsTheComputedOne) {
  EXPECT_EQ(Fly({"--driver", DriverOf("uav:3"), "--driver", DriverOf("worker:4"), "--driver",
                 DriverOf("vehicle:1"), "--lost-after", "60"})["digest"],
            undisturbed_);
  EXPECT_EQ(Fly({"--driver", DriverOf("uav:3"), "--logger", "lcm", "--drop", "0.1", "--lost-after",
                 "60"})["digest"],
            undisturbed_);
}

TEST_F(DriveRunTest, DeathsOfOurProcessesChangeNothing) {
  const std::pair<const char*, const char*> victims[] = {{"world", "uav"},
                                                         {"scheduler", "recorder"}};
  for (const auto& [first, second] : victims) {
    SCOPED_TRACE(first);
    EXPECT_EQ(Fly({"--driver", DriverOf("uav:3"), "--lost-after", "60", "--fault",
                   fmt::format("process_killed:{}@26", first), "--fault",
                   fmt::format("process_killed:{}@60.5", second)})["digest"],
              undisturbed_);
  }
}

TEST_F(DriveRunTest, LateItStillFlies) {
  const Json report = Fly({"--driver", DriverOf("uav:3", "--late 20"), "--lost-after", "60"});
  EXPECT_NE(report["digest"], undisturbed_);
  EXPECT_GE(report["tasks_done"], 110);
  EXPECT_TRUE(report["failed_agents"].empty());
}

TEST_F(DriveRunTest, WhoDiesHangsOrTalksNonsenseHasFailedForThatReason) {
  const std::pair<std::string, std::string> drivers[] = {
      {DriverOf("uav:3", "--dies 25"), "its driver: its program exited with code 1"},
      {DriverOf("uav:3", "--silent 25:35"), "its driver: silent for 1 s while it was "},
      {"uav:3=echo nonsense", "its driver: its line: "},
      {"uav:3=true", "its driver: its program exited with code 0"},
  };
  for (const auto& [driver, why] : drivers) {
    SCOPED_TRACE(driver);
    std::string output;
    // Who ends has the time that it takes on a busy machine.
    const char* const patience_s = why.find("silent") == std::string::npos ? "60" : "1";
    const Json report = Fly({"--driver", driver, "--lost-after", patience_s}, &output);
    ASSERT_EQ(report["failed_agents"].size(), 1U);
    EXPECT_EQ(report["failed_agents"][0]["agent"], "uav:3");
    const std::string said = report["failed_agents"][0]["why"];
    EXPECT_EQ(said.substr(0, why.size()), why);
    EXPECT_NE(output.find("muster: uav:3 cannot go on: " + why), std::string::npos) << output;
    EXPECT_GE(report["tasks_done"], 110);
  }
}

TEST_F(DriveRunTest, WhoIsNotReadyHasNotFailedAndMayFailLater) {
  std::string output;
  const Json report =
      Fly({"--driver", DriverOf("uav:3", "--ready 15 --dies 25"), "--lost-after", "60"}, &output);
  const std::size_t waits =
      output.find("muster: uav:3 is not ready, and waits for this: minute 15");
  const std::size_t dies =
      output.find("muster: uav:3 cannot go on: its driver: its program exited");
  EXPECT_LT(waits, dies) << output;
  EXPECT_NE(dies, std::string::npos) << output;
  ASSERT_EQ(report["failed_agents"].size(), 1U);
  EXPECT_EQ(report["failed_agents"][0]["agent"], "uav:3");
}

TEST_F(DriveRunTest, SilentAtARateItIsExpectedFromTickToTick) {
  const Json report = Fly(
      {"--driver", DriverOf("uav:3", "--silent 25:35"), "--rate", "1800", "--lost-after", "30"});
  EXPECT_TRUE(report["failed_agents"].empty());
  EXPECT_NE(report["digest"], undisturbed_);
}

TEST_F(DriveRunTest, AProcessAloneSaysWhatItCannotDrive) {
  const std::string program =
      std::filesystem::path(MUSTER_PROGRAM).parent_path().string() + "/muster-uav";
  Child child({"alone", {program, "--driver", "x=/no/such/program"}, folder_.File("alone")});
  ASSERT_TRUE(Eventually([&] { return child.Poll().has_value(); }));
  EXPECT_EQ(WEXITSTATUS(child.Poll()->wait_status), 2) << TextOf(folder_.File("alone"));
}

}  // namespace
}  // namespace muster::tools
