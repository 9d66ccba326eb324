#include "lcmtypes/bus/udpm_receiver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "lcmtypes/channels.h"
#include "tests/lcmtypes/datagrams.h"

namespace muster {
namespace {

using Messages = std::vector<std::pair<std::string, Datagram>>;

/// An assembler and what it has handed out.
struct Assembled {
  void Take(const Datagram& datagram, std::uint64_t sender = 1) {
    assembler.Take(sender, datagram.data(), datagram.size(),
                   [&](std::string_view channel, const std::uint8_t* data, std::size_t size) {
                     messages.emplace_back(std::string(channel), Datagram(data, data + size));
                   });
  }
  UdpmAssembler assembler;
  Messages messages;
};

Datagram Bytes(std::size_t size, int salt = 0) {
  Datagram bytes(size);
  for (std::size_t i = 0; i < size; ++i) {
    bytes[i] = static_cast<std::uint8_t>(i * 31 + i / 251 + static_cast<std::size_t>(salt));
  }
  return bytes;
}

TEST(UdpmAssembler, PutsMessagesOfEverySizeTogether) {
  for (const std::size_t size : {0u, 1u, 1000u, 65'400u, 65'600u, 131'000u, 3'000'000u}) {
    Assembled assembled;
    for (const Datagram& datagram : DatagramsOf("MUSTER_CLOCK", Bytes(size))) {
      assembled.Take(datagram);
    }
    EXPECT_EQ(assembled.messages, (Messages{{"MUSTER_CLOCK", Bytes(size)}})) << size;
  }
}

TEST(UdpmAssembler, SendersAndDoublesDoNotMix) {
  const auto one = DatagramsOf("ONE", Bytes(200'000, 1), 7);
  const auto two = DatagramsOf("TWO", Bytes(200'000, 2), 7);
  ASSERT_EQ(one.size(), two.size());
  Assembled assembled;
  for (std::size_t i = 0; i < one.size(); ++i) {
    for (int times = 0; times < 2; ++times) {
      if (i + 1 < one.size() || times == 0) assembled.Take(one[i], 1);
      if (i + 1 < one.size() || times == 0) assembled.Take(two[i], 2);
    }
  }
  EXPECT_EQ(assembled.messages, (Messages{{"ONE", Bytes(200'000, 1)}, {"TWO", Bytes(200'000, 2)}}));
}

TEST(UdpmAssembler, FragmentsBehindTheFirstMayComeInAnyOrder) {
  auto datagrams = DatagramsOf("MUSTER_CLOCK", Bytes(500'000));
  ASSERT_GE(datagrams.size(), 5u);
  std::reverse(datagrams.begin() + 1, datagrams.end());
  Assembled assembled;
  for (const Datagram& datagram : datagrams) assembled.Take(datagram);
  EXPECT_EQ(assembled.messages, (Messages{{"MUSTER_CLOCK", Bytes(500'000)}}));
}

TEST(UdpmAssembler, ALostFragmentLosesItsMessageOnly) {
  const auto torn = DatagramsOf("MUSTER_CLOCK", Bytes(300'000), 1);
  const auto next = DatagramsOf("MUSTER_CLOCK", Bytes(300'000, 5), 2);
  for (std::size_t lost = 0; lost < torn.size(); ++lost) {
    Assembled assembled;
    for (std::size_t i = 0; i < torn.size(); ++i) {
      if (i != lost) assembled.Take(torn[i]);
    }
    EXPECT_TRUE(assembled.messages.empty());
    for (const Datagram& datagram : next) assembled.Take(datagram);
    EXPECT_EQ(assembled.messages, (Messages{{"MUSTER_CLOCK", Bytes(300'000, 5)}}));
  }
}

TEST(UdpmAssembler, FragmentsThatLieMakeNoMessage) {
  const Datagram first = {'C', 0, 1, 2, 3, 4};
  const std::vector<std::vector<Datagram>> cases = {
      // Beyond the message.
      {Fragment({1, 8, 0, 0, 2}, first), Fragment({1, 8, 0xFFFFFF00, 1, 2}, {5, 6, 7, 8})},
      {Fragment({1, 8, 0, 0, 2}, first), Fragment({1, 8, 5, 1, 2}, {5, 6, 7, 8})},
      // All fragments are there, and a hole.
      {Fragment({1, 8, 0, 0, 2}, first), Fragment({1, 8, 0, 1, 2}, {5, 6, 7})},
      {Fragment({1, 8, 0, 0, 2}, first), Fragment({1, 8, 4, 2, 2}, {5, 6, 7, 8})},
      // No name, or one without an end.
      {Fragment({1, 4, 0, 0, 1}, {0, 1, 2, 3, 4})},
      {Fragment({1, 4, 0, 0, 1}, {'C', 'C', 'C', 'C'})},
      // Too large, and nothing.
      {Fragment({1, 0xFFFFFFFF, 0, 0, 2}, first)},
      {Fragment({1, 0, 0, 0, 1}, {'C', 0})},
      {Fragment({1, 4, 0, 0, 0}, first)},
      // A middle one alone.
      {Fragment({1, 8, 4, 1, 2}, {5, 6, 7, 8})},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Assembled assembled;
    for (const Datagram& datagram : cases[i]) assembled.Take(datagram);
    EXPECT_TRUE(assembled.messages.empty()) << i;
  }
  Assembled assembled;
  assembled.Take(Fragment({1, 8, 0, 0, 2}, first));
  assembled.Take(Fragment({1, 8, 4, 1, 2}, {5, 6, 7, 8}));
  EXPECT_EQ(assembled.messages, (Messages{{"C", {1, 2, 3, 4, 5, 6, 7, 8}}}));
}

TEST(UdpmAssembler, DamageNeverMakesAMessageOfAnotherSize) {
  Random random(3, Stream::kTest);
  Assembled assembled;
  for (int i = 0; i < 20'000; ++i) {
    const std::size_t size = random.Below(4) == 0 ? random.Below(200'000) : random.Below(300);
    for (Datagram datagram :
         DatagramsOf("MUSTER_CLOCK", Bytes(size), static_cast<std::uint32_t>(i))) {
      if (random.Below(3) == 0) Damage(&random, 40, &datagram);
      assembled.Take(datagram, random.Below(100));
    }
    for (const auto& [channel, bytes] : assembled.messages) {
      EXPECT_FALSE(channel.empty());
      EXPECT_LE(channel.size(), 63u);
    }
    assembled.messages.clear();
  }
}

}  // namespace
}  // namespace muster
