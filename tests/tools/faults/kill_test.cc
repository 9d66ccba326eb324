// Processes of a real mission, killed from outside at random ticks.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "base/random.h"
#include "lcmtypes/bus/multicast.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "scheduler/policies/registry.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/faults/mission_test.h"
#include "tests/tools/launch/live_log.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class KillTest : public MissionTest {
 protected:
  /// By the default policy: its decisions take long enough for a death while one is made.
  void KillAllByTheDefaultPolicy(const std::vector<std::string>& victims, std::uint64_t seed) {
    const std::string policy(scheduler::kDefaultPolicy);
    undisturbed_ = Undisturbed(policy);
    KillAll(victims, seed, {"--policy", policy});
  }
  /// A mission in which each of `victims` is killed at a random tick of its own.
  void KillAll(const std::vector<std::string>& victims, std::uint64_t seed,
               const std::vector<std::string>& more = {}) {
    const std::string name = fmt::format("run-{}-{}", victims.front(), seed);
    SCOPED_TRACE(fmt::format("{}, seed {}", fmt::join(victims, ", "), seed));
    std::vector<std::string> arguments = {
        "run", scenario_, "--quiet", "--out", folder_.File(name), "--rate", "1800"};
    const bool lcm = std::find(victims.begin(), victims.end(), "lcm-logger") != victims.end();
    if (lcm) arguments.insert(arguments.end(), {"--logger", "lcm"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    Muster muster(folder_, name, arguments);
    LiveLog log(folder_.File(name));
    Random random(seed, Stream::kTest);
    std::int64_t at = 0;
    const std::int64_t last = 3 * 120;  // ticks of 30 s in three hours
    for (std::size_t i = 0; i < victims.size(); ++i) {
      const std::int64_t room = last / static_cast<std::int64_t>(victims.size());
      at = static_cast<std::int64_t>(i) * room + random.Below(static_cast<std::uint32_t>(room));
      const auto victim = [&] {
        return victims[i] == "lcm-logger" ? ChildOf(muster.child().pid(), "lcm-logger")
                                          : log.pid(victims[i]);
      };
      ASSERT_TRUE(Eventually([&] {
        log.Read();
        return (log.tick() >= at && victim() > 0) || muster.child().Poll();
      }));
      ASSERT_FALSE(muster.child().Poll()) << muster.output();
      ASSERT_EQ(kill(victim(), SIGKILL), 0);
    }
    ASSERT_EQ(muster.Wait(), 0) << muster.output();
    const Json report = Report(name);
    EXPECT_EQ(report["digest"], undisturbed_) << "killed at tick " << at;
    EXPECT_TRUE(report["log"]["complete"].get<bool>()) << report["log"];
    std::map<std::string, int> restarts;
    for (const Json& process : report["processes"]) {
      restarts[process["name"]] = process["restarts"].get<int>();
    }
    EXPECT_EQ(report["events"]["process_lost"], victims.size());
    for (const std::string& victim : victims) {
      if (victim == "lcm-logger") {
        EXPECT_TRUE(fs::exists(folder_.File(name) + "/mission.lcm.1"));
      } else {
        EXPECT_EQ(restarts[victim], 1) << victim;
      }
    }
  }
};

TEST_F(KillTest, World) { KillAll({"world"}, 1); }
TEST_F(KillTest, Uav) { KillAll({"uav"}, 2); }
TEST_F(KillTest, Worker) { KillAll({"worker"}, 3); }
TEST_F(KillTest, Vehicle) { KillAll({"vehicle"}, 4); }
TEST_F(KillTest, Scheduler) { KillAllByTheDefaultPolicy({"scheduler"}, 5); }
TEST_F(KillTest, Recorder) { KillAll({"recorder"}, 6); }
TEST_F(KillTest, LcmLogger) { KillAll({"lcm-logger"}, 6); }
TEST_F(KillTest, EachOnceInOneMission) {
  KillAllByTheDefaultPolicy({"uav", "lcm-logger", "world", "worker", "scheduler", "vehicle"}, 7);
}
TEST_F(KillTest, AllAtOnce) {
  const std::vector<std::string> victims = {"world",   "uav",       "worker",
                                            "vehicle", "scheduler", "lcm-logger"};
  std::vector<std::string> arguments = {"run",   scenario_,           "--quiet",
                                        "--out", folder_.File("run"), "--rate",
                                        "1800",  "--logger",          "lcm"};
  for (const std::string& victim : victims) {
    arguments.insert(arguments.end(), {"--fault", fmt::format("process_killed:{}@80.5", victim)});
  }
  Muster muster(folder_, "run", arguments);
  ASSERT_EQ(muster.Wait(), 0) << muster.output();
  EXPECT_NE(muster.output().find("no process answered world about"), std::string::npos)
      << muster.output();
  const Json report = Report("run");
  EXPECT_EQ(report["digest"], undisturbed_);
  EXPECT_TRUE(report["log"]["complete"].get<bool>()) << report["log"];
  EXPECT_EQ(report["events"]["process_lost"], victims.size());
}
TEST_F(KillTest, WhoEndsForGoodIsDoneWithout) {
  Muster muster(folder_, "run",
                {"run", scenario_, "--quiet", "--out", folder_.File("run"), "--rate", "3600",
                 "--on-loss", "continue", "--lost-after", "3", "--restarts", "0"});
  LiveLog log(folder_.File("run"));
  ASSERT_TRUE(Eventually([&] {
    log.Read();
    return log.tick() >= 60 && log.pid("vehicle") > 0;
  }));
  ASSERT_EQ(kill(log.pid("vehicle"), SIGKILL), 0);
  EXPECT_EQ(muster.Wait(), 0) << muster.output();
  EXPECT_NE(muster.output().find("the mission goes on without it"), std::string::npos)
      << muster.output();
  const Json report = Report("run");
  EXPECT_TRUE(report["log"]["complete"].get<bool>()) << report["log"];
  EXPECT_EQ(report["events"]["agent_back"], 0);
  EXPECT_GT(report["events"]["agent_failed"], 0);
  EXPECT_GT(report["tasks_done"], 0);
}

// It is frozen for good: a mission that goes on without it ends without it, too.
TEST_F(KillTest, WhoIsFrozenIsLeftBehind) {
  Muster muster(folder_, "run",
                {"run", scenario_, "--quiet", "--out", folder_.File("run"), "--rate", "3600",
                 "--on-loss", "continue", "--lost-after", "4"});
  LiveLog log(folder_.File("run"));
  ASSERT_TRUE(Eventually([&] {
    log.Read();
    return log.tick() >= 60 && log.pid("uav") > 0;
  }));
  ASSERT_EQ(kill(log.pid("uav"), SIGSTOP), 0);
  EXPECT_EQ(muster.Wait(), 0) << muster.output();
  for (const char* said :
       {"it waits for uav", "uav has been silent for", "the mission ends without it"}) {
    EXPECT_NE(muster.output().find(said), std::string::npos) << said << muster.output();
  }
}

// In the place of the frozen launcher: its log tells nobody what it holds.
TEST_F(KillTest, WhoeverTheLogHoldsIsNotLost) {
  std::vector<std::string> arguments = {"run", scenario_, "--quiet", "--out", folder_.File("run")};
  for (const std::string& argument : GoingOn()) arguments.push_back(argument);
  const std::string fault = fmt::format("process_stopped:lcm-logger@60+{}s", 4 * kSlowness);
  arguments.insert(arguments.end(), {"--logger", "lcm", "--fault", fault});
  Muster muster(folder_, "run", arguments);
  EXPECT_EQ(muster.Wait(), 0) << muster.output();
  const Json report = Report("run");
  EXPECT_EQ(report["digest"], undisturbed_);
  EXPECT_EQ(report["events"]["process_lost"], 0);
}

// A scheduler that decides otherwise, a world at the mission's beginning, agents where they
// started.
TEST_F(KillTest, ASecondProcessOfANameIsRefusedAndNamed) {
  Muster muster(
      folder_, "run",
      {"run", scenario_, "--quiet", "--out", folder_.File("run"), "--rate", "600", "--lcm-url",
       MissionUrl(static_cast<std::uint16_t>(20000 + getpid() % 4000 * 10 + 9))});
  LiveLog log(folder_.File("run"));
  const Json manifest = [&] {
    EXPECT_TRUE(Eventually([&] {
      log.Read();
      return (log.tick() >= 3 && log.pid("scheduler") > 0) || muster.child().Poll();
    })) << muster.output();
    return Json::parse(TextOf(folder_.File("run") + "/manifest.json"));
  }();
  const std::map<std::string, std::vector<std::string>> seconds = {
      {"scheduler", {"--policy", "greedy-nearest"}}, {"world", {scenario_}}, {"uav", {}}};
  for (const auto& [name, more] : seconds) {
    std::vector<std::string> command = {
        (fs::path(MUSTER_PROGRAM).parent_path() / ("muster-" + name)).string(),
        "--lcm-url",
        manifest["lcm_url"],
        "--run-id",
        std::to_string(manifest["run_id"].get<std::int64_t>()),
        "--window",
        "3"};
    command.insert(command.end(), more.begin(), more.end());
    Child second({"second-" + name, command, folder_.File("second-" + name)});
    EXPECT_TRUE(Eventually([&, name = name] {
      return muster.output().find("two processes send as " + name) != std::string::npos ||
             muster.child().Poll();
    })) << muster.output();
    ASSERT_TRUE(Eventually([&] { return second.Poll().has_value(); })) << name;
    EXPECT_EQ(second.Poll()->Text(), "exited with code 3") << name;
    const std::string said = TextOf(folder_.File("second-" + name));
    EXPECT_NE(said.find(name + " speaks already, pid "), std::string::npos) << said;
  }
  // Not Wait(): the audit finds what they said meanwhile, and shall.
  ASSERT_TRUE(
      Eventually([&] { return muster.child().Poll().has_value(); }, std::chrono::minutes(3)));
  EXPECT_TRUE(muster.child().Poll()->clean()) << muster.output();
  EXPECT_EQ(Report("run")["digest"], undisturbed_);
}

TEST_F(KillTest, OverABadNetwork) { KillAll({"worker", "world"}, 8, {"--drop", "0.2"}); }
TEST_F(KillTest, SchedulerUavsAndLoggerOverABadNetwork) {
  KillAll({"scheduler", "uav", "lcm-logger"}, 9, {"--drop", "0.1"});
}

}  // namespace
}  // namespace muster::tools
