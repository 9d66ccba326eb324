// A mission among packets that lie: garbage, damaged copies, another run's messages, intruders,
// ids and times that cannot be. All are counted and dropped, and the mission is what it was.

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/simulation/audited.h"
#include "tests/simulation/crew.h"
#include "tools/record/digest.h"

namespace muster::tools {
namespace {

using testing::Crew;
using testing::StartProcess;

constexpr std::int64_t kRun = 1;

/// Makes hostile packets out of what a mission says.
class Liar {
 public:
  explicit Liar(std::uint64_t seed) : random_(seed, Stream::kTest) {}

  /// One lie about `packet`, of a kind drawn from the seed.
  Packet Lie(const Packet& packet) {
    const auto kind = random_.Below(7);
    ++told_[static_cast<int>(kind)];
    switch (kind) {
      case 0:
        return Garbage(packet);
      case 1:
        return Damaged(packet);
      case 2:
        return HugeCount(packet);
      default:
        break;
    }
    return WithType(packet, [&](auto message) {
      if (kind == 3) message.header.run_id = kRun + 1;
      if (kind == 4) {  // one whose word would be believed, were it the right one's
        message.header.sender = "intruder";
        if (FindChannel(packet.channel)->AcceptsFrom("intruder")) Twist(&message);
      }
      if (kind == 5) Twist(&message);
      if (kind == 6) {  // newer by number, older by time
        message.header.seq += 1'000'000;
        message.header.sim_us -= std::min<std::int64_t>(message.header.sim_us, kMinuteUs);
        Twist(&message);
      }
      return Packet{packet.channel, Encode(message)};
    });
  }

  const std::map<int, int>& told() const { return told_; }

 private:
  Packet Garbage(const Packet& packet) {
    std::vector<std::uint8_t> bytes(random_.Below(200));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random_.Below(256));
    return {packet.channel, bytes};
  }

  Packet Damaged(Packet packet) {
    if (random_.Below(2) == 0) {
      packet.bytes.resize(random_.Below(static_cast<std::uint32_t>(packet.bytes.size())));
    } else {
      packet.bytes[random_.Below(8)] ^= static_cast<std::uint8_t>(1 + random_.Below(255));
    }
    return packet;
  }

  /// The bytes where counts may be, made enormous.
  Packet HugeCount(Packet packet) {
    const std::size_t size = packet.bytes.size();
    const std::size_t header = 8 + 8;  // fingerprint, run_id; then the sender's length
    for (std::size_t i = 0; i < 4 && header + i < size; ++i) packet.bytes[header + i] = 0x7f;
    return packet;
  }

  template <class Change>
  static Packet WithType(const Packet& packet, Change change) {
    const auto as = [&](auto type) { return change(*Decode<decltype(type)>(packet.bytes)); };
    const std::string_view type = FindChannel(packet.channel)->type;
    if (type == "agent_states_t") return as(agent_states_t{});
    if (type == "clock_t") return as(muster::clock_t{});
    if (type == "world_state_t") return as(world_state_t{});
    if (type == "rulings_t") return as(rulings_t{});
    if (type == "schedule_t") return as(schedule_t{});
    if (type == "scenario_t") return as(scenario_t{});
    if (type == "event_t") return as(event_t{});
    if (type == "request_t") return as(request_t{});
    return Packet{packet.channel, {}};
  }

  /// Values that cannot be.
  void Twist(agent_states_t* m) {
    if (m->agents.empty()) return Other(m);
    agent_t& agent = m->agents[random_.Below(static_cast<std::uint32_t>(m->agents.size()))];
    switch (random_.Below(5)) {
      case 0:
        agent.x_m = std::numeric_limits<double>::quiet_NaN();
        break;
      case 1:
        agent.id = 1'000'000;
        break;
      case 2:
        agent.id = -7;
        break;
      case 3:
        agent.range_left_m = -std::numeric_limits<double>::infinity();
        break;
      default:
        agent.action = 99;
    }
  }
  void Twist(muster::clock_t* m) {
    switch (random_.Below(4)) {
      case 0:
        m->tick += 1'000'000;
        break;
      case 1:
        m->tick_us += 1;
        break;
      case 2:
        m->tick = m->tick_us = -1;
        break;
      default:
        m->decision = 1'000'000;
    }
  }
  void Twist(world_state_t* m) {
    if (random_.Below(2) == 0) {
      m->tick += 1'000'000;  // "the world is far ahead of you"
    } else {
      m->activities.resize(1);
      m->n_activities = 1;
      m->activities[0].site_id = 1'000'000;
      m->activities[0].start_us = -5;
    }
  }
  void Twist(schedule_t* m) {
    m->n = 1;
    m->actions.assign(1, action_t{});
    m->actions[0].kind = 1;
    m->actions[0].uav_id = 1'000'000;
  }
  template <class T>
  void Twist(T* m) {
    Other(m);
  }
  template <class T>
  void Other(T* m) {
    m->header.run_id = -kRun;
  }

  Random random_;
  std::map<int, int> told_;
};

TEST(Hostile, LiesAreCountedAndChangeNothing) {
  const std::string json = ScenarioToJson(Generate(PresetByName("Random_10"), 5));
  RunRecord expected;
  Simulate(json, "mpq", [&](const Packet& packet) { expected.Add(packet); });

  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Crew network({.loss = 0.05}, seed);
    std::map<std::string, Process*> processes;
    for (const char* name : {"world", "uav", "worker", "vehicle", "scheduler"}) {
      auto process = StartProcess(name, 0, json);
      processes[name] = process.get();
      network.Add(std::move(process));
    }
    Liar liar(seed);
    RunRecord record;
    Audited audited;
    bool ended = false;
    network.set_intruder([&](const Packet& packet) { return liar.Lie(packet); });
    network.Run(
        3600 * kSecondUs, [&] { return ended; },
        [&](const Packet& packet) {
          record.Add(packet);
          audited.Add(packet);
          if (packet.channel == channel::kClock) {
            ended |= Decode<muster::clock_t>(packet.bytes)->phase == 2;
          }
        });
    ASSERT_TRUE(ended);
    EXPECT_EQ(Digest(record), Digest(expected));
    for (int kind = 0; kind < 7; ++kind) EXPECT_GT(liar.told().at(kind), 10) << kind;
    for (const auto& [name, process] : processes) {
      EXPECT_GT(process->counters().rejected, 100) << name;
    }
  }
}

/// Damaged packets may say something possible and untrue: the mission may come to something else,
/// but it comes to an end.
void ExpectAnEndThoughPacketsAreDamaged(const Scenario& scenario, double share) {
  const std::string json = ScenarioToJson(scenario);
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Crew network({.corrupt = share}, seed);
    for (const char* name : {"world", "uav", "worker", "vehicle", "scheduler"}) {
      network.Add(StartProcess(name, 0, json));
    }
    bool ended = false;
    network.Run(
        3600 * kSecondUs, [&] { return ended; },
        [&](const Packet& packet) {
          if (packet.channel == channel::kClock) {
            ended |= Decode<muster::clock_t>(packet.bytes)->phase == 2;
          }
        });
    EXPECT_TRUE(ended) << "seed " << seed << ", a share of " << share << " damaged";
  }
}

TEST(Hostile, DamagedPacketsHoldNoMissionUp) {
  ExpectAnEndThoughPacketsAreDamaged(Generate(PresetByName("Random_10"), 1), 0.2);
}

TEST(Hostile, DamagedPacketsHoldNoMissionWithOrdersUp) {
  Scenario scenario = Generate(PresetByName("Random_10"), 1);
  AddRoom({1, {}}, &scenario);
  for (const double share : {0.005, 0.02, 0.2}) {
    ExpectAnEndThoughPacketsAreDamaged(scenario, share);
  }
}

/// What a seal cannot refuse: a true message, heard before and said again. Whoever is killed while
/// that goes on takes no old state for the present one.
TEST(Hostile, WhatWasSaidBeforeChangesNothingWhenItIsSaidAgain) {
  const std::string json = ScenarioToJson(Generate(PresetByName("Random_10"), 5));
  RunRecord expected;
  Simulate(json, "mpq", [&](const Packet& packet) { expected.Add(packet); });
  const std::vector<std::string> names = {"world", "uav", "worker", "vehicle", "scheduler"};
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed, Stream::kTest);
    Crew network({.loss = 0.05}, seed);
    std::map<std::string, std::int64_t> boots;
    for (const std::string& name : names) network.Add(StartProcess(name, 0, json));
    std::vector<Packet> heard;
    RunRecord record;
    bool ended = false;
    network.set_intruder([&](const Packet& packet) {
      heard.push_back(packet);
      return heard[random.Below(static_cast<std::uint32_t>(heard.size()))];
    });
    const auto observe = [&](const Packet& packet) {
      record.Add(packet);
      if (packet.channel == channel::kClock) {
        ended |= Decode<muster::clock_t>(packet.bytes)->phase == 2;
      }
    };
    constexpr TimeUs kLimitUs = 3600 * kSecondUs;
    for (int i = 0; i < 6; ++i) {
      const std::size_t until = heard.size() + 50 + random.Below(1000);
      network.Run(
          kLimitUs, [&] { return ended || heard.size() >= until; }, observe);
      if (ended) break;
      const std::string& victim =
          i % 2 == 0 ? names[0] : names[random.Below(static_cast<std::uint32_t>(names.size()))];
      network.Kill(victim);
      network.Add(StartProcess(victim, ++boots[victim], json));
    }
    ASSERT_TRUE(network.Run(
        kLimitUs, [&] { return ended; }, observe));
    EXPECT_EQ(Digest(record), Digest(expected));
  }
}

TEST(Hostile, OneWhoFloodsWithNamesGetsNoMemory) {
  Inbox inbox(kRun, "uav");
  event_t event{};
  event.header.run_id = kRun;
  for (int i = 0; i < 50'000; ++i) {
    event.header.sender = "bot-" + std::to_string(i);
    event.header.seq = std::numeric_limits<std::int64_t>::max() - i;
    inbox.Open({std::string(channel::kEvent), Encode(event)});
  }
  EXPECT_EQ(inbox.counters().received + inbox.counters().rejected, 50'000);
  EXPECT_LE(inbox.counters().received, 10'000);
}

}  // namespace
}  // namespace muster::tools
