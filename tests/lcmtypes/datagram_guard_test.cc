#include "lcmtypes/bus/datagram_guard.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/bus/seal.h"
#include "lcmtypes/channels.h"
#include "tests/lcmtypes/datagrams.h"
#include "tests/lcmtypes/test_network.h"

namespace muster {
namespace {

/// A guarded socket on the loopback address, and one that sends to it.
class GuardedSocket {
 public:
  explicit GuardedSocket(GuardedChannels channels) : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in local{};
    local.sin_family = AF_INET;
    local.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof local;
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&local), size), 0);
    EXPECT_EQ(getsockname(fd_, reinterpret_cast<sockaddr*>(&local), &size), 0);
    port_ = ntohs(local.sin_port);
    sender_.emplace(port_, "127.0.0.1");
    EXPECT_EQ(GuardSocket(fd_, channels).value_or(""), "");
  }
  ~GuardedSocket() { close(fd_); }
  std::uint16_t port() const { return port_; }
  int fd() const { return fd_; }

  /// Whether it comes through; one that surely does is sent after it.
  bool Passes(const Datagram& datagram) {
    static const Datagram marker =
        DatagramsOf(channel::kLog, Datagram{'m', 'a', 'r', 'k', 'e', 'r'}).front();
    sender_->Send(datagram);
    sender_->Send(marker);
    const Datagram first = Take();
    if (first == marker) return false;
    EXPECT_EQ(first, datagram);
    EXPECT_EQ(Take(), marker);
    return true;
  }

 private:
  Datagram Take() {
    Datagram datagram(1 << 16);
    const ssize_t got = recv(fd_, datagram.data(), datagram.size(), 0);
    datagram.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    return datagram;
  }
  int fd_;
  std::uint16_t port_ = 0;
  std::optional<RawSender> sender_;
};

constexpr std::string_view kNamed("MUSTER_SCENARIO", 16);  // with its NUL

Datagram Bytes(std::string_view text) { return {text.begin(), text.end()}; }

class DatagramGuardTest : public ::testing::TestWithParam<GuardedChannels> {
 protected:
  void SetUp() override { MUSTER_NEEDS_MULTICAST(); }
};
INSTANTIATE_TEST_SUITE_P(Guards, DatagramGuardTest,
                         ::testing::Values(GuardedChannels::kOurs, GuardedChannels::kAny),
                         [](const auto& test) {
                           return test.param == GuardedChannels::kOurs ? "Ours" : "Any";
                         });

TEST_P(DatagramGuardTest, LetsMessagesOfEverySizePass) {
  GuardedSocket socket(GetParam());
  for (const Channel& row : kChannels) {
    EXPECT_TRUE(socket.Passes(DatagramsOf(row.name, Datagram(8)).front())) << row.name;
  }
  for (const char* name : {"LCM_SELF_TEST", kRoundTripChannel}) {
    EXPECT_TRUE(socket.Passes(DatagramsOf(name, Bytes("hello")).front())) << name;
  }
  for (std::size_t size = 0; size < 300; ++size) {
    ASSERT_TRUE(socket.Passes(DatagramsOf(channel::kScenario, Datagram(size, 'x')).front()));
  }
  // About where one datagram ends, and two, and three; and the largest, with its tag.
  constexpr std::size_t kLargest = (64 << 20) + kMostTagBytes;
  for (const std::size_t middle : {65'487u, 130'958u, 196'461u, 1'000'000u, 64u << 20}) {
    for (std::size_t size = middle - 40; size <= std::min<std::size_t>(middle + 40, kLargest);
         size += 4) {
      const auto datagrams = DatagramsOf(channel::kScenario, Datagram(size, 'x'));
      for (const std::size_t i : {std::size_t{0}, datagrams.size() / 2, datagrams.size() - 1}) {
        ASSERT_TRUE(socket.Passes(datagrams[i])) << size << " bytes, fragment " << i;
      }
      if (size > 64 << 19) size += 16;
    }
  }
}

TEST_P(DatagramGuardTest, DropsWhatIsCutShortOrHasNoChannel) {
  GuardedSocket socket(GetParam());
  const Datagram whole = DatagramsOf(channel::kClock, Datagram(10)).front();
  for (std::size_t size = 0; size < 8 + 13; ++size) {
    ASSERT_FALSE(socket.Passes({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}))
        << size;
  }
  EXPECT_TRUE(socket.Passes({whole.begin(), whole.begin() + 8 + 13}));
  const Datagram first = DatagramsOf(channel::kScenario, Datagram(100'000)).front();
  for (std::size_t size = 0; size < 20 + 16; ++size) {
    ASSERT_FALSE(socket.Passes({first.begin(), first.begin() + static_cast<std::ptrdiff_t>(size)}))
        << size;
  }
  EXPECT_FALSE(socket.Passes(Bytes("LC02----")));
  EXPECT_FALSE(socket.Passes(Bytes("LC04----MUSTER_CLOCK\0 and so on")));
  EXPECT_FALSE(socket.Passes(DatagramsOf("", Datagram(10)).front()));
  for (const char* name : {"CAM ERA", "CAMERA\x1b[2J", "CAMERA\x7f", "CAM\xc3\xa9RA"}) {
    EXPECT_FALSE(socket.Passes(DatagramsOf(name, Datagram(10)).front())) << name;
  }
  EXPECT_FALSE(socket.Passes(DatagramsOf(std::string(64, 'a'), Datagram(10)).front()));
  EXPECT_FALSE(socket.Passes(Fragment({1, 10, 0, 0, 1}, Bytes("MUSTER_SCENARIO"))));
  EXPECT_FALSE(socket.Passes(Fragment({1, 10, 0, 0, 1}, Datagram(11, 0))));
}

TEST_P(DatagramGuardTest, DropsFragmentsThatContradictThemselves) {
  GuardedSocket socket(GetParam());
  Datagram first = Bytes(kNamed);
  first.resize(first.size() + 100);
  const Datagram next(100);
  EXPECT_TRUE(socket.Passes(Fragment({1, 200, 0, 0, 2}, first)));
  EXPECT_TRUE(socket.Passes(Fragment({1, 200, 100, 1, 2}, next)));
  EXPECT_TRUE(socket.Passes(Fragment({1, 100, 0, 0, 1}, first)));
  const FragmentHeader bad[] = {
      {1, 200, 0xFFFFFF00, 1, 2},          // written out of bounds: offset + 100 is 0xFFFFFF64
      {1, 200, 0xFFFFFF9C, 1, 2},          // offset + 100 is 0
      {1, 200, 0xFFFFFFFF, 1, 2},          //
      {1, 200, 101, 1, 2},                 // one byte too far
      {1, 200, 99, 1, 2},                  // the last does not end the message
      {1, 200, 100, 2, 2},                 // number beyond the count
      {1, 200, 100, 1, 1},                 //
      {1, 200, 100, 65535, 2},             //
      {1, 200, 100, 1, 0},                 //
      {1, 0, 0, 1, 2},                     // empty
      {1, 99, 0, 1, 2},                    // smaller than its part
      {1, (64 << 20) + 17, 100, 1, 4000},  // larger than any of ours
      {1, 0xFFFFFFFF, 100, 1, 65535},      //
      {1, 1001, 100, 1, 10},               // ten of these make up less
  };
  for (const FragmentHeader& header : bad) {
    EXPECT_FALSE(socket.Passes(Fragment(header, next)))
        << header.size << " " << header.offset << " " << header.fragment << " " << header.fragments;
  }
  EXPECT_FALSE(socket.Passes(Fragment({1, 200, 1, 0, 2}, first))) << "the first is not at 0";
  EXPECT_FALSE(socket.Passes(Fragment({1, 99, 0, 0, 2}, first)));
  EXPECT_FALSE(socket.Passes(Fragment({1, 64 << 20, 0, 0, 1}, first))) << "64 MiB out of 136 bytes";
}

TEST(DatagramGuard, OnlyTheLoggersTakesOtherChannels) {
  MUSTER_NEEDS_MULTICAST();
  GuardedSocket ours(GuardedChannels::kOurs);
  GuardedSocket any(GuardedChannels::kAny);
  for (const char* name : {"CAMERA", "MUSTER_CLOC", "MUSTER_CLOCKS", "muster_clock", "M"}) {
    const Datagram datagram = DatagramsOf(name, Datagram(10)).front();
    EXPECT_FALSE(ours.Passes(datagram)) << name;
    EXPECT_TRUE(any.Passes(datagram)) << name;
  }
  EXPECT_TRUE(any.Passes(DatagramsOf(std::string(63, 'a'), Datagram(10)).front()));
}

TEST(DatagramGuard, KnowsEachNameOfTheTableFromThoseThatAreLikeIt) {
  MUSTER_NEEDS_MULTICAST();
  for (const GuardedChannels channels :
       {GuardedChannels::kOurs, GuardedChannels::kOfWorld, GuardedChannels::kOfAgents,
        GuardedChannels::kOfScheduler}) {
    GuardedSocket socket(channels);
    std::set<std::string> heard = {"LCM_SELF_TEST", kRoundTripChannel};
    for (const Channel& row : kChannels) {
      if (ComesThrough(row, channels)) heard.emplace(row.name);
    }
    for (const Channel& row : kChannels) {
      const std::string name(row.name);
      std::vector<std::string> names = {name, name + "S", name + "_CHANGES"};
      for (std::size_t size = 1; size < name.size(); ++size) names.push_back(name.substr(0, size));
      for (std::size_t i = 0; i < name.size(); ++i) {
        names.push_back(name);
        names.back()[i] ^= 1;
      }
      for (const std::string& each : names) {
        for (const std::size_t bytes : {0u, 1u, 2u, 3u, 4u, 100u, 70'000u}) {
          ASSERT_EQ(socket.Passes(DatagramsOf(each, Datagram(bytes, 'S')).front()),
                    heard.contains(each))
              << each << " and " << bytes << " bytes";
        }
      }
    }
  }
}

TEST(DatagramGuard, AProcessIsNotWokenByWhatItHasNoUseFor) {
  MUSTER_NEEDS_MULTICAST();
  GuardedSocket world(GuardedChannels::kOfWorld);
  GuardedSocket agents(GuardedChannels::kOfAgents);
  GuardedSocket scheduler(GuardedChannels::kOfScheduler);
  const auto passes = [](GuardedSocket& socket, std::string_view name) {
    return socket.Passes(DatagramsOf(std::string(name), Datagram(10)).front());
  };
  for (GuardedSocket* socket : {&world, &agents, &scheduler}) {
    for (const std::string_view name : {channel::kScenario, channel::kClock, channel::kFault,
                                        channel::kProcess, std::string_view(kRoundTripChannel)}) {
      EXPECT_TRUE(passes(*socket, name)) << name;
    }
    EXPECT_FALSE(passes(*socket, channel::kEvent));
  }
  EXPECT_TRUE(passes(world, channel::kUavs));
  EXPECT_TRUE(passes(world, channel::kUavChanges));
  EXPECT_FALSE(passes(agents, channel::kUavs));
  EXPECT_FALSE(passes(agents, channel::kUavChanges));
  EXPECT_TRUE(passes(scheduler, channel::kUavs));
  EXPECT_FALSE(passes(scheduler, channel::kUavChanges));
  EXPECT_FALSE(passes(scheduler, channel::kSchedule));
}

TEST(DatagramGuard, LetsExactlyTheSafeOnesPass) {
  MUSTER_NEEDS_MULTICAST();
  GuardedSocket socket(GuardedChannels::kAny);
  std::vector<Datagram> valid;
  for (const std::size_t size : {0u, 5u, 200u, 70'000u, 200'000u}) {
    for (Datagram& datagram : DatagramsOf(channel::kWorld, Datagram(size, 'x'))) {
      valid.push_back(std::move(datagram));
    }
  }
  for (std::uint16_t i = 1; i < 5; ++i) {
    valid.push_back(Fragment({1, 500, i * 100u, i, 5}, Datagram(100, 'y')));
  }
  Random random(1, Stream::kTest);
  int passed = 0;
  for (int i = 0; i < 20'000; ++i) {
    Datagram datagram = valid[random.Below(static_cast<std::uint32_t>(valid.size()))];
    Damage(&random, 40, &datagram);
    const bool safe = IsSafeForLcm(datagram);
    passed += safe;
    ASSERT_EQ(socket.Passes(datagram), safe) << "number " << i << ", " << datagram.size();
  }
  EXPECT_GT(passed, 2000);
  EXPECT_LT(passed, 18'000);
}

TEST(DatagramGuard, FindsTheSocketsOfAPort) {
  MUSTER_NEEDS_MULTICAST();
  GuardedSocket one(GuardedChannels::kAny);
  GuardedSocket two(GuardedChannels::kAny);
  EXPECT_EQ(SocketsOnPort(one.port()), std::vector<int>{one.fd()});
  EXPECT_EQ(SocketsOnPort(two.port()), std::vector<int>{two.fd()});
  EXPECT_FALSE(IsOnPort(0, one.port()));
  EXPECT_FALSE(IsOnPort(-1, one.port()));
}

/// Without the guard each of these ends the process (liblcm 1.3.1).
TEST(DatagramGuard, ABusOutlivesWhatEndsLcm) {
  MUSTER_NEEDS_MULTICAST();
  const auto port = static_cast<std::uint16_t>(20000 + getpid() % 4000 * 10 + 5);
  LcmBus bus(MissionUrl(port));
  RawSender raw(port);
  Datagram first = Bytes(kNamed);
  first.resize(40'000);
  for (std::uint32_t i = 0; i < 100; ++i) {
    raw.Send(Fragment({2 * i, 60'000, 0, 0, 2}, first));
    raw.Send(Fragment({2 * i, 60'000, 0xFFFFFF00, 1, 2}, Datagram(0x101 + 1000, 'x')));
    raw.Send(Fragment({2 * i + 1, 60'000, 0, 0, 2}, {}));
    raw.Send(Bytes("LC03"));
    raw.Send(Bytes("LC02----MUSTER_CLOCK"));
  }
  const Packet packet{std::string(channel::kClock), Datagram(100, 1)};
  bus.Publish(packet);
  std::vector<Packet> got;
  while (got.empty()) got = bus.Receive(10'000'000);
  EXPECT_EQ(got, std::vector<Packet>{packet});
}

}  // namespace
}  // namespace muster
