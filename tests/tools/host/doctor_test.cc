// Through the real binary, in networks that the tests make.

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "tests/tools/host/child_process.h"
#include "tools/host/network_namespace.h"

namespace muster::tools {
namespace {

int RunDoctor(const std::vector<std::string>& arguments = {}) {
  std::vector<std::string> all{"doctor"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  Exec(MUSTER_PROGRAM, all);
}

TEST(Doctor, ExitsWithFourExactlyWhenACheckFailed) {
  const ChildResult result = RunInChild([] { return RunDoctor(); });
  EXPECT_EQ(result.exit_code, Contains(result.output, " fail ") ? 4 : 0) << result.output;
  for (const char* name : {"private network", "host multicast", "port 7667", "receive buffer",
                           "datagram guard", "LCM 1.", "lcm-logger", "lcm-logplayer", "lcm-gen"}) {
    EXPECT_TRUE(Contains(result.output, std::string("\n") + name)) << name << "\n" << result.output;
  }
  if (NamespaceProblem().empty()) {
    EXPECT_TRUE(Contains(result.output, "private network  ok")) << result.output;
    EXPECT_TRUE(Contains(result.output, "ok     200 messages there")) << result.output;
    EXPECT_TRUE(Contains(result.output, "datagram guard   ok     on our sockets and on"))
        << result.output;
  }
}

TEST(Doctor, NeedsNoLcmLogger) {
  const ChildResult result = RunInChild([] {
    setenv("PATH", "/nonexistent", 1);
    return RunDoctor();
  });
  EXPECT_EQ(result.exit_code, Contains(result.output, " fail ") ? 4 : 0) << result.output;
  EXPECT_TRUE(Contains(result.output, "lcm-logger       warn   not in PATH; 'muster run --logger"))
      << result.output;
  EXPECT_TRUE(Contains(result.output, "lcm-logplayer    warn   not in PATH")) << result.output;
  EXPECT_TRUE(Contains(result.output, "-> Debian has it in the package liblcm-bin"));
}

TEST(Doctor, WarnsWhereMissionsMustShareTheHostsNetwork) {
  const ChildResult result =
      RunInChild([] { return EnterRefusingNetwork(true) ? RunDoctor() : kRefused; });
  if (result.exit_code == kRefused) GTEST_SKIP() << "cannot limit namespaces here";
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(Contains(result.output, "private network  warn   refused (unshare: No space left"))
      << result.output;
  EXPECT_TRUE(Contains(result.output, "host multicast   ok")) << result.output;
  EXPECT_TRUE(Contains(result.output, "ok     200 messages there")) << result.output;
}

TEST(Doctor, FailsWithoutAnyMulticast) {
  const ChildResult result =
      RunInChild([] { return EnterRefusingNetwork(false) ? RunDoctor() : kRefused; });
  if (result.exit_code == kRefused) GTEST_SKIP() << "cannot limit namespaces here";
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_TRUE(Contains(result.output, "host multicast   fail   cannot join 239.255.76.67"))
      << result.output;
  EXPECT_TRUE(Contains(result.output, "-> run as root: ip link set lo up")) << result.output;
  EXPECT_TRUE(Contains(result.output, "fail   no multicast on this host")) << result.output;
}

TEST(Doctor, NamesAFreePortWhenItsOwnIsTaken) {
  if (!NamespaceProblem().empty()) GTEST_SKIP() << "no network namespaces here";
  const ChildResult result = RunInChild([] {
    EnterPrivateNetwork();  // stands for the host's network: what listens there is ours
    for (const int port : {7667, 7668}) {
      const int fd = socket(AF_INET, SOCK_DGRAM, 0);
      sockaddr_in local{};
      local.sin_family = AF_INET;
      local.sin_port = htons(static_cast<std::uint16_t>(port));
      if (bind(fd, reinterpret_cast<const sockaddr*>(&local), sizeof(local)) != 0) return 1;
    }
    return RunDoctor();
  });
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(Contains(result.output, "port 7667        warn   in use on the host"))
      << result.output;
  EXPECT_TRUE(Contains(result.output, "udpm://239.255.76.67:7669?")) << result.output;
}

TEST(Doctor, WarnsOfASmallReceiveBuffer) {
  const ChildResult result = RunInChild([] {
    return RunDoctor({"--lcm-url", "udpm://?recv_buf_size=1073741824"});
  });
  EXPECT_TRUE(Contains(result.output, "receive buffer   warn")) << result.output;
  EXPECT_TRUE(Contains(result.output, " of 1024 MiB on LCM's") ||
              Contains(result.output, "so LCM reads for them with"))
      << result.output;
  EXPECT_TRUE(Contains(result.output, "sysctl -w net.core.rmem_max=1073741824")) << result.output;
}

TEST(Doctor, SaysWhatSocketsGetWhereTheKernelAllowsNoMore) {
  std::int64_t most = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> most;
  // Root of a user namespace of its own may not exceed the limit.
  const ChildResult result =
      RunInChild([] { return EnterRefusingNetwork(true) ? RunDoctor() : kRefused; });
  if (result.exit_code == kRefused || most == 0) GTEST_SKIP() << "cannot limit namespaces here";
  EXPECT_FALSE(Contains(result.output, "this user may exceed")) << result.output;
  const bool is_small = most < 8 << 20;
  EXPECT_EQ(Contains(result.output, "for ours, so LCM reads for them with"), is_small)
      << result.output;
  EXPECT_EQ(Contains(result.output, "sysctl -w net.core.rmem_max=33554432"), is_small)
      << result.output;
}

TEST(Doctor, RefusesAUrlThatIsNone) {
  const ChildResult result = RunInChild([] { return RunDoctor({"--lcm-url", "tcp://here"}); });
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.output,
            "muster: LCM URL: --lcm-url: found 'tcp://here', expected udpm://ADDRESS:PORT?ttl=0\n");
}

}  // namespace
}  // namespace muster::tools
