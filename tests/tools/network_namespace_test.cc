#include "tools/host/network_namespace.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/channels.h"
#include "tests/tools/child_process.h"

namespace muster::tools {
namespace {

#define MUSTER_NEEDS_NAMESPACES()                                       \
  if (const std::string problem = NamespaceProblem(); !problem.empty()) \
  GTEST_SKIP() << "no network namespaces here: " << problem

constexpr int kRefused = 77;  ///< exit code of a child that could not make its surroundings

std::string NetworkId() { return std::filesystem::read_symlink("/proc/self/ns/net").string(); }

std::string NamespaceLimit() {
  std::string text;
  std::ifstream("/proc/sys/user/max_net_namespaces") >> text;
  return text;
}

/// One packet round the bus of this process's network.
bool Hears() {
  LcmBus bus(MissionUrl(7667));
  const Packet sent{std::string(channel::kClock), {1, 2, 3}};
  bus.Publish(sent);
  return bus.Receive(10'000'000) == std::vector<Packet>{sent};
}

TEST(NetworkNamespace, IsOursCarriesMulticastAndIsInherited) {
  MUSTER_NEEDS_NAMESPACES();
  const std::string outside = NetworkId();
  const ChildResult child = RunInChild([&] {
    const uid_t user = geteuid();
    const Network network = EnterPrivateNetwork();
    std::printf("%s\n", network.detail.c_str());
    if (network.kind != Network::Kind::kPrivate) return 1;
    if (NetworkId() == outside) return 2;
    if (geteuid() != user) return 3;
    const std::string inside = NetworkId();
    const ChildResult grandchild =
        RunInChild([&] { return NetworkId() == inside && Hears() ? 0 : 1; });
    if (grandchild.exit_code != 0) return 4;
    return Hears() ? 0 : 5;
  });
  EXPECT_EQ(child.exit_code, 0) << child.output;
  EXPECT_EQ(NetworkId(), outside) << "the trial stays in its child";
}

TEST(NetworkNamespace, TwoMissionsOnOnePortDoNotHearEachOther) {
  MUSTER_NEEDS_NAMESPACES();
  const ChildResult child = RunInChild([] {
    if (EnterPrivateNetwork().kind != Network::Kind::kPrivate) return 1;
    LcmBus outer(MissionUrl(7667));
    const Packet from_outer{std::string(channel::kClock), {1}};
    const Packet from_inner{std::string(channel::kClock), {2}};
    const ChildResult inner = RunInChild([&] {
      if (EnterPrivateNetwork().kind != Network::Kind::kPrivate) return 1;
      LcmBus bus(MissionUrl(7667));
      // A socket that is open already stays in its network: this reaches the outer mission only.
      outer.Publish(from_outer);
      bus.Publish(from_inner);
      return bus.Receive(10'000'000) == std::vector<Packet>{from_inner} ? 0 : 2;
    });
    if (inner.exit_code != 0) return 10 + inner.exit_code;
    return outer.Receive(10'000'000) == std::vector<Packet>{from_outer} ? 0 : 3;
  });
  EXPECT_EQ(child.exit_code, 0) << child.output;
}

TEST(NetworkNamespace, FallsBackToTheHostsMulticastWhereTheKernelRefuses) {
  MUSTER_NEEDS_NAMESPACES();
  const std::string limit = NamespaceLimit();
  const ChildResult child = RunInChild([] {
    if (!EnterRefusingNetwork(true)) return kRefused;
    const std::string before = NetworkId();
    const Network network = EnterPrivateNetwork();
    std::printf("%s\n", network.detail.c_str());
    if (network.kind != Network::Kind::kHost) return 1;
    if (NetworkId() != before) return 2;
    return Hears() ? 0 : 3;
  });
  if (child.exit_code == kRefused) GTEST_SKIP() << "cannot limit namespaces here";
  EXPECT_EQ(child.exit_code, 0) << child.output;
  EXPECT_EQ(child.output, "no private network (unshare: No space left on device)\n");
  EXPECT_EQ(NamespaceLimit(), limit) << "the host's limit must not change";
}

TEST(NetworkNamespace, SaysWhatToDoWhereThereIsNoMulticastEither) {
  MUSTER_NEEDS_NAMESPACES();
  const ChildResult child = RunInChild([] {
    if (!EnterRefusingNetwork(false)) return kRefused;
    const Network network = EnterPrivateNetwork();
    std::printf("%s\n", network.detail.c_str());
    return network.kind == Network::Kind::kNone ? 0 : 1;
  });
  if (child.exit_code == kRefused) GTEST_SKIP() << "cannot limit namespaces here";
  EXPECT_EQ(child.exit_code, 0) << child.output;
  EXPECT_EQ(child.output,
            "no private network (unshare: No space left on device), no multicast on this host "
            "(cannot join 239.255.76.67: No such device); run as root: ip link set lo up && ip "
            "route add 224.0.0.0/4 dev lo\n");
}

}  // namespace
}  // namespace muster::tools
