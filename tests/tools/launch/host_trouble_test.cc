// Whole missions on a host that takes things away: the terminal, the disk, room in files.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/units.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/host/child_process.h"
#include "tests/tools/launch/live_log.h"
#include "tests/tools/launch/muster_process.h"

namespace muster::tools {
namespace {

void Open(int fd, const std::string& file) {
  const int opened = open(file.c_str(), O_WRONLY | O_CREAT, 0666);
  dup2(opened, fd);
  close(opened);
}

class HostTrouble : public ::testing::Test {
 protected:
  void SetUp() override {
    MUSTER_NEEDS_MULTICAST();
    Run({"scenario", "--uavs", "2", "--workers", "2", "--vehicles", "1", "--tasks", "3",
         "--charging-points", "1", "--limit", "30", "-o", scenario_});
  }
  ChildResult Run(
      const std::vector<std::string>& arguments, const std::function<void()>& prepare = [] {}) {
    return RunInChild([&]() -> int {
      prepare();
      Exec(MUSTER_PROGRAM, arguments);
    });
  }
  std::string Out(const std::string& name) const { return folder_.File(name); }

  TemporaryFolder folder_;
  const std::string scenario_ = folder_.File("s.json");
};

TEST_F(HostTrouble, AMissionOutlivesItsTerminal) {
  const struct {
    const char* name;
    std::function<void()> prepare;
  } cases[] = {
      {"full", [] { Open(STDERR_FILENO, "/dev/full"); }},
      {"closed", [] { close(STDERR_FILENO); }},
      {"unread",
       [] {
         int ends[2];
         if (pipe(ends) != 0) _exit(97);
         dup2(ends[1], STDERR_FILENO);
         close(ends[0]);
         close(ends[1]);
         signal(SIGPIPE, SIG_DFL);
       }},
  };
  for (const auto& [name, prepare] : cases) {
    // At full speed so small a mission may be over before the launcher hears of its minute 10.
    const ChildResult result = Run(
        {"run", scenario_, "--rate", "900", "--out", Out(name), "--fault", "process_killed:uav@10"},
        prepare);
    EXPECT_EQ(result.exit_code, 0) << name << result.output;
    EXPECT_NE(result.output.find("complete"), std::string::npos) << name << result.output;
  }
  const ChildResult both = Run({"run", scenario_, "--out", Out("both")}, [] {
    close(STDOUT_FILENO);
    close(STDERR_FILENO);
  });
  EXPECT_EQ(both.exit_code, 3);
  CheckRun(Out("both"), folder_.File("both.output"));
  const ChildResult result = Run({"run", scenario_, "-q", "--out", Out("stdout")},
                                 [] { Open(STDOUT_FILENO, "/dev/full"); });
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(result.output, "muster: cannot write to stdout: No space left on device\n");
  EXPECT_TRUE(std::filesystem::exists(Out("stdout") + "/report.json"));
}

TEST_F(HostTrouble, WhatWasIgnoredStaysIgnored) {
  // As nohup does it, for a process that is this one's child.
  const ChildResult result = RunInChild([&]() -> int {
    signal(SIGHUP, SIG_IGN);
    const pid_t launcher = fork();
    if (launcher == 0) {
      Exec(MUSTER_PROGRAM, {"run", scenario_, "--rate", "900", "--quiet", "--out", Out("nohup")});
    }
    // Once the log is there its signals are set.
    Eventually([&] { return std::filesystem::exists(Out("nohup") + "/mission.lcm"); });
    kill(launcher, SIGHUP);
    int status = 0;
    waitpid(launcher, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 99;
  });
  EXPECT_EQ(result.exit_code, 0) << result.output;
  Muster muster(folder_, "hangup",
                {"run", scenario_, "--rate", "60", "--quiet", "--out", Out("hangup")});
  Eventually([&] { return std::filesystem::exists(Out("hangup") + "/mission.lcm"); });
  muster.child().Signal(SIGHUP);
  EXPECT_EQ(muster.Wait(), 130) << muster.output();
}

TEST_F(HostTrouble, AFullDiskIsSaidAndWaitedFor) {
  for (const bool freed : {true, false}) {
    const std::string disk = Out(freed ? "freed" : "full");
    const std::string run = disk + "/run", said = disk + ".said";
    std::filesystem::create_directory(disk);
    const ChildResult result = RunInChild([&]() -> int {
      const std::string uid = std::to_string(geteuid()), gid = std::to_string(getegid());
      if (unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return 98;
      std::ofstream("/proc/self/setgroups") << "deny";
      std::ofstream("/proc/self/uid_map") << "0 " + uid + " 1";
      std::ofstream("/proc/self/gid_map") << "0 " + gid + " 1";
      if (mount("none", disk.c_str(), "tmpfs", 0, "size=20m") != 0) return 98;
      std::ofstream(disk + "/taken") << std::string((19 << 20) + (768 << 10), 'x');
      const pid_t launcher = fork();
      if (launcher == 0) {
        Open(STDERR_FILENO, said);
        Exec(MUSTER_PROGRAM, {"run", MUSTER_SCENARIOS "/random_1.json", "--quiet", "--out", run});
      }
      const bool is_said = Eventually(
          [&] { return TextOf(said).find("disk of " + run + " is full") != std::string::npos; });
      if (freed) {
        std::filesystem::remove(disk + "/taken");
      } else {
        // What the recorder did not get may be enough for a report: nothing is left.
        std::ofstream(disk + "/rest") << std::string(1 << 20, 'x');
        kill(launcher, SIGTERM);
      }
      int status = 0;
      waitpid(launcher, &status, 0);
      if (!is_said) return 97;
      return WIFEXITED(status) ? WEXITSTATUS(status) : 99;
    });
    if (result.exit_code == 98) GTEST_SKIP() << "no mounts for this user";
    EXPECT_EQ(result.exit_code, freed ? 0 : 3) << result.output << TextOf(said);
    EXPECT_NE(result.output.find("tasks done"), std::string::npos) << result.output;
  }
}

TEST_F(HostTrouble, AFileThatMayNotGrowIsSaid) {
  const std::pair<const char*, const char*> loggers[] = {
      {"muster", "/mission.lcm.5: File too large"}, {"lcm", "File size limit exceeded"}};
  for (const auto& [logger, said] : loggers) {
    const ChildResult result =
        Run({"run", scenario_, "--quiet", "--out", Out(logger), "--logger", logger}, [] {
          const rlimit limit = {8192, 8192};
          setrlimit(RLIMIT_FSIZE, &limit);
        });
    EXPECT_EQ(result.exit_code, 3) << result.output;
    EXPECT_NE(result.output.find(said), std::string::npos) << result.output;
    EXPECT_NE(result.output.find("tasks done"), std::string::npos) << result.output;
  }
}

TEST_F(HostTrouble, TwentyOpenFilesSuffice) {
  const ChildResult result = Run({"run", scenario_, "--quiet", "--out", Out("few")}, [] {
    const rlimit limit = {20, 20};
    setrlimit(RLIMIT_NOFILE, &limit);
  });
  EXPECT_EQ(result.exit_code, 0) << result.output;
  CheckRun(Out("few"), folder_.File("few.output"));
  // Where a mission cannot begin it says why.
  const ChildResult none = Run({"run", scenario_, "--quiet", "--out", Out("none")}, [] {
    const rlimit limit = {10, 10};
    setrlimit(RLIMIT_NOFILE, &limit);
  });
  EXPECT_EQ(none.exit_code, 3) << none.output;
  EXPECT_NE(none.output.find("Too many open files"), std::string::npos) << none.output;
}

TEST_F(HostTrouble, AClockThatIsSetByADayChangesNothing) {
  const std::string library =
      fmt::format("/usr/lib/{}-linux-gnu/faketime/libfaketimeMT.so.1", MUSTER_MACHINE);
  if (!std::filesystem::exists(library)) GTEST_SKIP() << "needs the package faketime";
  std::string digest;
  for (const std::string by : {"+0", "+1d", "-1d"}) {
    const std::string file = folder_.File("clock"), out = Out("clock" + by);
    std::ofstream(file) << "+0\n";
    std::thread setting([&] {
      LiveLog log(out);
      Eventually([&] {
        log.Read();
        return log.tick() >= 20;  // of 60
      });
      std::ofstream(file) << by << "\n";
    });
    const ChildResult result =
        Run({"run", scenario_, "--rate", "900", "--quiet", "--out", out}, [&] {
          setenv("LD_PRELOAD", library.c_str(), 1);
          setenv("FAKETIME_TIMESTAMP_FILE", file.c_str(), 1);
          setenv("FAKETIME_NO_CACHE", "1", 1);
          setenv("FAKETIME_DONT_FAKE_MONOTONIC", "1", 1);
        });
    setting.join();
    ASSERT_EQ(result.exit_code, 0) << by << result.output;
    CheckRun(out, folder_.File("clock.output"));
    const auto report = nlohmann::json::parse(TextOf(out + "/report.json"));
    EXPECT_TRUE(report["log"]["complete"].get<bool>()) << by;
    EXPECT_GT(report["wall_s"].get<double>(), 1.5) << by;
    EXPECT_LT(report["wall_s"].get<double>(), 600) << by;
    // The clock was set, and the log has it.
    std::int64_t first_us = std::numeric_limits<std::int64_t>::max(), last_us = 0;
    EventLogReader reader(out + "/mission.lcm", EventLogReader::Tail::kFinal);
    while (const auto event = reader.Next()) {
      const auto header = DecodeHeader(event->packet);
      if (!header) continue;
      first_us = std::min(first_us, header->wall_us);
      last_us = std::max(last_us, header->wall_us);
    }
    EXPECT_EQ(last_us - first_us > 23 * 60 * kMinuteUs, by != "+0") << by;
    if (digest.empty()) digest = report["digest"];
    EXPECT_EQ(report["digest"], digest) << by;
  }
}

TEST_F(HostTrouble, AnyNameIsAFolder) {
  for (const std::string& name : {std::string("-z"), std::string("caf\xe9"), std::string("a b")}) {
    const ChildResult result = Run({"run", scenario_, "--quiet", "--out=" + name},
                                   [&] { std::filesystem::current_path(folder_.path()); });
    EXPECT_EQ(result.exit_code, 0) << name << result.output;
    EXPECT_TRUE(std::filesystem::exists(folder_.File(name) + "/report.json")) << name;
  }
  EXPECT_EQ(Run({"run", scenario_, "--rate", "1e-300"}).exit_code, 2);
}

}  // namespace
}  // namespace muster::tools
