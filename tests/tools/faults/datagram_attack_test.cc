// Raw datagrams at a mission's port: whoever listens there outlives them, and the mission decides
// as without them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/random.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "tests/base/sanitized.h"
#include "tests/lcmtypes/datagrams.h"
#include "tests/lcmtypes/sample_messages.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

/// A mission in this test's network, so that others can speak at its port, with each of the two
/// loggers.
class DatagramAttackTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    MUSTER_NEEDS_MULTICAST();
    std::ofstream(scenario_) << ScenarioToJson(Generate(PresetByName("Random_1"), 1));
  }
  Muster Start(const std::string& rate, bool sealed = false) const {
    std::vector<std::string> arguments = {
        "run",      scenario_,   "--policy",        "mpq",   "--rate",
        rate,       "--lcm-url", MissionUrl(port_), "--out", folder_.File("run"),
        "--logger", GetParam()};
    if (sealed) arguments.push_back("--seal");
    return Muster(folder_, "run", arguments);
  }
  static bool UnderWay(Muster* muster) {
    return Eventually([&] {
      return muster->output().find("tick ") != std::string::npos || muster->child().Poll();
    });
  }
  /// Ended by itself, nobody died, and everything is as without the attack.
  void ExpectUnharmed(Muster* muster, std::chrono::minutes longest) const {
    ASSERT_EQ(muster->Wait(longest), 0) << muster->output();
    EXPECT_EQ(muster->output().find("signal"), std::string::npos) << muster->output();
    EXPECT_EQ(muster->output().find("starting it again"), std::string::npos) << muster->output();
    Muster simulated(folder_, "simulated",
                     {"simulate", scenario_, "--policy", "mpq", "--out", folder_.File("virtual")});
    ASSERT_EQ(simulated.Wait(), 0) << simulated.output();
    EXPECT_EQ(Report("run")["digest"], Report("virtual")["digest"]);
  }
  Json Report(const std::string& name) const {
    return Json::parse(TextOf(folder_.File(name) + "/report.json"), nullptr, false);
  }
  /// Until the mission is over, at most so many datagrams.
  void AttackAtRandom(std::uint64_t seed, std::int64_t datagrams, bool sealed,
                      const std::string& rate, std::chrono::minutes longest);

  const std::uint16_t port_ = static_cast<std::uint16_t>(20000 + getpid() % 4000 * 10 + 7);
  TemporaryFolder folder_;
  std::string scenario_ = folder_.File("scenario.json");
};

INSTANTIATE_TEST_SUITE_P(Loggers, DatagramAttackTest, ::testing::Values("lcm", "muster"),
                         [](const auto& logger) { return std::string(logger.param); });

Datagram Named(std::string_view channel, std::size_t bytes) {
  Datagram datagram(bytes, 'x');
  std::copy(channel.begin(), channel.end(), datagram.begin());
  datagram[channel.size()] = 0;
  return datagram;
}

/// Memory of the process and its children now, MiB; without lcm-logger, which holds up to 100 MB of
/// what it had no time to write.
std::int64_t MemoryOf(pid_t parent) {
  std::vector<std::string> pids = {std::to_string(parent)};
  std::istringstream children(TextOf(fmt::format("/proc/{0}/task/{0}/children", parent)));
  for (std::string pid; children >> pid;) pids.push_back(pid);
  std::int64_t sum_kib = 0;
  for (const std::string& pid : pids) {
    const std::string status = TextOf("/proc/" + pid + "/status");
    const std::size_t at = status.find("VmRSS:");
    if (at != std::string::npos && !status.starts_with("Name:\tlcm-logger"))
      sum_kib += std::stoll(status.substr(at + 6));
  }
  return sum_kib / 1024;
}

/// Datagrams of another run's messages, of each type and cut into fragments, most of them damaged
/// anywhere; of a sealed mission, its own messages, too. Without a seal those would be believed
/// where the damage makes another possible message: LCM has no checksum.
void DatagramAttackTest::AttackAtRandom(std::uint64_t seed, std::int64_t datagrams, bool sealed,
                                        const std::string& rate, std::chrono::minutes longest) {
  std::vector<Datagram> valid;
  const auto add = [&](const auto& message, std::string_view type) {
    for (const Channel& row : kChannels) {
      if (row.type == type) valid.push_back(DatagramsOf(row.name, Encode(message)).front());
    }
  };
  std::apply([&](const auto&... message) { (add(message, message.getTypeName()), ...); },
             SampleMessages());
  ASSERT_GT(valid.size(), 12u);
  valid.push_back(DatagramsOf("CAMERA", Datagram(500, 'x')).front());
  for (const Datagram& fragment : DatagramsOf(channel::kWorld, Datagram(140'000, 'x'))) {
    valid.push_back(fragment);
  }
  for (std::uint16_t i = 0; i < 5; ++i) {
    valid.push_back(Fragment({7, 500 - 13, i == 0 ? 0 : i * 100u - 13, i, 5},
                             i == 0 ? Named("MUSTER_WORLD", 100) : Datagram(100, 'y')));
  }

  Muster muster = Start(rate, sealed);
  ASSERT_TRUE(UnderWay(&muster)) << muster.output();
  if (sealed) {
    LcmBus bus(MissionUrl(port_));
    std::vector<Datagram> own;
    ASSERT_TRUE(Eventually([&] {
      for (const Packet& packet : bus.Receive(100'000)) {
        for (Datagram& datagram : DatagramsOf(packet.channel, packet.bytes)) {
          own.push_back(std::move(datagram));
        }
      }
      return own.size() > 200;
    })) << muster.output();
    valid.insert(valid.begin(), own.begin(), own.end());
  }
  RawSender raw(port_);
  Random random(seed, Stream::kTest);
  std::int64_t sent = 0, early_mib = 0, late_mib = 0;
  while (sent < datagrams && !muster.child().Poll()) {
    for (int i = 0; i < 1000; ++i, ++sent) {
      // The large fragments now and then: they take a thousand times the time.
      const std::size_t n = random.Below(100) == 0 ? valid.size() : valid.size() - 8;
      Datagram datagram = valid[random.Below(static_cast<std::uint32_t>(n))];
      Damage(&random, random.Below(2) == 0 ? 40 : datagram.size() + 1, &datagram);
      raw.Send(datagram);
    }
    if (sent % 10'000 != 0 || muster.child().Poll()) continue;
    late_mib = MemoryOf(muster.child().pid());
    if (early_mib == 0) early_mib = late_mib;
  }
  fmt::print("{} datagrams, seed {}, memory {} and {} MiB\n", sent, seed, early_mib, late_mib);
  // The address sanitizer keeps what was given back for a while.
  if (!kSanitized) {
    EXPECT_LT(late_mib, early_mib + 64);
  }
  ExpectUnharmed(&muster, longest);
}

class LongDatagramAttackTest : public DatagramAttackTest {};

TEST_P(LongDatagramAttackTest, TenMillionDamagedAtRandomHarmNobody) {
  const char* text = std::getenv("MUSTER_DATAGRAMS");
  const std::int64_t datagrams = text == nullptr ? 10'000'000 : std::atoll(text);
  AttackAtRandom(2, datagrams, false, "15", std::chrono::minutes(60));
}

TEST_P(LongDatagramAttackTest, TenMillionDamagedOfItsOwnHarmNoSealedMission) {
  const char* text = std::getenv("MUSTER_DATAGRAMS");
  const std::int64_t datagrams = text == nullptr ? 10'000'000 : std::atoll(text);
  AttackAtRandom(3, datagrams, true, "15", std::chrono::minutes(60));
}

INSTANTIATE_TEST_SUITE_P(Loggers, LongDatagramAttackTest, ::testing::Values("lcm", "muster"),
                         [](const auto& logger) { return std::string(logger.param); });

TEST_P(DatagramAttackTest, WhatEndsLcmEndsNobody) {
  Muster muster = Start("1800");
  ASSERT_TRUE(UnderWay(&muster)) << muster.output();
  RawSender raw(port_);
  for (int i = 0; i < 50; ++i) {
    for (const std::string_view channel : {channel::kScenario, std::string_view("ANYBODY")}) {
      const Datagram first = Named(channel, 40'000);
      // Written out of bounds, before and behind.
      for (const std::uint32_t offset : {0xFFFFFF00u, 0xFFFFFFFFu, 0x7FFFFFFFu, 60'001u}) {
        raw.Send(Fragment({1, 60'000, 0, 0, 2}, first));
        raw.Send(Fragment({1, 60'000, offset, 1, 2}, Datagram(2000, 'x')));
      }
      // Cut short: the fragment's length wraps.
      Datagram cut = Fragment({2, 60'000, 0, 0, 2}, first);
      for (const std::size_t size : {4u, 8u, 12u, 19u, 20u, 23u}) {
        cut.resize(size);
        raw.Send(cut);
      }
      // No NUL: the name runs on into what the buffer held before.
      raw.Send(Fragment({3, 60'000, 0, 0, 2}, Datagram(30, 'M')));
      Datagram nameless = DatagramsOf(channel, Datagram(1)).front();
      nameless.resize(nameless.size() - 2);
      raw.Send(nameless);
      // 64 MiB out of a few bytes, and a count that never comes.
      raw.Send(Fragment({4, 64 << 20, 0, 0, 1}, Named(channel, 100)));
      raw.Send(Fragment({5, 100, 0, 0, 0}, Named(channel, 100)));
    }
  }
  ExpectUnharmed(&muster, std::chrono::minutes(2));
}

TEST_P(DatagramAttackTest, WhatIsDamagedAtRandomHarmsNobody) {
  AttackAtRandom(1, 200'000, false, "1800", std::chrono::minutes(2));
}

TEST_P(DatagramAttackTest, WhatIsDamagedOfItsOwnHarmsNoSealedMission) {
  AttackAtRandom(4, 200'000, true, "1800", std::chrono::minutes(2));
}

/// An impostor among the members, without whose 999 messages nobody would ever have ended.
TEST_P(DatagramAttackTest, ANumberThatIsTooHighHoldsTheMissionUpNoLonger) {
  Muster muster = Start("max");
  LcmBus bus(MissionUrl(port_));
  std::optional<process_status_t> status;
  const auto is_known = [&] {
    for (const Packet& packet : bus.Receive(100'000)) {
      if (packet.channel != channel::kProcess) continue;
      const auto heard = DecodeValid<process_status_t>(packet.bytes);
      if (heard && heard->header.sender == "uav") status = heard;
    }
    return status.has_value();
  };
  ASSERT_TRUE(Eventually(is_known)) << muster.output();
  status->header.seq += 10'000;
  bus.Publish({std::string(channel::kProcess), Encode(*status)});
  EXPECT_EQ(muster.Wait(std::chrono::minutes(2)), 4) << muster.output();
  const std::string said = muster.output();
  EXPECT_NE(said.find("the mission has been over for 3 s: it waits for 9"), std::string::npos)
      << said;
  EXPECT_NE(said.find(" messages of uav (start 0) in the log: given up"), std::string::npos)
      << said;
  EXPECT_NE(said.find("NOT COMPLETE"), std::string::npos) << said;
  EXPECT_NE(said.find("first: uav (start 0) seq"), std::string::npos) << said;
}

}  // namespace
}  // namespace muster::tools
