// Whole missions by the real `muster run`.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "recorder/log_follower.h"
#include "scheduler/policies/registry.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"
#include "tools/host/child.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// What a mission's log says, read like anybody would.
struct Log {
  explicit Log(const std::string& file) {
    EventLogReader reader(file, EventLogReader::Tail::kFinal);
    std::optional<recorder::LogFollower> follower;
    while (const auto event = reader.Next()) {
      // LCM's and our own tests of the transport are recorded, too.
      if (FindChannel(event->packet.channel) == nullptr) continue;
      const auto header = DecodeHeader(event->packet);
      if (!header) {
        ADD_FAILURE() << "unreadable message on " << event->packet.channel;
        continue;
      }
      runs.insert(header->run_id);
      if (!follower) follower.emplace(header->run_id);
      if (follower->Add(event->packet)) ++messages;
      if (event->packet.channel == channel::kProcess) {
        const auto status = DecodeValid<process_status_t>(event->packet.bytes);
        if (status && status->state == 4) ended.insert(header->sender);
        if (status) pids[header->sender] = status->pid;
      } else if (event->packet.channel == channel::kClock) {
        const auto clock = DecodeValid<clock_t>(event->packet.bytes);
        if (clock && clock->phase == 2) end_announced = true;
      }
    }
    garbage = reader.garbage_bytes();
    missing = follower ? follower->missing() : 0;
  }
  std::set<std::int64_t> runs;
  std::set<std::string> ended;
  std::map<std::string, pid_t> pids;
  std::int64_t messages = 0;
  std::int64_t missing = 0;
  std::int64_t garbage = 0;
  bool end_announced = false;
};

class RunTest : public ::testing::Test {
 protected:
  void SetUp() override {
    MUSTER_NEEDS_MULTICAST();
    const Scenario scenario = Generate(PresetByName("Random_1"), 1);
    std::ofstream(scenario_) << ScenarioToJson(scenario);
  }
  std::string Out(const std::string& name = "run") const { return folder_.File(name); }
  Json Report(const std::string& name = "run") const {
    return Json::parse(TextOf(Out(name) + "/report.json"), nullptr, false);
  }
  Muster Start(std::vector<std::string> arguments, const std::string& name = "run") const {
    arguments.insert(arguments.begin(), {"run", scenario_, "--out", Out(name)});
    return Muster(folder_, name, arguments);
  }
  /// Until a first decision: each process has been heard then. Slow enough (--rate) to be met
  /// there.
  static bool UnderWay(const Muster& muster) { return Says(muster, "decisions 1 "); }
  static bool Says(const Muster& muster, const char* words) {
    return Eventually([&] { return muster.output().find(words) != std::string::npos; });
  }

  TemporaryFolder folder_;
  std::string scenario_ = folder_.File("scenario.json");
};

TEST_F(RunTest, WholeMissionLeavesACompleteLogAndReport) {
  Muster muster = Start({"--policy", std::string(scheduler::kDefaultPolicy)});
  ASSERT_EQ(muster.Wait(), 0) << muster.output();
  for (const char* name :
       {"mission.lcm", "scenario.json", "manifest.json", "report.json", "world.stderr",
        "uav.stderr", "worker.stderr", "vehicle.stderr", "scheduler.stderr", "recorder.stderr"}) {
    EXPECT_TRUE(fs::exists(Out() + "/" + name)) << name;
  }
  const Log log(Out() + "/mission.lcm");
  EXPECT_EQ(log.missing, 0);
  EXPECT_EQ(log.garbage, 0);
  EXPECT_TRUE(log.end_announced);
  EXPECT_EQ(log.runs.size(), 1u);
  EXPECT_EQ(log.ended, (std::set<std::string>{"launcher", "recorder", "scheduler", "uav", "vehicle",
                                              "worker", "world"}));
  const Json report = Report();
  EXPECT_TRUE(report["log"]["complete"].get<bool>());
  EXPECT_EQ(report["log"]["messages"], log.messages);
  EXPECT_GT(report["tasks_done"], 0);
  EXPECT_NE(muster.output().find("tasks done"), std::string::npos);
  // As after every mission of a test that ends well (muster_process.h).
  EXPECT_NE(TextOf(folder_.File("run.output.audit")).find("passed: every rule holds"),
            std::string::npos);
  EXPECT_NE(TextOf(folder_.File("run.output.redecide")).find("bit for bit"), std::string::npos);
}

TEST_F(RunTest, WithoutAPolicyTheDefaultOneDecides) {
  // Not a Muster, which would name one.
  const std::string said = folder_.File("said");
  Child muster({"run", MusterArgv({"run", scenario_, "--limit", "10", "--out", Out()}), said});
  ASSERT_TRUE(Eventually([&] { return muster.Poll().has_value(); }));
  EXPECT_TRUE(muster.Poll()->clean()) << TextOf(said);
  EXPECT_EQ(Report()["policy"], std::string(scheduler::kDefaultPolicy));
}

TEST_F(RunTest, StockLcmLoggerLeavesTheSame) {
  Muster muster = Start({"--logger", "lcm"});
  ASSERT_EQ(muster.Wait(), 0) << muster.output();
  EXPECT_TRUE(fs::exists(Out() + "/lcm-logger.stderr"));
  EXPECT_FALSE(fs::exists(Out() + "/recorder.stderr"));
  const Log log(Out() + "/mission.lcm");
  EXPECT_EQ(log.missing, 0);
  EXPECT_EQ(log.garbage, 0);
  EXPECT_TRUE(log.end_announced);
  EXPECT_EQ(log.ended,
            (std::set<std::string>{"recorder", "scheduler", "uav", "vehicle", "worker", "world"}));
  EXPECT_TRUE(Report()["log"]["complete"].get<bool>());
  EXPECT_EQ(Report()["log"]["messages"], log.messages);
  Muster other = Start({}, "other");
  ASSERT_EQ(other.Wait(), 0) << other.output();
  EXPECT_EQ(Report()["digest"], Report("other")["digest"]);
}

TEST_F(RunTest, WithoutLcmLoggerItIsSaidWhereToGetIt) {
  const char* const path = std::getenv("PATH");
  const std::string kept = path == nullptr ? "" : path;
  setenv("PATH", "/nonexistent", 1);
  fs::create_directory(Out("empty"));
  Muster with = Start({"--logger", "lcm"}, "with");
  Muster empty = Start({"--logger", "lcm"}, "empty");
  Muster without = Start({"--limit", "10"}, "without");
  setenv("PATH", kept.c_str(), 1);
  EXPECT_EQ(with.Wait(), 3);
  EXPECT_EQ(with.output(),
            "muster: lcm-logger is not in PATH; Debian has it in the package liblcm-bin\n");
  EXPECT_FALSE(fs::exists(Out("with"))) << "its mission has not begun";
  EXPECT_EQ(empty.Wait(), 3);
  EXPECT_TRUE(fs::exists(Out("empty")) && fs::is_empty(Out("empty")));
  EXPECT_EQ(without.Wait(), 0) << without.output();
}

TEST_F(RunTest, HowTheMissionIsSplitChangesNoDecision) {
  Muster one = Start({}, "one");
  Muster two = Start({"--processes", "uav=2,worker=3"}, "two");
  ASSERT_EQ(one.Wait(), 0) << one.output();
  ASSERT_EQ(two.Wait(), 0) << two.output();
  EXPECT_TRUE(fs::exists(Out("two") + "/worker-3.stderr"));
  EXPECT_EQ(Report("one")["digest"], Report("two")["digest"]);
}

TEST_F(RunTest, AProcessStartedByHandTakesPart) {
  // A port of our own, where tests share the host's network.
  const std::string url = fmt::format("udpm://239.255.76.67:{}?ttl=0", 20'000 + getpid() % 10'000);
  Muster muster = Start({"--processes", "uav=0", "--lcm-url", url});
  ASSERT_TRUE(Eventually([&] {
    return muster.output().find("--window") != std::string::npos || muster.child().Poll();
  }));
  // "start yourself: PROGRAM --lcm-url ..."
  const std::string said = muster.output();
  const std::string lead = "start yourself: ";
  const std::size_t at = said.find(lead);
  ASSERT_NE(at, std::string::npos) << said;
  const std::size_t begin = at + lead.size();
  const std::string command = "exec " + said.substr(begin, said.find('\n', begin) - begin);
  Child uav({"uav", {"/bin/sh", "-c", command}, folder_.File("uav.stderr")});
  EXPECT_EQ(muster.Wait(), 0) << muster.output();
  EXPECT_FALSE(uav.Poll()) << "it stays until it is stopped";
  EXPECT_FALSE(fs::exists(Out() + "/uav.stderr"));
  EXPECT_TRUE(Report()["log"]["complete"].get<bool>());
}

TEST_F(RunTest, MissionsSideBySideDoNotHearEachOther) {
  Muster one = Start({}, "one");
  Muster two = Start({"--seed", "2"}, "two");
  ASSERT_EQ(one.Wait(), 0) << one.output();
  ASSERT_EQ(two.Wait(), 0) << two.output();
  const Log log_one(Out("one") + "/mission.lcm");
  const Log log_two(Out("two") + "/mission.lcm");
  ASSERT_EQ(log_one.runs.size(), 1u);
  ASSERT_EQ(log_two.runs.size(), 1u);
  EXPECT_NE(*log_one.runs.begin(), *log_two.runs.begin());
}

TEST_F(RunTest, StockLogplayerPlaysTheLog) {
  Muster muster = Start({});
  ASSERT_EQ(muster.Wait(), 0) << muster.output();
  const std::string play = fmt::format("exec lcm-logplayer -v -s 1000 -l '{}' {}/mission.lcm",
                                       "udpm://239.255.76.67:7001?ttl=0", Out());
  Child player({"player", {"/bin/sh", "-c", play}, folder_.File("player")});
  ASSERT_TRUE(Eventually([&] { return player.Poll().has_value(); }));
  EXPECT_TRUE(player.Poll()->clean()) << player.Poll()->Text() << TextOf(folder_.File("player"));
  EXPECT_NE(TextOf(folder_.File("player")).find("MUSTER_CLOCK"), std::string::npos);
}

TEST_F(RunTest, CtrlCEndsItCleanly) {
  Muster muster = Start({"--rate", "300"});
  ASSERT_TRUE(UnderWay(muster)) << muster.output();
  muster.child().Signal(SIGINT);
  EXPECT_EQ(muster.Wait(), 130) << muster.output();
  const Log log(Out() + "/mission.lcm");
  EXPECT_EQ(log.missing, 0);
  EXPECT_EQ(log.garbage, 0);
  EXPECT_FALSE(log.end_announced);
  EXPECT_EQ(log.pids.size(), 7u);
  for (const auto& [name, pid] : log.pids) EXPECT_EQ(kill(pid, 0), -1) << name;
  const auto report = Report();
  EXPECT_FALSE(report["log"]["complete"].get<bool>());
  EXPECT_EQ(report["log"]["n_missing"], 1) << report["log"]["missing"];
  EXPECT_NE(muster.output().find(" min, all until then is there\n"), std::string::npos)
      << muster.output();
}

TEST_F(RunTest, CtrlCWhileProcessesStartIsNoneOfTheirProblems) {
  for (int i = 0; i < 8; ++i) {
    const std::string run = fmt::format("run-{}", i);
    Muster muster = Start({}, run);
    ASSERT_TRUE(Says(muster, "recording in")) << muster.output();
    muster.child().Signal(SIGINT);
    ASSERT_EQ(muster.Wait(), 130) << muster.output();
    EXPECT_EQ(muster.output().find("was killed"), std::string::npos) << muster.output();
  }
}

TEST_F(RunTest, NoProcessIsLeftWhenTheLauncherIsKilled) {
  // Orphans become ours, so that their ends can be seen exactly.
  ASSERT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 1), 0);
  Muster muster = Start({"--rate", "300"});
  ASSERT_TRUE(UnderWay(muster)) << muster.output();
  muster.child().Signal(SIGKILL);
  EXPECT_EQ(muster.Wait(), -1);
  int children = 0;
  const bool all_gone = Eventually([&] {
    int status = 0;
    pid_t pid = 0;
    while ((pid = waitpid(-1, &status, WNOHANG)) > 0) {
      ++children;
      EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    }
    return pid < 0;  // no child is left, whether it has ended or not
  });
  EXPECT_TRUE(all_gone);
  EXPECT_EQ(children, 6);  // world, three agent classes, scheduler, recorder
  EXPECT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 0), 0);
}

TEST_F(RunTest, ALostProcessEndsTheMissionWhereNoneIsStartedAgain) {
  Muster muster = Start({"--rate", "300", "--restarts", "0"});
  ASSERT_TRUE(UnderWay(muster)) << muster.output();
  const Log before(Out() + "/mission.lcm");
  ASSERT_EQ(before.pids.count("worker"), 1u);
  kill(before.pids.at("worker"), SIGKILL);
  EXPECT_EQ(muster.Wait(), 3);
  EXPECT_NE(muster.output().find("worker was killed by signal 9 (Killed)"), std::string::npos)
      << muster.output();
  const Log log(Out() + "/mission.lcm");
  EXPECT_EQ(log.garbage, 0);
  for (const auto& [name, pid] : log.pids) EXPECT_EQ(kill(pid, 0), -1) << name;
}

TEST_F(RunTest, ABadScenarioLeavesNothing) {
  Json scenario = Json::parse(TextOf(scenario_));
  scenario["uavs"][0]["speed_km_per_min"] = -1;
  std::ofstream(scenario_) << scenario;
  Muster muster = Start({});
  EXPECT_EQ(muster.Wait(), 2);
  EXPECT_NE(muster.output().find("uavs[0].speed_km_per_min"), std::string::npos) << muster.output();
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(RunTest, BadRequestsAreRefusedBeforeAnythingIsWritten) {
  const std::vector<std::vector<std::string>> requests = {
      {"--policy", "nonsense"}, {"--interval", "0.7"}, {"--processes", "uav=50"}};
  for (const auto& arguments : requests) {
    Muster muster = Start(arguments);
    EXPECT_EQ(muster.Wait(), 2) << arguments.front() << "\n" << muster.output();
    EXPECT_FALSE(fs::exists(Out())) << arguments.front();
  }
}

TEST_F(RunTest, WorldAndSchedulerMustBeCalledSo) {
  const fs::path programs = fs::path(MUSTER_PROGRAM).parent_path();
  for (const std::string program : {"muster-world", "muster-scheduler"}) {
    std::vector<std::string> argv = {(programs / program).string(), "--name", "mars"};
    if (program == "muster-world") argv.push_back(scenario_);
    Child child({program, argv, folder_.File("output")});
    ASSERT_TRUE(Eventually([&] { return child.Poll().has_value(); })) << program;
    EXPECT_TRUE(child.Poll()->usage_error()) << program;
    EXPECT_NE(TextOf(folder_.File("output")).find("--name: found 'mars', expected "),
              std::string::npos)
        << TextOf(folder_.File("output"));
  }
}

TEST_F(RunTest, NeverWritesOverAnotherRun) {
  fs::create_directory(Out());
  std::ofstream(Out() + "/report.json") << "mine";
  Muster muster = Start({});
  EXPECT_EQ(muster.Wait(), 2) << muster.output();
  EXPECT_EQ(TextOf(Out() + "/report.json"), "mine");
  EXPECT_FALSE(fs::exists(Out() + "/scenario.json"));
}

}  // namespace
}  // namespace muster::tools
