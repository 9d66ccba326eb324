#include "lcmtypes/bus/seal.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <memory>
#include <tuple>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/lossy_bus.h"
#include "lcmtypes/channels.h"
#include "tests/lcmtypes/queue_bus.h"
#include "tests/lcmtypes/sample_messages.h"
#include "tests/temporary_folder.h"

namespace muster {
namespace {

constexpr const char* kDigits = "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f";

Seal SealOf(std::int64_t run) { return Seal(SealKey::Parse(kDigits, "here").Of(run, "here")); }

std::string Hex(const Tag& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

/// One packet of each channel of the table.
std::vector<Packet> Samples() {
  std::vector<Packet> packets;
  const auto add = [&](const auto& message, std::string_view type) {
    for (const Channel& row : kChannels) {
      if (row.type == type) packets.push_back({std::string(row.name), Encode(message)});
    }
  };
  std::apply([&](const auto&... message) { (add(message, message.getTypeName()), ...); },
             SampleMessages());
  return packets;
}

// Python: key = bytes(range(32)); run = blake2b(b"muster run 7", key=key, digest_size=32).digest()
// blake2b(b"MUSTER_CLOCK\0\1\2\3", key=run, digest_size=16)
TEST(Seal, IsThatOfPythonsHashlib) {
  const SealKey run = SealKey::Parse(kDigits, "here").Of(7, "here");
  EXPECT_EQ(run.Text(), "3c39f224fcdfdf978172f2451b93411929841f27f95449c7cbbcf4980b336e7a 7\n");
  EXPECT_EQ(Hex(Seal(run).TagOf({"MUSTER_CLOCK", {1, 2, 3}})), "08c4b46fb46585ff71b70aad8252038b");
  const SealKey other = SealKey::Parse(std::string(kDigits) + " 7", "here").Of(7, "here");
  EXPECT_EQ(Hex(Seal(other).TagOf({"MUSTER_CLOCK", {}})), "5075e5592dfc2e5570142c7fd0bf7462");
}

TEST(Seal, TakesWhatItHasClosed) {
  const Seal seal = SealOf(7);
  for (const Packet& packet : Samples()) {
    Packet closed = seal.Closed(packet);
    EXPECT_EQ(closed.bytes.size(), packet.bytes.size() + kTagBytes);
    EXPECT_TRUE(seal.Open(&closed)) << packet.channel;
    EXPECT_EQ(closed, packet);
  }
}

TEST(Seal, RefusesEveryOtherByte) {
  const Seal seal = SealOf(7);
  const Packet closed = seal.Closed({"MUSTER_CLOCK", {1, 2, 3, 4, 5}});
  for (std::size_t i = 0; i < closed.bytes.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      Packet changed = closed;
      changed.bytes[i] = static_cast<std::uint8_t>(changed.bytes[i] ^ (1 << bit));
      const Packet before = changed;
      EXPECT_FALSE(seal.Open(&changed)) << i << " " << bit;
      EXPECT_EQ(changed, before);
    }
  }
  for (std::size_t size = 0; size < closed.bytes.size(); ++size) {
    Packet cut = closed;
    cut.bytes.resize(size);
    EXPECT_FALSE(seal.Open(&cut)) << size;
  }
}

TEST(Seal, RefusesAnotherChannelRunAndKey) {
  const Packet packet{"MUSTER_UAVS", {1, 2, 3}};
  Packet closed = SealOf(7).Closed(packet);
  Packet elsewhere = closed;
  elsewhere.channel = "MUSTER_WORKERS";
  EXPECT_FALSE(SealOf(7).Open(&elsewhere));
  // The name and the message are no one text.
  EXPECT_FALSE(SealOf(7).Holds({"MUSTER_UAV", {'S', 0, 1, 2, 3}}, SealOf(7).TagOf(packet)));
  EXPECT_FALSE(SealOf(8).Open(&closed));
  EXPECT_FALSE(Seal(SealKey::Fresh(7)).Open(&closed));
  EXPECT_FALSE(Seal(SealKey::Fresh(7)).Open(&closed));
  EXPECT_TRUE(SealOf(7).Open(&closed));
}

TEST(Seal, DecodersReadPastTheTag) {
  const Seal seal = SealOf(7);
  const auto check = [&](const auto& message) {
    using Message = std::decay_t<decltype(message)>;
    const Packet closed = seal.Closed({"MUSTER_CLOCK", Encode(message)});
    Message decoded;
    const int size = static_cast<int>(closed.bytes.size());
    EXPECT_EQ(decoded.decode(closed.bytes.data(), 0, size), size - static_cast<int>(kTagBytes));
    EXPECT_EQ(Encode(decoded), Encode(message));
    EXPECT_FALSE(Decode<Message>(closed.bytes)) << "ours takes nothing behind";
  };
  std::apply([&](const auto&... message) { (check(message), ...); }, SampleMessages());
}

TEST(Seal, TheTagIsFoundWithoutTheKey) {
  const Seal seal = SealOf(7);
  for (const Packet& packet : Samples()) {
    Packet closed = seal.Closed(packet);
    const Packet on_the_wire = closed;
    const Tag tag = CutTag(&closed);
    EXPECT_EQ(tag, seal.TagOf(packet)) << packet.channel;
    EXPECT_EQ(closed, packet);
    EXPECT_EQ(WithTag(closed, tag), on_the_wire);
    EXPECT_TRUE(CutTag(&closed).empty());
    EXPECT_EQ(closed, packet);
  }
}

TEST(SealKey, SaysWhatIsWrongAndNotWhatItIs) {
  for (const std::string& text :
       {std::string(), std::string("00"), std::string(kDigits) + "0", std::string(kDigits, 63),
        std::string(kDigits) + " x", std::string(kDigits) + " 1 2", std::string(63, '0') + "g"}) {
    try {
      SealKey::Parse(text, "mission.key");
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()),
                "mission.key: key: found another text, expected 64 hexadecimal digits, and the run "
                "id where it is of one run");
    }
  }
  const SealKey key = SealKey::Parse(std::string(kDigits) + " -3\r\n", "mission.key");
  EXPECT_EQ(key.run_id, -3);
  EXPECT_EQ(SealKey::Parse(key.Text(), "").Of(-3, "").bytes, key.bytes);
  EXPECT_THROW(static_cast<void>(key.Of(4, "mission.key")), InputError);
  EXPECT_NE(SealKey::Fresh(1).bytes, SealKey::Fresh(1).bytes);
}

TEST(SealKey, IsNotReadWhereOthersCouldReadIt) {
  const TemporaryFolder folder;
  const std::string file = folder.File("mission.key");
  std::ofstream(file) << kDigits << "\n";
  for (const mode_t mode : {0640u, 0604u, 0644u}) {
    ASSERT_EQ(chmod(file.c_str(), mode), 0);
    EXPECT_THROW(SealKey::Load(file), InputError) << mode;
  }
  ASSERT_EQ(chmod(file.c_str(), 0600), 0);
  EXPECT_EQ(SealKey::Load(file).bytes, SealKey::Parse(kDigits, "").bytes);
  EXPECT_THROW(SealKey::Load(folder.File("absent")), InputError);
}

class SealedBus : public ::testing::Test {
 protected:
  SealedBus() { bus_.SetSeal(seal_); }
  testing::QueueBus* const queue_ = new testing::QueueBus;  // the bus's own
  std::int64_t now_us_ = 0;
  LossyBus bus_{std::unique_ptr<Bus>(queue_), 1, "uav", [this] { return ++now_us_; }};
  const Seal seal_ = SealOf(7);
};

TEST_F(SealedBus, SendsTagsAndTakesNothingWithoutThem) {
  const std::vector<Packet> packets = Samples();
  for (const Packet& packet : packets) bus_.Publish(packet);
  ASSERT_EQ(queue_->sent.size(), packets.size());
  for (const Packet& packet : queue_->sent) {
    queue_->arriving.push_back(packet);
    Packet bare = packet;
    CutTag(&bare);
    queue_->arriving.push_back(bare);
    queue_->arriving.push_back(SealOf(8).Closed(bare));
  }
  EXPECT_EQ(bus_.Receive(0), packets);
  EXPECT_EQ(bus_.refused(), 2 * static_cast<std::int64_t>(packets.size()));
  EXPECT_EQ(bus_.newest_refused().channel, packets.back().channel);
}

TEST_F(SealedBus, WhatTheNetworkDamagesIsRefused) {
  const Packet packet = Samples().front();
  bus_.SetFaults({.corrupt = 1});
  for (int i = 0; i < 100; ++i) queue_->arriving.push_back(seal_.Closed(packet));
  EXPECT_TRUE(bus_.Receive(0).empty());
  EXPECT_EQ(bus_.refused(), 100);
  EXPECT_EQ(bus_.counters().corrupted, 100);
}

TEST_F(SealedBus, WhoIsCutOffIsKnownByName) {
  const Packet packet = Samples().front();
  bus_.SetFaults({.unheard = {DecodeHeader(packet)->sender}});
  queue_->arriving.push_back(seal_.Closed(packet));
  EXPECT_TRUE(bus_.Receive(0).empty());
  EXPECT_EQ(bus_.counters().unheard, 1);
}

}  // namespace
}  // namespace muster
