#include "lcmtypes/bus/lcm_bus.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sched.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "base/check.h"
#include "lcmtypes/bus/datagram_guard.h"
#include "lcmtypes/bus/multicast.h"
#include "lcmtypes/channels.h"
#include "tests/lcmtypes/test_network.h"

namespace muster {
namespace {

constexpr std::int64_t kSecond = 1'000'000;

/// Ports of this process, should it have to share the host's network with others.
std::uint16_t Port(int offset) {
  return static_cast<std::uint16_t>(20000 + getpid() % 4000 * 10 + offset);
}

Packet MakePacket(std::string_view channel, std::size_t size, std::uint8_t salt = 0) {
  Packet packet{std::string(channel), std::vector<std::uint8_t>(size)};
  for (std::size_t i = 0; i < size; ++i) {
    packet.bytes[i] = static_cast<std::uint8_t>(i * 31 + i / 251 + salt);
  }
  return packet;
}

/// Takes until `count` packets are there or ten seconds have passed.
std::vector<Packet> Take(Bus& bus, std::size_t count) {
  std::vector<Packet> all;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (all.size() < count && std::chrono::steady_clock::now() < deadline) {
    for (Packet& packet : bus.Receive(kSecond)) all.push_back(std::move(packet));
  }
  return all;
}

TEST(ComesBack, WhenAFirstPacketIsLostWhileOthersTalk) {
  int sent = 0, heard = 0;
  const auto send = [&] { ++sent; };
  // Something of others' is always there.
  const auto wait = [&](std::int64_t) { return ++heard > 10 && sent == 3; };
  EXPECT_TRUE(ComesBack(send, wait, std::chrono::seconds(60)));
  EXPECT_EQ(sent, 3);
}

TEST(ComesBack, NotWhenAllIsLost) {
  int sent = 0;
  EXPECT_FALSE(ComesBack([&] { ++sent; }, [](std::int64_t) { return false; },
                         std::chrono::milliseconds(100)));
  EXPECT_GT(sent, 0);
}

/// Whoever reads the socket.
class LcmBusTest : public ::testing::TestWithParam<LcmBus::Reader> {};
INSTANTIATE_TEST_SUITE_P(Readers, LcmBusTest,
                         ::testing::Values(LcmBus::Reader::kOwnIfItCan, LcmBus::Reader::kLcm),
                         [](const auto& reader) {
                           return reader.param == LcmBus::Reader::kLcm ? "Lcm" : "Own";
                         });

TEST_P(LcmBusTest, CarriesPacketsInOrderToOthersAndToItself) {
  MUSTER_NEEDS_MULTICAST();
  LcmBus one(MissionUrl(Port(0)), 0, {}, GetParam());
  LcmBus two(MissionUrl(Port(0)), 0, {}, GetParam());
  std::vector<Packet> sent;
  for (std::uint8_t i = 0; i < 100; ++i) sent.push_back(MakePacket(channel::kClock, 100u + i, i));
  for (const Packet& packet : sent) one.Publish(packet);
  EXPECT_EQ(Take(two, sent.size()), sent);
  EXPECT_EQ(Take(one, sent.size()), sent);
  EXPECT_EQ(one.counters().published, 100);
  EXPECT_EQ(two.counters().received, 100);
}

TEST_P(LcmBusTest, QueuesMoreThanLcmsDefaultOfThirty) {
  MUSTER_NEEDS_MULTICAST();
  LcmBus bus(MissionUrl(Port(0)), 0, {}, GetParam());
  for (int i = 0; i < 1000; ++i) bus.Publish(MakePacket(channel::kClock, 50));
  EXPECT_EQ(Take(bus, 1000).size(), 1000u);
}

TEST_P(LcmBusTest, CarriesMessagesLargerThanADatagram) {
  MUSTER_NEEDS_MULTICAST();
  LcmBus one(MissionUrl(Port(0)), 0, {}, GetParam());
  LcmBus two(MissionUrl(Port(0)), 0, {}, GetParam());
  for (const std::size_t size : {65'000u, 66'000u, 300'000u, 1'000'000u}) {
    const Packet big = MakePacket(channel::kScenario, size);
    one.Publish(big);
    const std::vector<Packet> got = Take(two, 1);
    ASSERT_EQ(got.size(), 1u) << size << " bytes";
    EXPECT_EQ(got[0], big) << size << " bytes";
  }
}

TEST_P(LcmBusTest, HandsOutOnlyWhatTheProcessHears) {
  MUSTER_NEEDS_MULTICAST();
  LcmBus one(MissionUrl(Port(0)), 0, {}, GetParam());
  LcmBus agents(MissionUrl(Port(0)), 0, {}, GetParam(), GuardedChannels::kOfAgents);
  one.Publish(MakePacket(channel::kUavs, 200));
  one.Publish(MakePacket(channel::kUavs, 300'000));
  const Packet clock = MakePacket(channel::kClock, 100);
  one.Publish(clock);
  EXPECT_EQ(Take(agents, 1), std::vector<Packet>{clock});
}

TEST_P(LcmBusTest, MissionsOnTwoPortsDoNotHearEachOther) {
  MUSTER_NEEDS_MULTICAST();
  LcmBus first_a(MissionUrl(Port(0)), 0, {}, GetParam());
  LcmBus first_b(MissionUrl(Port(0)), 0, {}, GetParam());
  LcmBus second_a(MissionUrl(Port(1)), 0, {}, GetParam());
  LcmBus second_b(MissionUrl(Port(1)), 0, {}, GetParam());
  const Packet first = MakePacket(channel::kWorld, 200, 1);
  const Packet second = MakePacket(channel::kWorld, 200, 2);
  first_a.Publish(first);
  second_a.Publish(second);
  first_a.Publish(first);
  second_a.Publish(second);
  EXPECT_EQ(Take(first_b, 2), (std::vector<Packet>{first, first}));
  EXPECT_EQ(Take(second_b, 2), (std::vector<Packet>{second, second}));
  EXPECT_TRUE(first_b.Receive(0).empty());
  EXPECT_TRUE(second_b.Receive(0).empty());
}

TEST_P(LcmBusTest, DropsAndCountsWhatTheChannelTableForbids) {
  MUSTER_NEEDS_MULTICAST();
  LcmBus bus(MissionUrl(Port(0)), 0, {}, GetParam());
  // A stranger that speaks LCM: one datagram of its short message format.
  const auto send_raw = [](const std::string& name, std::size_t size) {
    std::string datagram{'L', 'C', '0', '2', 0, 0, 0, 0};
    datagram += name;
    datagram += '\0';
    datagram += std::string(size, 'x');
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in group{};
    group.sin_family = AF_INET;
    group.sin_port = htons(Port(0));
    inet_pton(AF_INET, "239.255.76.67", &group.sin_addr);
    EXPECT_EQ(sendto(fd, datagram.data(), datagram.size(), 0,
                     reinterpret_cast<const sockaddr*>(&group), sizeof(group)),
              static_cast<ssize_t>(datagram.size()));
    close(fd);
  };
  send_raw("MUSTER_NOBODY_KNOWS", 10);
  send_raw("OTHER", 10);
  send_raw("MUSTER_CLOCK", 1025);
  send_raw("MUSTER_CLOCK", 1024);
  const std::vector<Packet> got = Take(bus, 1);
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].bytes.size(), 1024u);
  EXPECT_EQ(bus.counters().rejected, 1);  // other channels do not even reach LCM
}

TEST(LcmBus, RefusesToPublishWhatReceiversWouldDrop) {
  MUSTER_NEEDS_MULTICAST();
  LcmBus bus(MissionUrl(Port(0)));
  EXPECT_THROW(bus.Publish(MakePacket("MUSTER_NOBODY_KNOWS", 10)), SystemError);
  EXPECT_THROW(bus.Publish(MakePacket(channel::kClock, 1025)), SystemError);
}

TEST_P(LcmBusTest, ReceiveWaitsNoLongerThanItsTimeout) {
  MUSTER_NEEDS_MULTICAST();
  LcmBus bus(MissionUrl(Port(0)), 0, {}, GetParam());
  EXPECT_TRUE(bus.Receive(0).empty());
  EXPECT_TRUE(bus.Receive(1000).empty());
  EXPECT_TRUE(bus.Receive(-5).empty());
}

TEST_P(LcmBusTest, ASignalEndsTheWait) {
  MUSTER_NEEDS_MULTICAST();
  struct sigaction action {};
  action.sa_handler = [](int) {};
  ASSERT_EQ(sigaction(SIGUSR1, &action, nullptr), 0);
  LcmBus bus(MissionUrl(Port(0)), 0, {}, GetParam());
  // To the process, not to a thread: LCM's own thread must not be the one that takes it. The
  // sender repeats it, as the first may come before the wait.
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child == 0) {
    for (;;) {
      kill(parent, SIGUSR1);
      usleep(1000);
    }
  }
  const auto before = std::chrono::steady_clock::now();
  EXPECT_TRUE(bus.Receive(100 * kSecond).empty());
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(100));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

TEST_P(LcmBusTest, ATapHearsEveryChannel) {
  MUSTER_NEEDS_MULTICAST();
  std::vector<Packet> tapped;
  int bursts = 0;
  LcmTap tap;
  tap.heard = {std::string(channel::kClock)};
  tap.on_message = [&](const Packet& packet) {
    if (packet.channel != kRoundTripChannel) tapped.push_back(packet);
  };
  tap.on_burst = [&] { ++bursts; };
  LcmBus bus(MissionUrl(Port(0)), 0, tap, GetParam());
  LcmBus other(MissionUrl(Port(0)));
  const std::vector<Packet> sent = {MakePacket(channel::kClock, 100),
                                    MakePacket(channel::kScenario, 300'000),
                                    MakePacket(channel::kFault, 100)};
  for (const Packet& packet : sent) other.Publish(packet);
  std::vector<Packet> heard;
  for (int i = 0; i < 1000 && tapped.size() < sent.size(); ++i) {
    for (Packet& packet : bus.Receive(10'000)) heard.push_back(std::move(packet));
  }
  EXPECT_EQ(tapped, sent);
  EXPECT_EQ(heard, std::vector<Packet>{sent[0]});
  EXPECT_GT(bursts, 0);
}

TEST(LcmBus, SaysWhatToDoWithoutMulticast) {
  // In a child: an empty network namespace has neither lo nor routes.
  EXPECT_EXIT(
      {
        if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
          std::fprintf(stderr, "ip route add 224.0.0.0/4 (not tried: unshare is forbidden)\n");
          _exit(3);
        }
        try {
          LcmBus bus(MissionUrl(7667));
        } catch (const SystemError& error) {
          std::fprintf(stderr, "%s\n", error.what());
          _exit(3);
        }
        _exit(0);
      },
      ::testing::ExitedWithCode(3), "ip route add 224.0.0.0/4");
}

TEST(MulticastUrl, TakesLcmsForms) {
  const MulticastUrl full = ParseMulticastUrl("udpm://239.1.2.3:7000?ttl=1&recv_buf_size=4096");
  EXPECT_EQ(full.address, "239.1.2.3");
  EXPECT_EQ(full.port, 7000);
  EXPECT_EQ(full.ttl, 1);
  EXPECT_EQ(full.recv_buf_size, 4096);
  EXPECT_EQ(ParseMulticastUrl("udpm://").port, 7667);
  EXPECT_EQ(ParseMulticastUrl("udpm://:8000").address, "239.255.76.67");
  const MulticastUrl ours = ParseMulticastUrl(MissionUrl(7700));
  EXPECT_EQ(ours.port, 7700);
  EXPECT_EQ(ours.ttl, 0);
  EXPECT_EQ(ours.recv_buf_size, 2097152);
}

TEST(MulticastUrl, NamesWhatIsWrong) {
  for (const char* url :
       {"", "tcpq://localhost:7700", "memq://", "udpm://10.0.0.1:7667", "udpm://host:7667",
        "udpm://239.255.76.67:0", "udpm://239.255.76.67:65536", "udpm://239.255.76.67:x",
        "udpm://239.255.76.67:7667?ttl=-1", "udpm://239.255.76.67:7667?ttl=256",
        "udpm://239.255.76.67:7667?speed=2", "udpm://239.255.76.67:7667?recv_buf_size=0"}) {
    EXPECT_THROW(ParseMulticastUrl(url), InputError) << url;
  }
  try {
    ParseMulticastUrl("udpm://:99999");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "LCM URL: --lcm-url: found 'udpm://:99999', expected a port from 1 to 65535");
  }
}

}  // namespace
}  // namespace muster
