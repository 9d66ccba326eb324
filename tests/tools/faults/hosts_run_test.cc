// A mission over several hosts: network namespaces joined by a bridge, with packets of ttl 1.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"
#include "tools/host/child.h"
#include "tools/record/digest.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

/// Hosts on one cable each into a switch: namespaces of this test, gone when it ends.
class Lan {
 public:
  explicit Lan(const std::vector<std::string>& hosts) {
    hub_ = fmt::format("muster{}-hub", getpid());
    Add(hub_);
    Ip("-n {} link add br0 type bridge mcast_snooping 0", hub_);
    Ip("-n {} link set br0 up", hub_);
    for (std::size_t i = 0; i < hosts.size(); ++i) {
      const std::string host = Name(hosts[i]);
      Add(host);
      Ip("-n {} link add {} type veth peer name eth0 netns {}", hub_, hosts[i], host);
      Ip("-n {} link set {} master br0 up", hub_, hosts[i]);
      Ip("-n {} link set lo up", host);
      Ip("-n {} addr add 10.76.0.{}/24 dev eth0", host, i + 1);
      Ip("-n {} link set eth0 up", host);
      Ip("-n {} route add 224.0.0.0/4 dev eth0", host);
    }
  }
  ~Lan() {
    for (const std::string& name : namespaces_) Run("ip netns del " + name);
  }
  std::string Name(const std::string& host) const { return hub_ + "-" + host; }
  /// "": all is there.
  const std::string& problem() const { return problem_; }
  /// That much each way; a full queue loses what comes.
  void Limit(const std::string& host, int mbit_s) {
    const std::string queue = fmt::format("root tbf rate {}mbit burst 64kb latency 100ms", mbit_s);
    Tc("-n {} qdisc add dev {} {}", hub_, host, queue);
    Tc("-n {} qdisc add dev eth0 {}", Name(host), queue);
  }
  void Pull(const std::string& host) { Ip("-n {} link set {} down", hub_, host); }
  /// With all its processes: nothing can be started there any more.
  void Destroy(const std::string& host) {
    Run(fmt::format("ip netns pids {0} | xargs -r kill -9; ip netns del {0}", Name(host)));
  }
  void PutBack(const std::string& host) { Ip("-n {} link set {} up", hub_, host); }

 private:
  static bool Run(const std::string& command) {
    return std::system((command + " 2>/dev/null").c_str()) == 0;
  }
  void Add(const std::string& name) {
    Ip("netns add {}", name);
    namespaces_.push_back(name);
  }
  template <class... Args>
  void Ip(fmt::format_string<Args...> format, Args&&... args) {
    const std::string command = "ip " + fmt::format(format, std::forward<Args>(args)...);
    if (problem_.empty() && !Run(command)) problem_ = "needs root and iproute2: " + command;
  }

  template <class... Args>
  void Tc(fmt::format_string<Args...> format, Args&&... args) {
    const std::string command = "tc " + fmt::format(format, std::forward<Args>(args)...);
    if (problem_.empty() && !Run(command)) problem_ = "needs tc with tbf: " + command;
  }

  std::string hub_;
  std::vector<std::string> namespaces_;
  std::string problem_;
};

/// The last tick that the log has; -1: none yet.
std::int64_t LastTick(const std::string& log) {
  if (!std::filesystem::exists(log)) return -1;
  std::int64_t tick = -1;
  EventLogReader reader(log, EventLogReader::Tail::kMayGrow);
  while (const auto event = reader.Next()) {
    if (event->packet.channel != channel::kClock) continue;
    if (const auto clock = DecodeValid<muster::clock_t>(event->packet.bytes)) {
      tick = std::max(tick, clock->tick);
    }
  }
  return tick;
}

class HostsRunTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!lan_.problem().empty()) GTEST_SKIP() << lan_.problem();
    std::ofstream(folder_.File("scenario.json")) << json_;
    std::ofstream(folder_.File("hosts.json")) << Json{
        {"version", 1},
        {"hosts",
         {{{"name", "field"}, {"netns", lan_.Name("field")}, {"processes", {"uav", "worker"}}},
          {{"name", "road"}, {"netns", lan_.Name("road")}, {"processes", {"vehicle"}}},
          {{"name", "room"},
           {"netns", lan_.Name("room")},
           {"processes", {"world", "scheduler"}}}}}};
  }
  Child StartOn(const std::string& host, const std::vector<std::string>& arguments,
                const std::string& output) {
    std::vector<std::string> argv = {"/usr/bin/env",  "ip",          "netns", "exec",
                                     lan_.Name(host), MUSTER_PROGRAM};
    argv.insert(argv.end(), arguments.begin(), arguments.end());
    return Child({"muster", argv, folder_.File(output)});
  }
  Child Start(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "run",   "--hosts", folder_.File("hosts.json"), folder_.File("scenario.json"), "--policy",
        policy_, "--out",   folder_.File("run")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return StartOn("base", arguments, "output");
  }
  void ExpectTheUndisturbedMission(Child* muster, const std::string& run = "run",
                                   const std::string& output = "output") {
    ASSERT_TRUE(Eventually([&] { return muster->Poll().has_value(); }));
    EXPECT_TRUE(muster->Poll()->clean()) << TextOf(folder_.File(output));
    RunRecord expected;
    Simulate(json_, policy_, [&](const Packet& packet) { expected.Add(packet); });
    const Json report = Json::parse(TextOf(folder_.File(run + "/report.json")), nullptr, false);
    ASSERT_TRUE(report.is_object()) << TextOf(folder_.File(output));
    EXPECT_EQ(report["digest"], Digest(expected));
    EXPECT_TRUE(report["log"]["complete"].get<bool>());
    CheckRun(folder_.File(run), folder_.File(output));
  }

  Lan lan_{{"base", "field", "road", "room"}};
  TemporaryFolder folder_;
  std::string policy_ = "mpq";
  std::string json_ = ScenarioToJson(Generate(PresetByName("Random_1"), 1));
};

TEST_F(HostsRunTest, FourHostsMakeTheSameDecisionsAsOne) {
  Child muster = Start({});
  ExpectTheUndisturbedMission(&muster);
}

// Classes are dealt out over the hosts; all that is said passes each of the slow links.
TEST_F(HostsRunTest, SlowLinksHoldTheMissionUpAndItSaysWhatTheyCarry) {
  for (const char* host : {"field", "road"}) lan_.Limit(host, 20);
  if (!lan_.problem().empty()) GTEST_SKIP() << lan_.problem();
  std::ofstream(folder_.File("hosts.json"))
      << Json{{"version", 1},
              {"hosts",
               {{{"name", "field"},
                 {"netns", lan_.Name("field")},
                 {"mbit_s", 20},
                 {"processes", {"uav-1", "worker-1", "vehicle-1"}}},
                {{"name", "road"},
                 {"netns", lan_.Name("road")},
                 {"mbit_s", 20},
                 {"processes", {"uav-2", "worker-2", "vehicle-2"}}}}}};
  Child muster = Start({"--quiet", "--processes", "uav=2,worker=2,vehicle=2", "--fault",
                        "delay:*@0=5"});  // ms, as on a long way
  ExpectTheUndisturbedMission(&muster);
  const std::string said = TextOf(folder_.File("output"));
  for (const char* line :
       {"\nlink here      sent ", "\nlink field     sent ", "\nlink road      sent ",
        " % of its 20), busiest second ", "\nlimited by     "}) {
    EXPECT_NE(said.find(line), std::string::npos) << line << said;
  }
}

TEST_F(HostsRunTest, ACableMayBePulledAndPutBack) {
  Child muster = Start({"--rate", "3600"});
  const std::string log = folder_.File("run/mission.lcm");
  ASSERT_TRUE(Eventually([&] { return LastTick(log) > 50; })) << TextOf(folder_.File("output"));
  lan_.Pull("field");
  // The mission waits: nothing new for fifty looks at the log.
  std::int64_t tick = -1;
  int same = 0;
  ASSERT_TRUE(Eventually([&] {
    const std::int64_t now = LastTick(log);
    same = now == tick ? same + 1 : 0;
    tick = now;
    return same == 50;
  }));
  EXPECT_LT(tick, 350);
  EXPECT_FALSE(muster.Poll());
  lan_.PutBack("field");
  ExpectTheUndisturbedMission(&muster);
}

/// The world and two of three schedulers are on `room`, whose place `field` takes.
class StandbyRunTest : public HostsRunTest {
 protected:
  void SetUp() override {
    HostsRunTest::SetUp();
    std::ofstream(folder_.File("hosts.json")) << Json{
        {"version", 1},
        {"hosts",
         {{{"name", "field"}, {"netns", lan_.Name("field")}, {"processes", {"uav", "worker"}}},
          {{"name", "road"},
           {"netns", lan_.Name("road")},
           {"processes", {"vehicle", "scheduler-3"}}},
          {{"name", "room"},
           {"netns", lan_.Name("room")},
           {"standby", "field"},
           {"processes", {"world", "scheduler-1", "scheduler-2"}}}}}};
  }
  void ExpectTheMoveAndTheMission(Child* muster) {
    ExpectTheUndisturbedMission(muster);
    const std::string said = TextOf(folder_.File("output"));
    EXPECT_NE(said.find("host room is gone: world, scheduler-1, scheduler-2 run on field from now"),
              std::string::npos)
        << said;
  }
};

TEST_F(StandbyRunTest, AHostThatIsCutOffForGoodIsReplaced) {
  Child muster = Start({"--processes", "scheduler=3", "--rate", "1800"});
  const std::string log = folder_.File("run/mission.lcm");
  ASSERT_TRUE(Eventually([&] { return LastTick(log) > 50; })) << TextOf(folder_.File("output"));
  lan_.Pull("room");
  ExpectTheMoveAndTheMission(&muster);
}

TEST_F(StandbyRunTest, AHostThatStartsNothingAnyMoreIsReplaced) {
  Child muster = Start({"--processes", "scheduler=3", "--rate", "1800"});
  const std::string log = folder_.File("run/mission.lcm");
  ASSERT_TRUE(Eventually([&] { return LastTick(log) > 50; })) << TextOf(folder_.File("output"));
  lan_.Destroy("room");
  ExpectTheMoveAndTheMission(&muster);
}

TEST_F(HostsRunTest, WithoutASchedulerAHostOfAgentsIsReplaced) {
  policy_ = "neighbours:reach=10:loss=0.1";
  std::ofstream(folder_.File("hosts.json"))
      << Json{{"version", 1},
              {"hosts",
               {{{"name", "field"},
                 {"netns", lan_.Name("field")},
                 {"standby", "road"},
                 {"processes", {"uav", "worker"}}},
                {{"name", "road"}, {"netns", lan_.Name("road")}, {"processes", {"vehicle"}}}}}};
  Child muster = Start({"--rate", "1800"});
  const std::string log = folder_.File("run/mission.lcm");
  ASSERT_TRUE(Eventually([&] { return LastTick(log) > 50; })) << TextOf(folder_.File("output"));
  lan_.Destroy("field");
  ExpectTheUndisturbedMission(&muster);
  EXPECT_NE(TextOf(folder_.File("output")).find("host field is gone: uav, worker run on road"),
            std::string::npos)
      << TextOf(folder_.File("output"));
}

/// The launcher's host and its log are cut off for good. Its second log is on `room`, where another
/// launcher waits. When the cable is back, the first launcher sees that it has a successor.
TEST_F(HostsRunTest, WhenTheLaunchersHostIsGoneTheMissionGoesOnFromTheSecondLog) {
  const auto write_hosts = [&](const std::string& file, const std::vector<std::string>& room) {
    Json hosts = {
        {{"name", "field"}, {"netns", lan_.Name("field")}, {"processes", {"uav", "worker"}}},
        {{"name", "road"}, {"netns", lan_.Name("road")}, {"processes", {"vehicle"}}}};
    if (!room.empty()) {
      hosts.push_back({{"name", "room"}, {"netns", lan_.Name("room")}, {"processes", room}});
    }
    std::ofstream(folder_.File(file)) << Json{{"version", 1}, {"hosts", hosts}};
  };
  write_hosts("hosts.json", {"world", "recorder-2"});
  write_hosts("later.json", {});
  const std::string second = folder_.File("second");
  Child muster = Start({"--rate", "1800", "--second-log", second});
  ASSERT_TRUE(Eventually([&] { return LastTick(second + "/mission.lcm") > 50; }))
      << TextOf(folder_.File("output"));
  Child standby = StartOn(
      "room", {"resume", second, "--when-gone", "--hosts", folder_.File("later.json")}, "standby");
  lan_.Pull("base");
  muster.Signal(SIGSTOP);  // over ssh it could start nothing elsewhere, and here it could
  ASSERT_TRUE(Eventually([&] { return LastTick(second + "/mission.lcm.1") > 0 || standby.Poll(); }))
      << TextOf(folder_.File("standby"));
  lan_.PutBack("base");
  muster.Signal(SIGCONT);
  ExpectTheUndisturbedMission(&standby, "second", "standby");
  ASSERT_TRUE(Eventually([&] { return muster.Poll().has_value(); }));
  EXPECT_FALSE(muster.Poll()->clean());
  EXPECT_NE(TextOf(folder_.File("output")).find("has gone on with another launcher: this one ends"),
            std::string::npos)
      << TextOf(folder_.File("output"));
}

// A stand-in for ssh runs the commands here.
TEST_F(HostsRunTest, TheSecondLogIsPreparedOverSsh) {
  const std::string ssh = folder_.File("ssh");
  std::ofstream(ssh) << "#!/bin/sh\nfor last; do :; done\nexec sh -c \"$last\"\n";
  std::filesystem::permissions(ssh, std::filesystem::perms::owner_all);
  setenv("PATH", fmt::format("{}:{}", folder_.path().string(), getenv("PATH")).c_str(), 1);
  std::ofstream(folder_.File("hosts.json"))
      << Json{{"version", 1},
              {"hosts", {{{"name", "room"}, {"ssh", "ops@room"}, {"processes", {"recorder-2"}}}}}};
  const std::string second = folder_.File("the second log");
  Child muster = Start({"--rate", "3600", "--second-log", second});
  ExpectTheUndisturbedMission(&muster);
  for (const std::string file : {"/manifest.json", "/seal.key"}) {
    EXPECT_EQ(TextOf(second + file), TextOf(folder_.File("run") + file)) << file;
  }
  CheckRun(second, folder_.File("second"));
}

/// OpenSSH's server on the host `field`, and `ssh field` of this process's children.
class SshRunTest : public HostsRunTest {
 protected:
  static constexpr const char* kServer = "/usr/sbin/sshd";

  void SetUp() override {
    HostsRunTest::SetUp();
    if (IsSkipped()) return;
    if (access(kServer, X_OK) != 0) GTEST_SKIP() << "needs openssh-server";
    const std::string at = folder_.path().string();
    for (const char* const key : {"host_key", "user_key"}) {
      const std::string make = fmt::format("ssh-keygen -q -t ed25519 -N '' -f {}/{}", at, key);
      ASSERT_EQ(std::system(make.c_str()), 0);
    }
    std::ofstream(at + "/sshd_config")
        << "Port 2222\nListenAddress 10.76.0.2\nUsePAM no\nPermitRootLogin yes\nStrictModes no\n"
        << fmt::format("HostKey {0}/host_key\nAuthorizedKeysFile {0}/user_key.pub\n", at)
        << fmt::format("PidFile {}/sshd.pid\n", at);
    std::ofstream(at + "/ssh_config")
        << "Host field\nHostName 10.76.0.2\nPort 2222\nStrictHostKeyChecking no\nLogLevel ERROR\n"
        << fmt::format("IdentityFile {0}/user_key\nUserKnownHostsFile {0}/known\n", at);
    std::ofstream(at + "/ssh") << fmt::format(
        "#!/bin/sh\nexec /usr/bin/ssh -F {}/ssh_config \"$@\"\n", at);
    std::filesystem::permissions(at + "/ssh", std::filesystem::perms::owner_all);
    setenv("PATH", fmt::format("{}:{}", at, getenv("PATH")).c_str(), 1);
    std::filesystem::create_directories("/run/sshd");  // where the server parts with its rights
    server_.emplace(ChildSpec{"sshd",
                              {"/usr/bin/env", "ip", "netns", "exec", lan_.Name("field"), kServer,
                               "-D", "-e", "-f", at + "/sshd_config"},
                              folder_.File("sshd.output")});
    ASSERT_TRUE(Eventually([&] {
      return TextOf(folder_.File("sshd.output")).find("listening") != std::string::npos ||
             server_->Poll();
    }));
    ASSERT_FALSE(server_->Poll()) << TextOf(folder_.File("sshd.output"));
  }
  void PutOnField(const std::vector<std::string>& processes) {
    std::ofstream(folder_.File("hosts.json")) << Json{
        {"version", 1},
        {"hosts",
         {{{"name", "field"}, {"ssh", "field"}, {"standby", "here"}, {"processes", processes}}}}};
  }
  std::optional<Child> server_;
};

TEST_F(SshRunTest, ProcessesThatAreKilledComeBackAndBothLogsAreWhole) {
  PutOnField({"uav", "scheduler", "recorder-2"});
  const std::string second = folder_.File("second");
  Child muster = Start({"--rate", "1800", "--second-log", second, "--fault",
                        "process_killed:uav@40", "--fault", "process_killed:recorder-2@80"});
  ExpectTheUndisturbedMission(&muster);
  CheckRun(second, folder_.File("second.checked"));
}

TEST_F(SshRunTest, AHostThatDiesForGoodIsReplaced) {
  PutOnField({"uav", "scheduler"});
  Child muster = Start({"--rate", "900", "--seal", "per-process"});
  const std::string log = folder_.File("run/mission.lcm");
  ASSERT_TRUE(Eventually([&] { return LastTick(log) > 50; })) << TextOf(folder_.File("output"));
  lan_.Destroy("field");
  ExpectTheUndisturbedMission(&muster);
  EXPECT_NE(TextOf(folder_.File("output")).find("host field is gone: "), std::string::npos)
      << TextOf(folder_.File("output"));
}

TEST_F(HostsRunTest, AStoppedMissionIsNotTakenOver) {
  std::ofstream(folder_.File("hosts.json")) << Json{
      {"version", 1},
      {"hosts",
       {{{"name", "room"}, {"netns", lan_.Name("room")}, {"processes", {"world", "recorder-2"}}}}}};
  const std::string second = folder_.File("second");
  Child muster = Start({"--rate", "1800", "--second-log", second});
  ASSERT_TRUE(Eventually([&] { return LastTick(second + "/mission.lcm") > 20; }))
      << TextOf(folder_.File("output"));
  Child standby = StartOn("room", {"resume", second, "--when-gone"}, "standby");
  muster.Signal(SIGINT);
  ASSERT_TRUE(Eventually([&] { return standby.Poll().has_value(); }));
  EXPECT_TRUE(standby.Poll()->clean()) << TextOf(folder_.File("standby"));
  EXPECT_NE(TextOf(folder_.File("standby")).find("this mission was stopped"), std::string::npos)
      << TextOf(folder_.File("standby"));
}

}  // namespace
}  // namespace muster::tools
