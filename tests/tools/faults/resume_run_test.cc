// Missions whose launcher is killed with all its processes, and which go on.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/random.h"
#include "tests/tools/faults/mission_test.h"
#include "tests/tools/launch/live_log.h"
#include "tests/tools/launch/muster_process.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class ResumeRunTest : public MissionTest {
 protected:
  std::vector<std::string> RunArguments(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"run", scenario_, "--quiet", "--out",
                                          run_,  "--rate",  "1800"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  /// The launcher and all its processes end at once when the log has that tick, and some of this
  /// start: on a busy machine the start before may have been killed later than it was to be.
  void KillAt(std::int64_t tick, Muster* muster, int signal = SIGKILL) const {
    LiveLog log(run_);
    log.Read();
    const std::int64_t least = std::max(tick, log.tick() + 10);
    ASSERT_TRUE(Eventually([&] {
      log.Read();
      return log.tick() >= least || muster->child().Poll();
    }));
    ASSERT_FALSE(muster->child().Poll()) << muster->output();
    muster->child().Signal(signal);
    ASSERT_TRUE(Eventually([&] { return muster->child().Poll().has_value(); }));
  }
  /// The mission goes on to its end and is what it would have been.
  void ExpectResumed(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"resume", run_, "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Muster resumed(folder_, "resumed", arguments);
    ASSERT_EQ(resumed.Wait(), 0) << resumed.output();
    const Json report = Report();
    EXPECT_EQ(report["digest"], undisturbed_);
    EXPECT_TRUE(report["log"]["complete"].get<bool>()) << report["log"];
    CheckRun(run_, folder_.File("checked"));
  }
  std::string run_ = folder_.File("run");
};

TEST_F(ResumeRunTest, KilledAgainAndAgain) {
  const std::uint64_t seed = 1;
  Random random(seed, Stream::kTest);
  std::vector<std::int64_t> ticks;
  for (int i = 0; i < 3; ++i) ticks.push_back(100 * i + random.Below(90));
  SCOPED_TRACE(fmt::format("seed {}, killed at ticks {}", seed, fmt::join(ticks, ", ")));
  {
    Muster muster(folder_, "muster", RunArguments({}));
    KillAt(ticks[0], &muster);
  }
  for (const std::int64_t tick : {ticks[1], ticks[2]}) {
    Muster muster(folder_, "muster", {"resume", run_, "--quiet"});
    KillAt(tick, &muster);
  }
  ExpectResumed();
  std::map<std::string, int> restarts;
  const Json report = Report();
  for (const Json& process : report["processes"]) {
    restarts[process["name"]] = process["restarts"].get<int>();
  }
  for (const std::string name : {"world", "uav", "scheduler", "launcher", "recorder"}) {
    EXPECT_EQ(restarts[name], 3) << name;
  }
}

TEST_F(ResumeRunTest, InterruptedThenFasterAndWithLcmLogger) {
  {
    Muster muster(folder_, "muster", RunArguments({"--logger", "lcm", "--seal"}));
    KillAt(50, &muster, SIGINT);
  }
  EXPECT_FALSE(Report()["log"]["complete"].get<bool>());
  ExpectResumed({"--rate", "max"});
}

TEST_F(ResumeRunTest, APowerCutTakesTheEndOfTheLogWithIt) {
  for (const std::uintmax_t lost : {7, 60'000}) {
    SCOPED_TRACE(fmt::format("{} bytes lost", lost));
    fs::remove_all(run_);
    {
      Muster muster(folder_, "muster", RunArguments({"--processes", "scheduler=0,uav=2"}));
      KillAt(120, &muster);
    }
    const std::string log = run_ + "/mission.lcm";
    fs::resize_file(log, fs::file_size(log) - lost);
    ExpectResumed();
  }
}

TEST_F(ResumeRunTest, BeforeTheMissionHasBegun) {
  {
    Muster muster(folder_, "muster", RunArguments({}));
    ASSERT_TRUE(
        Eventually([&] { return fs::exists(run_ + "/mission.lcm") || muster.child().Poll(); }));
    muster.child().Signal(SIGKILL);
    ASSERT_TRUE(Eventually([&] { return muster.child().Poll().has_value(); }));
  }
  ExpectResumed();
}

TEST_F(ResumeRunTest, FaultsOfThePlanThatAreStillToComeCome) {
  {
    Muster muster(folder_, "muster",
                  RunArguments({"--on-loss", "continue", "--lost-after", "2", "--fault",
                                "process_killed:uav@20", "--fault", "process_killed:worker@150"}));
    KillAt(120, &muster);
  }
  Muster resumed(folder_, "resumed", {"resume", run_, "--quiet"});
  ASSERT_EQ(resumed.Wait(), 0) << resumed.output();
  EXPECT_EQ(resumed.output().find("process_killed uav"), std::string::npos) << resumed.output();
  EXPECT_NE(resumed.output().find("process_killed worker"), std::string::npos) << resumed.output();
  CheckRun(run_, folder_.File("checked"));
}

TEST_F(ResumeRunTest, PersonsAndOrdersStay) {
  const std::string persons = folder_.File("persons.json");
  std::string said;
  const auto ask = [&](const std::vector<std::string>& arguments) {
    Muster command(folder_, "command", arguments);
    const int code = command.Wait();
    said = command.output();
    return code;
  };
  const auto add_person = [&](const std::string& name) {
    return ask(
        {"person", "add", persons, name, "--role", "order", "--key-file", folder_.File(name)});
  };
  const auto add_task = [&](const std::string& by) {
    return ask({"task", "add", run_, "--at", "5,5", "--sign", folder_.File(by)});
  };
  ASSERT_EQ(add_person("Radio") + add_person("Old"), 0) << said;
  {
    Muster muster(folder_, "muster",
                  {"run", scenario_, "--quiet", "--out", run_, "--rate", "600", "--limit", "90",
                   "--persons", persons});
    ASSERT_TRUE(Eventually([&] { return add_task("Radio") == 0; })) << said;
    KillAt(20, &muster);
  }
  ASSERT_EQ(ask({"person", "remove", persons, "Old"}) + add_person("New"), 0) << said;
  Muster resumed(folder_, "resumed", {"resume", run_, "--quiet"});
  ASSERT_TRUE(Eventually([&] { return add_task("Radio") == 0; })) << said;
  EXPECT_EQ(add_task("New"), 0) << said;
  EXPECT_EQ(add_task("Old"), 4);
  EXPECT_NE(said.find("Old may not order any more"), std::string::npos) << said;
  ASSERT_EQ(resumed.Wait(), 0) << resumed.output();
  CheckRun(run_, folder_.File("checked"));
}

TEST_F(ResumeRunTest, WhatCannotGoOnIsRefused) {
  const auto refusal = [&](const std::string& run) {
    Muster resume(folder_, "refused", {"resume", run});
    EXPECT_EQ(resume.Wait(), 2) << resume.output();
    return resume.output();
  };
  EXPECT_NE(refusal(folder_.File("none")).find("none: no such run directory"), std::string::npos);
  EXPECT_NE(refusal(folder_.File(std::string("simulated-") + kQuickPolicy)).find("manifest.json"),
            std::string::npos);
  Muster muster(folder_, "muster", RunArguments({"--rate", "max"}));
  LiveLog log(run_);
  ASSERT_TRUE(Eventually([&] {
    log.Read();
    return log.tick() >= 5;
  }));
  muster.child().Signal(SIGSTOP);
  EXPECT_NE(refusal(run_).find("a running mission writes there"), std::string::npos);
  muster.child().Signal(SIGCONT);
  ASSERT_EQ(muster.Wait(), 0) << muster.output();
  EXPECT_NE(refusal(run_).find("this mission has ended; its report is"), std::string::npos);
  fs::remove(run_ + "/report.json");
  std::ofstream(run_ + "/manifest.json") << "{\"run_id\": 5}";
  EXPECT_NE(refusal(run_).find("manifest.json: command_line: found no such key"), std::string::npos)
      << refusal(run_);
}

}  // namespace
}  // namespace muster::tools
