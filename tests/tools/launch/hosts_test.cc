#include "tools/launch/hosts.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>

#include "base/check.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

std::string HostsError(const std::string& json) {
  try {
    CheckHosts(ParseHosts(json, "hosts.json"), "hosts.json", {"world", "uav", "scheduler"}, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string Hosts(const std::string& hosts) {
  return R"({"version": 1, "hosts": [)" + hosts + "]}";
}

TEST(Hosts, SaysWhatRunsWhere) {
  const HostList list = ParseHosts(Hosts(R"(
      {"name": "field", "ssh": "pilot@field", "folder": "/opt/muster", "processes": ["uav"]},
      {"name": "room", "netns": "room", "processes": ["world", "scheduler"]})"),
                                   "hosts.json");
  EXPECT_NE(list.lcm_url.find("ttl=1"), std::string::npos);
  EXPECT_EQ(list.Of("uav")->ssh, "pilot@field");
  EXPECT_EQ(list.Of("scheduler")->netns, "room");
  EXPECT_EQ(list.Of("worker"), nullptr);
  const ChildSpec spec = OnHost(*list.Of("world"), {"world", {"/bin/muster-world", "s"}, ""});
  EXPECT_EQ(spec.argv, (std::vector<std::string>{"/usr/bin/env", "ip", "netns", "exec", "room",
                                                 "/bin/muster-world", "s"}));
}

TEST(Hosts, ALinkMayHaveARate) {
  const auto with = [](const std::string& rate) {
    return Hosts(R"({"name": "a", "netns": "a", "processes": ["uav"], "mbit_s": )" + rate + "}");
  };
  EXPECT_EQ(ParseHosts(with("12.5"), "hosts.json").hosts[0].mbit_s, 12.5);
  for (const std::string rate : {"0", "-1", "\"fast\"", "1e999"}) {
    EXPECT_NE(HostsError(with(rate)).find("hosts.json: "), std::string::npos) << rate;
  }
  EXPECT_EQ(HostsError(with("0")),
            "hosts.json: hosts[0].mbit_s: found 0, expected a number above 0");
}

TEST(Hosts, NamesFileKeyValueAndWhatIsExpected) {
  EXPECT_EQ(HostsError(Hosts(R"({"name": "a", "netns": "a", "processes": ["uav"]})")), "");
  EXPECT_EQ(HostsError("{}"), "hosts.json: version: found no such key, expected 1");
  EXPECT_EQ(HostsError(R"({"version": 2, "hosts": []})"),
            "hosts.json: version: found 2, expected 1");
  EXPECT_EQ(HostsError(R"({"version": 1, "hosts": []})"),
            "hosts.json: hosts: found an array of 0, expected a list that is not empty");
  EXPECT_EQ(HostsError(Hosts(R"({"name": "a", "processes": ["uav"]})")),
            "hosts.json: hosts[0].ssh: found neither ssh nor netns, expected one of the two");
  EXPECT_EQ(
      HostsError(Hosts(R"({"name": "a", "ssh": "-oProxyCommand=x", "processes": ["uav"]})")),
      "hosts.json: hosts[0].ssh: found \"-oProxyCommand=x\", expected a text that does not begin "
      "with -");
  EXPECT_EQ(HostsError(Hosts(R"({"name": "a", "netns": "a", "processes": ["uavs"]})")),
            "hosts.json: host a: processes: found uavs, expected processes of the mission: world, "
            "uav, scheduler");
  EXPECT_EQ(HostsError(Hosts(R"({"name": "a", "netns": "a", "processes": ["uav"]},
                             {"name": "b", "netns": "b", "processes": ["uav"]})")),
            "hosts.json: host b: processes: found uav, expected a process on one host: it is on a, "
            "too");
  EXPECT_EQ(HostsError(R"({"version": 1, "lcm_url": "udpm://239.255.76.67:7667?ttl=0", "hosts": [
                        {"name": "a", "netns": "a", "processes": ["uav"]}]})"),
            "hosts.json: lcm_url (line 1, column 27): found udpm://239.255.76.67:7667?ttl=0, "
            "expected a URL with ttl=1 "
            "or more: ttl=0 leaves no host");
  EXPECT_EQ(HostsError(Hosts(R"({"name": "a", "netns": "a", "port": 1, "processes": ["uav"]})")),
            "hosts.json: hosts[0]: found the unknown key \"port\", expected only name, ssh, netns, "
            "folder, processes, mbit_s, standby");
  EXPECT_EQ(
      HostsError(Hosts(R"({"name": "a", "netns": "a", "standby": "b", "processes": ["uav"]})")),
      "hosts.json: host a: standby: found b, expected the name of another host, or here");
  EXPECT_EQ(
      HostsError(Hosts(R"({"name": "a", "netns": "a", "standby": "a", "processes": ["uav"]})")),
      "hosts.json: host a: standby: found a, expected the name of another host, or here");
}

TEST(Hosts, ThoseOfAHostThatIsGoneAreOnItsStandby) {
  HostList list = ParseHosts(
      Hosts(R"({"name": "a", "netns": "a", "standby": "b", "processes": ["world", "uav"]},
               {"name": "b", "netns": "b", "standby": "here", "processes": ["scheduler"]})"),
      "hosts.json");
  EXPECT_EQ(list.Of("world")->name, "a");
  list.MoveToStandby("a");
  EXPECT_EQ(list.Of("world")->name, "b");
  EXPECT_EQ(list.Of("scheduler")->name, "b");
  list.MoveToStandby("b");
  EXPECT_EQ(list.Of("world"), nullptr) << "where muster run runs";
  EXPECT_EQ(list.Of("uav"), nullptr);
}

/// A program named ssh that runs its last argument as sshd would, before the real one in PATH.
class SshTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string ssh = folder_.File("ssh");
    std::ofstream(ssh) << "#!/bin/sh\nfor last; do :; done\nexec sh -c \"$last\"\n";
    ASSERT_EQ(chmod(ssh.c_str(), 0700), 0);
    setenv("PATH", (folder_.path().string() + ":" + std::getenv("PATH")).c_str(), 1);
  }
  ChildSpec Remote(const std::vector<std::string>& argv) const {
    Host host;
    host.ssh = "somewhere";
    return OnHost(host, {"remote", argv, folder_.File("output")});
  }
  TemporaryFolder folder_;
};

TEST_F(SshTest, HandsOverEveryArgumentAndTheExitCode) {
  const std::vector<std::string> odd = {"a b", "it's", "\"q\"", "$HOME", "*", "\\", "", "x;y", "é"};
  std::vector<std::string> argv = {"/bin/sh", "-c", "printf '<%s>' \"$@\"; exit 7", "sh"};
  argv.insert(argv.end(), odd.begin(), odd.end());
  Child child(Remote(argv));
  ASSERT_TRUE(Eventually([&] { return child.Poll().has_value(); }));
  EXPECT_EQ(child.Poll()->Text(), "exited with code 7");
  std::string expected;
  for (const std::string& word : odd) expected += "<" + word + ">";
  EXPECT_EQ(TextOf(folder_.File("output")), expected);
}

TEST_F(SshTest, TheProgramIsToldToStopWhenSshEnds) {
  const std::string marker = folder_.File("stopped");
  {
    Child child(Remote({"/bin/sh", "-c",
                        "trap 'touch " + marker +
                            "; exit 0' TERM; echo up; while :; do sleep 0.05; "
                            "done"}));
    ASSERT_TRUE(Eventually([&] { return TextOf(folder_.File("output")) == "up\n"; }));
    EXPECT_FALSE(child.Poll());
  }  // killed, as when this process dies
  EXPECT_TRUE(Eventually([&] { return std::filesystem::exists(marker); }));
}

}  // namespace
}  // namespace muster::tools
