// Missions with a second recorder, whose log is whole when the first one is gone.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/faults/mission_test.h"
#include "tests/tools/launch/live_log.h"
#include "tests/tools/launch/muster_process.h"
#include "tools/log/log_info.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class SecondLogRunTest : public MissionTest {
 protected:
  std::vector<std::string> RunArguments(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"run", scenario_,      "--quiet", "--out",
                                          run_,  "--second-log", second_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  static std::size_t Gaps(const std::string& run) {
    std::size_t gaps = 0;
    for (const auto& [start, sender] : ReadLogInfo(run).senders) gaps += sender.Gaps().size();
    return gaps;
  }
  /// The log of the mission up to its end, with all its rules kept.
  void ExpectWhole(const std::string& log) const {
    EXPECT_EQ(Gaps(log), 0u) << log;
    CheckRun(log, folder_.File("checked"));
  }
  std::string run_ = folder_.File("run"), second_ = folder_.File("second");
};

TEST_F(SecondLogRunTest, BothLogsAreCompleteUnderLossAndDeaths) {
  Muster muster(
      folder_, "muster",
      RunArguments({"--rate", "1800", "--fault", "loss:*@0+180=0.2", "--fault",
                    "process_killed:recorder-2@40", "--fault", "process_killed:recorder@90"}));
  ASSERT_EQ(muster.Wait(), 0) << muster.output();
  EXPECT_EQ(Report()["digest"], undisturbed_);
  ExpectWhole(run_);
  ExpectWhole(second_);
  EXPECT_TRUE(fs::exists(second_ + "/mission.lcm.1"));
}

TEST_F(SecondLogRunTest, GoesOnFromTheSecondLogWhenTheFirstIsGone) {
  {
    Muster muster(folder_, "muster", RunArguments({"--rate", "1800", "--seal"}));
    LiveLog log(run_);
    ASSERT_TRUE(Eventually([&] {
      log.Read();
      return log.tick() >= 100 || muster.child().Poll();
    }));
    ASSERT_FALSE(muster.child().Poll()) << muster.output();
    muster.child().Signal(SIGKILL);
    ASSERT_TRUE(Eventually([&] { return muster.child().Poll().has_value(); }));
  }
  const std::string first_part = folder_.File("first-part");
  fs::rename(run_, first_part);  // its host is gone
  Muster resumed(folder_, "resumed", {"resume", second_});
  ASSERT_EQ(resumed.Wait(), 0) << resumed.output();
  EXPECT_NE(resumed.output().find("was the second log: there is none from here on"),
            std::string::npos);
  EXPECT_EQ(Report("second")["digest"], undisturbed_);
  ExpectWhole(second_);
  const std::string merged = folder_.File("merged.lcm");
  Muster merge(folder_, "merge", {"log", "merge", first_part, second_, "--out", merged});
  ASSERT_EQ(merge.Wait(), 0) << merge.output();
  EXPECT_NE(merge.output().find("no gap in any sender's numbers"), std::string::npos)
      << merge.output();
  fs::copy_file(second_ + "/seal.key", folder_.File("seal.key"));
  ExpectWhole(merged);
}

TEST_F(SecondLogRunTest, WithoutTheSecondRecorderTheMissionGoesOnAndAMergeClosesTheHole) {
  Muster muster(folder_, "muster",
                RunArguments({"--rate", "1800", "--lost-after", "1", "--fault",
                              "process_killed:recorder-2@30+2s"}));
  ASSERT_EQ(muster.Wait(), 0) << muster.output();
  EXPECT_NE(muster.output().find("does not wait for the second log any more"), std::string::npos)
      << muster.output();
  EXPECT_EQ(Report()["digest"], undisturbed_);
  ExpectWhole(run_);
  EXPECT_GT(Gaps(second_), 0u);
  const std::string merged = folder_.File("merged.lcm");
  Muster merge(folder_, "merge", {"log", "merge", second_, run_, "--out", merged});
  ASSERT_EQ(merge.Wait(), 0) << merge.output();
  ExpectWhole(merged);
}

TEST_F(SecondLogRunTest, AFolderThatHoldsSomethingIsRefused) {
  fs::create_directory(second_);
  std::ofstream(second_ + "/notes.txt") << "mine";
  Muster muster(folder_, "muster", RunArguments({}));
  EXPECT_EQ(muster.Wait(), 2);
  EXPECT_NE(muster.output().find("--second-log: found " + second_ + ", expected a new or empty"),
            std::string::npos)
      << muster.output();
  EXPECT_FALSE(fs::exists(run_));
}

}  // namespace
}  // namespace muster::tools
