#include "tools/host/network_namespace.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/channels.h"
#include "tests/tools/host/child_process.h"

namespace muster::tools {
namespace {

#define MUSTER_NEEDS_NAMESPACES()                                       \
  if (const std::string problem = NamespaceProblem(); !problem.empty()) \
  GTEST_SKIP() << "no network namespaces here: " << problem

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
    // The outer mission: plain sockets, as threads of LCM would not survive the fork.
    if (EnterPrivateNetwork().kind != Network::Kind::kPrivate) return 1;
    sockaddr_in group{};
    group.sin_family = AF_INET;
    group.sin_port = htons(7667);
    inet_pton(AF_INET, "239.255.76.67", &group.sin_addr);
    const ip_mreq membership{group.sin_addr, {htonl(INADDR_ANY)}};
    const int outer = socket(AF_INET, SOCK_DGRAM, 0);
    if (bind(outer, reinterpret_cast<const sockaddr*>(&group), sizeof(group)) != 0 ||
        setsockopt(outer, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0) {
      return 2;
    }
    // LCM's short message: "LC02", sequence number, channel, NUL, data.
    const std::string datagram("LC02\0\0\0\0MUSTER_CLOCK\0outer", 26);

    const ChildResult inner = RunInChild([&] {
      if (EnterPrivateNetwork().kind != Network::Kind::kPrivate) return 1;
      LcmBus bus(MissionUrl(7667));
      // A socket that is open already stays in its network: this reaches the outer mission only.
      if (sendto(outer, datagram.data(), datagram.size(), 0,
                 reinterpret_cast<const sockaddr*>(&group), sizeof(group)) < 0) {
        return 2;
      }
      const Packet own{std::string(channel::kClock), {1}};
      bus.Publish(own);
      return bus.Receive(10'000'000) == std::vector<Packet>{own} ? 0 : 3;
    });
    if (inner.exit_code != 0) return 10 + inner.exit_code;
    std::array<char, 1000> heard;
    if (recv(outer, heard.data(), heard.size(), MSG_DONTWAIT) !=
        static_cast<ssize_t>(datagram.size())) {
      return 3;
    }
    return recv(outer, heard.data(), heard.size(), MSG_DONTWAIT) < 0 ? 0 : 4;
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
