#include "lcmtypes/bus/lossy_bus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/channels.h"
#include "tests/lcmtypes/queue_bus.h"

namespace muster {
namespace {

Packet Numbered(int number) {
  return {std::string(channel::kClock),
          {static_cast<std::uint8_t>(number >> 8), static_cast<std::uint8_t>(number), 0xAA, 0x55}};
}
int NumberOf(const Packet& packet) { return packet.bytes[0] << 8 | packet.bytes[1]; }

/// A lossy bus over one in our hands, and a clock that stands still unless told.
struct Line {
  explicit Line(const PacketFaults& faults, std::uint64_t seed = 1, std::string_view name = "uav")
      : queue(new testing::QueueBus),
        lossy(std::unique_ptr<Bus>(queue), seed, name, [this] { return now_us; }) {
    lossy.SetFaults(faults);
  }

  /// Sends packets 0 to count - 1, `burst` at a time, and returns the numbers that arrive.
  std::vector<int> Pass(int count, int burst = 1) {
    std::vector<int> numbers;
    const auto take = [&] {
      for (const Packet& packet : lossy.Receive(0)) numbers.push_back(NumberOf(packet));
    };
    for (int i = 0; i < count; ++i) {
      queue->arriving.push_back(Numbered(i));
      if ((i + 1) % burst == 0) take();
    }
    take();
    return numbers;
  }

  std::int64_t now_us = 0;
  testing::QueueBus* queue;  ///< owned by lossy
  LossyBus lossy;
};

std::vector<int> Range(int count) {
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) numbers.push_back(i);
  return numbers;
}

TEST(LossyBus, OrdersAboutFaultsPassWhateverTheyOrder) {
  Line line({.loss = 1, .duplication = 1, .reorder = 1, .corrupt = 1, .delay_us = 1000});
  const Packet order{std::string(channel::kFault), {1, 2, 3}};
  line.queue->arriving.push_back(order);
  line.queue->arriving.push_back(Numbered(1));
  EXPECT_EQ(line.lossy.Receive(0), std::vector<Packet>{order});
  line.lossy.SetFaults({.partition = true});
  line.queue->arriving.push_back(order);
  EXPECT_TRUE(line.lossy.Receive(0).empty());
}

TEST(LossyBus, WithoutFaultsChangesNothing) {
  Line line({});
  EXPECT_EQ(line.Pass(1000, 7), Range(1000));
}

TEST(LossyBus, LosesItsShare) {
  Line line({.loss = 0.2});
  const auto got = static_cast<int>(line.Pass(10000).size());
  EXPECT_NEAR(got, 8000, 5 * 40);  // five standard deviations
  EXPECT_EQ(line.lossy.counters().lost, 10000 - got);
  EXPECT_TRUE(Line({.loss = 1}).Pass(1000).empty());
}

TEST(LossyBus, TheVictimsDependOnSeedNameAndOrderOfArrivalOnly) {
  const PacketFaults faults{.loss = 0.3, .duplication = 0.2, .reorder = 0.2, .corrupt = 0.3};
  const auto pass = [&](std::uint64_t seed, std::string_view name) {
    return Line(faults, seed, name).Pass(500, 500);
  };
  EXPECT_EQ(pass(1, "uav"), pass(1, "uav"));
  EXPECT_NE(pass(1, "uav"), pass(2, "uav"));
  EXPECT_NE(pass(1, "uav"), pass(1, "worker"));
  // How arrivals fall into batches changes no victim.
  const PacketFaults loss{.loss = 0.3, .duplication = 0.2};
  EXPECT_EQ(Line(loss).Pass(500, 500), Line(loss).Pass(500, 1));
}

TEST(LossyBus, RaisingOneShareKeepsTheOthersVictims) {
  const std::vector<int> plain = Line({.loss = 0.3}).Pass(500);
  std::vector<int> with_doubles = Line({.loss = 0.3, .duplication = 0.5}).Pass(500);
  EXPECT_GT(with_doubles.size(), plain.size());
  with_doubles.erase(std::unique(with_doubles.begin(), with_doubles.end()), with_doubles.end());
  EXPECT_EQ(with_doubles, plain);
}

TEST(LossyBus, DuplicatesItsShare) {
  Line line({.duplication = 0.25});
  const auto got = static_cast<int>(line.Pass(10000).size());
  EXPECT_NEAR(got, 12500, 5 * 44);
  EXPECT_EQ(line.lossy.counters().duplicated, got - 10000);
}

TEST(LossyBus, CorruptionFlipsOneBitInTheBytesAndKeepsTheChannel) {
  Line line({.corrupt = 1});
  for (int i = 0; i < 200; ++i) {
    const Packet sent = Numbered(i);
    line.queue->arriving.push_back(sent);
    const std::vector<Packet> got = line.lossy.Receive(0);
    ASSERT_EQ(got.size(), 1u);
    EXPECT_EQ(got[0].channel, sent.channel);
    ASSERT_EQ(got[0].bytes.size(), sent.bytes.size());
    int flipped = 0;
    for (std::size_t k = 0; k < sent.bytes.size(); ++k) {
      flipped += std::popcount(static_cast<unsigned>(got[0].bytes[k] ^ sent.bytes[k]));
    }
    EXPECT_EQ(flipped, 1);
  }
  // A packet without bytes has nothing to flip.
  line.queue->arriving.push_back({std::string(channel::kClock), {}});
  EXPECT_EQ(line.lossy.Receive(0).size(), 1u);
  EXPECT_EQ(line.lossy.counters().corrupted, 200);
}

TEST(LossyBus, AReorderedPacketArrivesBehindTheNextAndNoneIsLost) {
  Line line({.reorder = 0.3});
  const std::vector<int> got = line.Pass(1000, 1000);
  EXPECT_NE(got, Range(1000));
  EXPECT_GT(line.lossy.counters().reordered, 200);
  std::vector<int> sorted = got;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, Range(1000));
}

TEST(LossyBus, AReorderedPacketThatNothingFollowsArrivesAnyway) {
  Line line({.reorder = 1});
  line.queue->arriving.push_back(Numbered(7));
  std::vector<Packet> got = line.lossy.Receive(0);
  if (got.empty()) got = line.lossy.Receive(0);
  EXPECT_EQ(got, std::vector<Packet>{Numbered(7)});
}

TEST(LossyBus, DelaysByItsClockAndKeepsTheOrder) {
  Line line({.delay_us = 1000});
  line.queue->arriving.push_back(Numbered(0));
  line.queue->arriving.push_back(Numbered(1));
  EXPECT_TRUE(line.lossy.Receive(0).empty());
  line.now_us = 500;
  line.queue->arriving.push_back(Numbered(2));
  EXPECT_TRUE(line.lossy.Receive(0).empty());
  line.now_us = 1000;
  EXPECT_EQ(line.lossy.Receive(0), (std::vector<Packet>{Numbered(0), Numbered(1)}));
  line.now_us = 1499;
  EXPECT_TRUE(line.lossy.Receive(0).empty());
  line.now_us = 1500;
  EXPECT_EQ(line.lossy.Receive(0), std::vector<Packet>{Numbered(2)});
}

TEST(LossyBus, JitterReordersAndLosesNothing) {
  Line line({.delay_us = 10, .jitter_us = 1000});
  std::vector<int> got;
  for (int i = 0; i < 500; ++i) {
    line.queue->arriving.push_back(Numbered(i));
    for (const Packet& packet : line.lossy.Receive(0)) got.push_back(NumberOf(packet));
    line.now_us += 10;
  }
  line.now_us += 1010;
  for (const Packet& packet : line.lossy.Receive(0)) got.push_back(NumberOf(packet));
  EXPECT_NE(got, Range(500));
  std::sort(got.begin(), got.end());
  EXPECT_EQ(got, Range(500));
}

TEST(LossyBus, APartitionIsDeafAndMuteUntilItEnds) {
  Line line({.partition = true});
  EXPECT_TRUE(line.Pass(10).empty());
  line.lossy.Publish(Numbered(1));
  line.lossy.Publish(Numbered(2));
  EXPECT_TRUE(line.queue->sent.empty());
  line.lossy.SetFaults({});
  line.lossy.Publish(Numbered(3));
  EXPECT_EQ(line.queue->sent, std::vector<Packet>{Numbered(3)});
  line.queue->arriving = line.queue->sent;
  EXPECT_EQ(line.lossy.Receive(0), std::vector<Packet>{Numbered(3)});
}

/// A bus whose Receive takes time, as told: what it hands out and how long it waits first.
class ScriptedBus : public Bus {
 public:
  struct Step {
    std::int64_t takes_us;  ///< -1: the whole timeout
    std::vector<Packet> packets;
  };
  ScriptedBus(std::int64_t* now_us, std::deque<Step> steps)
      : now_us_(now_us), steps_(std::move(steps)) {}
  void Publish(const Packet&) override {}
  std::vector<Packet> Receive(std::int64_t timeout_us) override {
    if (steps_.empty()) {
      *now_us_ += timeout_us;
      return {};
    }
    const Step step = steps_.front();
    steps_.pop_front();
    *now_us_ += step.takes_us < 0 ? timeout_us : step.takes_us;
    return step.packets;
  }

 private:
  std::int64_t* now_us_;
  std::deque<Step> steps_;
};

TEST(LossyBus, WaitsOnWhenAllThatCameWasLost) {
  std::int64_t now_us = 0;
  LossyBus bus(
      std::make_unique<ScriptedBus>(
          &now_us, std::deque<ScriptedBus::Step>{{100, {Numbered(0)}}, {100, {Numbered(1)}}}),
      1, "uav", [&] { return now_us; });
  bus.SetFaults({.loss = 1});
  EXPECT_TRUE(bus.Receive(1000).empty());
  EXPECT_EQ(now_us, 1000);
}

TEST(LossyBus, WakesForADelayedPacket) {
  std::int64_t now_us = 0;
  LossyBus bus(
      std::make_unique<ScriptedBus>(&now_us, std::deque<ScriptedBus::Step>{{100, {Numbered(0)}}}),
      1, "uav", [&] { return now_us; });
  bus.SetFaults({.delay_us = 300});
  EXPECT_EQ(bus.Receive(1000), std::vector<Packet>{Numbered(0)});
  EXPECT_EQ(now_us, 400);
}

TEST(LossyBus, ReturnsAtOnceWhenASignalEndsTheWait) {
  std::int64_t now_us = 0;
  LossyBus bus(std::make_unique<ScriptedBus>(&now_us, std::deque<ScriptedBus::Step>{{250, {}}}), 1,
               "uav", [&] { return now_us; });
  bus.SetFaults({.loss = 0.5});
  EXPECT_TRUE(bus.Receive(1000).empty());
  EXPECT_EQ(now_us, 250);
}

TEST(LossyBusDeathTest, RefusesSharesThatAreNone) {
  Line line({});
  EXPECT_DEATH(line.lossy.SetFaults({.loss = 1.5}), "loss 1.5");
  EXPECT_DEATH(line.lossy.SetFaults({.delay_us = -1}), "delay -1");
}

}  // namespace
}  // namespace muster
