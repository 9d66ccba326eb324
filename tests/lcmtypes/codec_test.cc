#include "lcmtypes/bus/codec.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "base/random.h"
#include "lcmtypes/channels.h"
#include "tests/lcmtypes/sample_messages.h"

namespace muster {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Calls `body` with the sample of each type.
template <class Body>
void ForEachType(Body body) {
  std::apply(
      [&](const auto&... messages) {
        const auto one = [&](const auto& message) {
          SCOPED_TRACE(message.getTypeName());
          body(message);
        };
        (one(messages), ...);
      },
      SampleMessages());
}

template <class T>
T Sample() {
  return std::get<T>(SampleMessages());
}

/// Whatever Decode accepts must be well formed to the last byte.
template <class T>
bool AcceptsOnlyCanonical(const Bytes& bytes) {
  const std::optional<T> message = Decode<T>(bytes);
  if (!message) return false;
  EXPECT_EQ(Encode(*message), bytes);
  Valid(*message);  // must cope with any value
  return true;
}

TEST(Codec, EveryTypeOfTheChannelTableSurvivesARoundTrip) {
  ForEachType([](const auto& message) {
    using T = std::decay_t<decltype(message)>;
    const Bytes bytes = Encode(message);
    const std::optional<T> back = Decode<T>(bytes);
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(Encode(*back), bytes);
    EXPECT_EQ(back->header.sender, message.header.sender);
    EXPECT_EQ(back->header.seq, message.header.seq);
    EXPECT_TRUE(Valid(*back));
    EXPECT_TRUE(DecodeValid<T>(bytes).has_value());
    EXPECT_EQ(Fingerprint(T::getTypeName()), static_cast<std::uint64_t>(T::getHash()));
  });
  for (const Channel& channel : kChannels) {
    EXPECT_TRUE(Fingerprint(channel.type).has_value()) << channel.type;
  }
  EXPECT_EQ(Fingerprint("agent_t"), std::nullopt);
}

/// "64 MiB", "4 KiB".
std::string SizeText(std::int64_t bytes) {
  return bytes % kMiB == 0 ? std::to_string(bytes / kMiB) + " MiB"
                           : std::to_string(bytes / 1024) + " KiB";
}

TEST(WireDocument, HasEveryChannelAndEveryFingerprint) {
  std::ifstream file(MUSTER_WIRE_DOCUMENT);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  ASSERT_FALSE(text.empty()) << MUSTER_WIRE_DOCUMENT;
  for (const Channel& channel : kChannels) {
    const std::string row =
        fmt::format("| `{}` | `{}` | {} | {} | {} |\n", channel.name, channel.type,
                    channel.publisher, channel.rate, SizeText(channel.max_bytes));
    EXPECT_NE(text.find(row), std::string::npos) << row;
    // A kept log is readable as long as its fingerprints are ours: change no type, add a new one.
    const std::string type =
        fmt::format("| `{}` | `{:016x}` |", channel.type, *Fingerprint(channel.type));
    EXPECT_NE(text.find(type), std::string::npos) << type;
  }
}

TEST(Codec, KeepsEveryField) {
  const world_state_t world = *Decode<world_state_t>(Encode(Sample<world_state_t>()));
  EXPECT_EQ(world.tick, 3);
  EXPECT_EQ(world.done, 1);
  EXPECT_EQ(world.task_status, (std::vector<std::int8_t>{0, 1, 2, 3}));
  ASSERT_EQ(world.activities.size(), 2u);
  EXPECT_EQ(world.activities[1].end_us, 20);
  const schedule_t schedule = *Decode<schedule_t>(Encode(Sample<schedule_t>()));
  EXPECT_EQ(schedule.policy, "hocs-mpq");
  EXPECT_TRUE(std::isnan(schedule.bound));
  ASSERT_EQ(schedule.actions.size(), 10u);
  EXPECT_EQ(schedule.actions[9].kind, 9);
  EXPECT_EQ(schedule.actions[9].weight, 0.693);
}

TEST(Codec, RefusesEveryTruncationAndAnyTrailingByte) {
  ForEachType([](const auto& message) {
    using T = std::decay_t<decltype(message)>;
    Bytes bytes = Encode(message);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      // A copy of that length, so that a read behind it is one behind the allocation.
      const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_FALSE(Decode<T>(cut).has_value()) << length;
    }
    bytes.push_back(0);
    EXPECT_FALSE(Decode<T>(bytes).has_value());
  });
}

TEST(Codec, EverySingleByteCorruptionIsRefusedOrCanonical) {
  ForEachType([](const auto& message) {
    using T = std::decay_t<decltype(message)>;
    const Bytes bytes = Encode(message);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      for (int value = 0; value < 256; ++value) {
        Bytes corrupt = bytes;
        corrupt[i] = static_cast<std::uint8_t>(value);
        const bool accepted = AcceptsOnlyCanonical<T>(corrupt);
        if (i < 8) {
          EXPECT_EQ(accepted, corrupt == bytes) << "fingerprint";
        }
      }
    }
  });
}

TEST(Codec, RefusesTheOtherTypes) {
  ForEachType([](const auto& message) {
    const Bytes bytes = Encode(message);
    int accepted = 0;
    ForEachType([&](const auto& other) {
      using T = std::decay_t<decltype(other)>;
      accepted += Decode<T>(bytes).has_value();
    });
    EXPECT_EQ(accepted, 1);
  });
}

/// Bytes of the big-endian count that stands `from_end` bytes before the end.
void SetCount(Bytes* bytes, std::size_t from_end, std::int32_t value) {
  const std::size_t at = bytes->size() - from_end;
  for (std::size_t i = 0; i < 4; ++i) {
    (*bytes)[at + i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> (24 - 8 * i));
  }
}

TEST(Codec, RefusesCountsThatTheBytesDoNotJustify) {
  // The array of each ends the message: its count stands 4 bytes before it.
  constexpr std::size_t kAgentBytes = 4 + 9 * 8 + 5 * 8 + 2 + 3 * 4;
  constexpr std::size_t kActionBytes = 1 + 5 * 4 + 3 * 8;
  constexpr std::size_t kClearanceBytes = 2 * 4 + 2 * 8 + 8;
  constexpr std::size_t kRulingBytes = 1 + 4 + 1 + 8;
  constexpr std::size_t kActivityBytes = 1 + 3 * 4 + 2 * 8;
  const auto check = [](const auto& message, std::size_t array_bytes, std::int32_t count) {
    using T = std::decay_t<decltype(message)>;
    SCOPED_TRACE(T::getTypeName());
    Bytes bytes = Encode(message);
    SetCount(&bytes, array_bytes + 4, count);
    ASSERT_TRUE(Decode<T>(bytes).has_value()) << "the count is not where the test thinks";
    for (const std::int32_t wrong :
         {std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::min(), -1, 0,
          count - 1, count + 1, 1 << 30, 100'000'000}) {
      SetCount(&bytes, array_bytes + 4, wrong);
      EXPECT_FALSE(Decode<T>(bytes).has_value()) << wrong;
    }
  };
  check(Sample<agent_changes_t>(), 2 * kAgentBytes, 2);
  check(Sample<agent_states_t>(), 2 * kAgentBytes, 2);
  check(Sample<schedule_t>(), 10 * kActionBytes, 10);
  check(Sample<clearances_t>(), 2 * kClearanceBytes, 2);
  check(Sample<rulings_t>(), 3 * kRulingBytes, 3);
  check(Sample<world_state_t>(), 2 * kActivityBytes, 2);
  check(Sample<world_state_t>(), 2 * kActivityBytes + 4 + 4, 4);  // task_status
  check(Sample<restore_t>(), 4, 4);
  check(Sample<answer_t>(), 4, 4);
  check(Sample<log_status_t>(), (4 + 6 + 16) + (4 + 4 + 16), 2);
  // A string's count includes its NUL; the JSON text ends the message.
  check(Sample<scenario_t>(), 15, 15);
}

TEST(Codec, RefusesStringsWithNulInsideOrWithoutNulAtTheEnd) {
  const Bytes bytes = Encode(Sample<scenario_t>());
  Bytes inside = bytes;
  inside[bytes.size() - 5] = 0;
  EXPECT_FALSE(Decode<scenario_t>(inside).has_value());
  Bytes open = bytes;
  open.back() = 'x';
  EXPECT_FALSE(Decode<scenario_t>(open).has_value());
}

TEST(Codec, RandomBytesAndRandomDamageAreRefusedOrCanonical) {
  const char* given = std::getenv("MUSTER_TEST_SEED");
  const std::uint64_t seed = given != nullptr ? std::strtoull(given, nullptr, 10) : 20250301;
  RecordProperty("seed", std::to_string(seed));
  SCOPED_TRACE(testing::Message() << "MUSTER_TEST_SEED=" << seed);
  std::uint64_t type = 0;
  ForEachType([&](const auto& message) {
    using T = std::decay_t<decltype(message)>;
    ++type;
    const Bytes sample = Encode(message);
    for (std::uint32_t round = 0; round < 3000; ++round) {
      Random random(seed, Stream::kTest, type, round);
      Bytes bytes(sample.begin(), sample.begin() + 8);  // else nothing gets past the fingerprint
      if (round % 2 == 0) {
        for (std::uint32_t i = random.Below(300); i > 0; --i) {
          // Small numbers are plausible counts.
          bytes.push_back(static_cast<std::uint8_t>(random.Below(2) == 0 ? 0 : random.Below(256)));
        }
      } else {
        bytes = sample;
        for (std::uint32_t i = 1 + random.Below(6); i > 0; --i) {
          bytes[random.Below(static_cast<std::uint32_t>(bytes.size()))] =
              static_cast<std::uint8_t>(random.Below(256));
        }
        if (random.Below(4) == 0) bytes.resize(random.Below(600));
      }
      AcceptsOnlyCanonical<T>(bytes);
    }
  });
}

TEST(Codec, EmptyArraysAndStringsAreFine) {
  agent_states_t agents = Sample<agent_states_t>();
  agents.agents.clear();
  agents.n = 0;
  EXPECT_TRUE(DecodeValid<agent_states_t>(Encode(agents)).has_value());
  world_state_t world = Sample<world_state_t>();
  world.task_status.clear();
  world.activities.clear();
  world.n_tasks = world.n_activities = world.done = 0;
  EXPECT_TRUE(DecodeValid<world_state_t>(Encode(world)).has_value());
  event_t event = Sample<event_t>();
  event.detail.clear();
  EXPECT_TRUE(DecodeValid<event_t>(Encode(event)).has_value());
}

TEST(CodecDeathTest, EncodeRefusesCountsThatAreNotTheArraysLength) {
  schedule_t schedule = Sample<schedule_t>();
  schedule.n = 11;
  EXPECT_DEATH(Encode(schedule), "schedule_t: a count is not its array's length");
  request_t request = Sample<request_t>();
  request.channel = std::string("MUSTER\0WORLD", 12);
  EXPECT_DEATH(Encode(request), "request_t.*NUL");
}

TEST(DecodeHeader, TellsTheSenderOfAnyChannelsMessage) {
  for (const Channel& channel : kChannels) {
    ForEachType([&](const auto& message) {
      const Packet packet{std::string(channel.name), Encode(message)};
      const std::optional<header_t> header = DecodeHeader(packet);
      ASSERT_EQ(header.has_value(), channel.type == message.getTypeName()) << channel.name;
      if (!header) return;
      EXPECT_EQ(header->sender, "worker-2");
      EXPECT_EQ(header->boot_id, 1);
      EXPECT_EQ(header->seq, message.header.seq);
      EXPECT_EQ(header->wall_us, 1'700'000'000'000'000);
    });
  }
  Packet packet{"MUSTER_NOBODY_KNOWS", Encode(Sample<clock_t>())};
  EXPECT_FALSE(DecodeHeader(packet).has_value());
  packet.channel = channel::kClock;
  EXPECT_TRUE(DecodeHeader(packet).has_value());
  packet.bytes.pop_back();
  EXPECT_FALSE(DecodeHeader(packet).has_value());
  clock_t bad = Sample<clock_t>();
  bad.header.sender.clear();
  EXPECT_FALSE(DecodeHeader({std::string(channel::kClock), Encode(bad)}).has_value());
}

/// Whether the sample of T, changed by `change`, is valid.
template <class T, class Change>
bool ValidAfter(Change change) {
  T message = Sample<T>();
  EXPECT_TRUE(Valid(message));
  change(message);
  return Valid(message);
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Valid, LooksAtTheHeaderOfEveryType) {
  ForEachType([](const auto& message) {
    const auto with = [&](auto change) {
      auto copy = message;
      change(copy.header);
      return Valid(copy);
    };
    EXPECT_FALSE(with([](header_t& h) { h.sender.clear(); }));
    EXPECT_FALSE(with([](header_t& h) { h.sender.assign(257, 'x'); }));
    EXPECT_FALSE(with([](header_t& h) { h.boot_id = -1; }));
    EXPECT_FALSE(with([](header_t& h) { h.seq = -1; }));
    EXPECT_FALSE(with([](header_t& h) { h.sim_us = -1; }));
    EXPECT_FALSE(with([](header_t& h) { h.wall_us = -1; }));
    EXPECT_TRUE(with([](header_t& h) { h.run_id = -1; }));
  });
}

TEST(Valid, LooksAtTicksAndEnumerators) {
  EXPECT_FALSE(ValidAfter<clock_t>([](clock_t& m) { m.tick = -1; }));
  EXPECT_FALSE(ValidAfter<clock_t>([](clock_t& m) { m.tick_us = -1; }));
  EXPECT_FALSE(ValidAfter<clock_t>([](clock_t& m) { m.limit_us = -1; }));
  EXPECT_FALSE(ValidAfter<clock_t>([](clock_t& m) { m.phase = 3; }));
  EXPECT_FALSE(ValidAfter<clock_t>([](clock_t& m) { m.phase = -1; }));
  EXPECT_FALSE(ValidAfter<clock_t>([](clock_t& m) { m.decision = -2; }));
  EXPECT_FALSE(ValidAfter<clock_t>([](clock_t& m) { m.required_decision = -2; }));
  EXPECT_FALSE(ValidAfter<event_t>([](event_t& m) { m.kind = 32; }));
  EXPECT_FALSE(ValidAfter<event_t>([](event_t& m) { m.task_id = -2; }));
  EXPECT_FALSE(ValidAfter<event_t>([](event_t& m) { m.at_us = -1; }));
  EXPECT_FALSE(ValidAfter<event_t>([](event_t& m) { m.detail.assign(3000, 'x'); }));
  EXPECT_TRUE(ValidAfter<event_t>([](event_t& m) { m.detail = "\xc3\xa4"; }));
  EXPECT_FALSE(ValidAfter<event_t>([](event_t& m) { m.detail = "\xc3"; }));
  EXPECT_FALSE(ValidAfter<process_status_t>([](process_status_t& m) { m.host = "\xff"; }));
  EXPECT_FALSE(ValidAfter<schedule_t>([](schedule_t& m) { m.policy = "\xed\xa0\x80"; }));
  EXPECT_FALSE(ValidAfter<fault_t>([](fault_t& m) { m.kind = 14; }));
  EXPECT_FALSE(ValidAfter<fault_t>([](fault_t& m) { m.probability = kNan; }));
  EXPECT_FALSE(ValidAfter<fault_t>([](fault_t& m) { m.probability = 1.5; }));
  EXPECT_FALSE(ValidAfter<fault_t>([](fault_t& m) { m.for_us = -1; }));
  EXPECT_FALSE(ValidAfter<log_status_t>([](log_status_t& m) { m.marks[1].next_seq = -1; }));
  EXPECT_FALSE(ValidAfter<log_status_t>([](log_status_t& m) { m.marks[1].sender.clear(); }));
  EXPECT_FALSE(ValidAfter<process_status_t>([](process_status_t& m) { m.state = 6; }));
  EXPECT_FALSE(ValidAfter<process_status_t>([](process_status_t& m) { m.tick = -2; }));
  EXPECT_FALSE(ValidAfter<process_status_t>([](process_status_t& m) { m.cpu_s = kInfinity; }));
  EXPECT_FALSE(ValidAfter<process_status_t>([](process_status_t& m) { m.lost = -1; }));
  EXPECT_FALSE(ValidAfter<request_t>([](request_t& m) { m.channel = "MUSTER_NOBODY_KNOWS"; }));
  EXPECT_FALSE(ValidAfter<restore_t>([](restore_t& m) { m.channel = ""; }));
  EXPECT_FALSE(ValidAfter<restore_t>([](restore_t& m) { m.tick = -2; }));
  EXPECT_FALSE(ValidAfter<answer_t>([](answer_t& m) { m.channel = ""; }));
  EXPECT_FALSE(ValidAfter<answer_t>([](answer_t& m) { m.tick = -2; }));
  EXPECT_FALSE(ValidAfter<order_t>([](order_t& m) { m.id = ""; }));
  EXPECT_FALSE(ValidAfter<order_t>([](order_t& m) { m.json = std::string(20'000, ' '); }));
  EXPECT_FALSE(ValidAfter<order_t>([](order_t& m) { m.issuer = "\x1b[2J"; }));
  EXPECT_FALSE(ValidAfter<orders_t>([](orders_t& m) { m.tick = -1; }));
  EXPECT_FALSE(ValidAfter<orders_t>([](orders_t& m) { m.taken[1].agent_kind = 3; }));
  EXPECT_FALSE(ValidAfter<orders_t>([](orders_t& m) { m.refused[0].id = ""; }));
  EXPECT_FALSE(ValidAfter<answer_t>([](answer_t& m) { m.asker_boot_id = -1; }));
  EXPECT_FALSE(ValidAfter<answer_t>([](answer_t& m) { m.asker_seq = -1; }));
  EXPECT_FALSE(ValidAfter<rulings_t>([](rulings_t& m) { m.rulings[0].agent_kind = 3; }));
  EXPECT_FALSE(ValidAfter<rulings_t>([](rulings_t& m) { m.rulings[0].kind = 3; }));
  EXPECT_FALSE(ValidAfter<rulings_t>([](rulings_t& m) { m.rulings[0].agent_id = -1; }));
  EXPECT_FALSE(ValidAfter<scenario_t>([](scenario_t& m) { m.sha256 = "abc"; }));
  EXPECT_FALSE(ValidAfter<scenario_t>([](scenario_t& m) { m.sha256[3] = 'A'; }));
}

TEST(Valid, AMissionIsReadyAtItsStartAndEndsAtItsLimit) {
  const auto valid = [](ClockPhase phase, std::int64_t tick, std::int64_t tick_us) {
    return ValidAfter<clock_t>([&](clock_t& m) {
      m.phase = NumberOf(phase);
      m.tick = tick;
      m.tick_us = tick_us;
      m.limit_us = 1000;
    });
  };
  EXPECT_TRUE(valid(ClockPhase::kReady, 0, 0));
  EXPECT_FALSE(valid(ClockPhase::kReady, 1, 10));
  EXPECT_TRUE(valid(ClockPhase::kRunning, 1, 10));
  EXPECT_FALSE(valid(ClockPhase::kEnded, 99, 999));
  EXPECT_TRUE(valid(ClockPhase::kEnded, 100, 1000));
}

TEST(Valid, PlacesAreOnEarth) {
  EXPECT_TRUE(ValidAfter<schedule_t>([](schedule_t& m) { m.actions[0].x_m = -2e7; }));
  EXPECT_FALSE(ValidAfter<schedule_t>([](schedule_t& m) { m.actions[0].x_m = -2.1e7; }));
  EXPECT_FALSE(ValidAfter<schedule_t>([](schedule_t& m) { m.actions[0].y_m = 1e300; }));
  EXPECT_FALSE(ValidAfter<agent_states_t>([](agent_states_t& m) { m.agents[0].x_m = 2.1e7; }));
  EXPECT_FALSE(ValidAfter<agent_states_t>([](agent_states_t& m) { m.agents[0].from_y_m = kNan; }));
}

TEST(Valid, LooksAtEveryElement) {
  using M = agent_states_t;
  EXPECT_FALSE(ValidAfter<M>([](M& m) { m.kind = 3; }));
  EXPECT_FALSE(ValidAfter<M>([](M& m) { m.agents[1].id = -1; }));
  EXPECT_FALSE(ValidAfter<M>([](M& m) { m.agents[1].status = 8; }));
  EXPECT_FALSE(ValidAfter<M>([](M& m) { m.agents[1].action = 10; }));
  EXPECT_TRUE(ValidAfter<M>([](M& m) { m.agents[1].action = -1; }));
  EXPECT_FALSE(ValidAfter<M>([](M& m) { m.agents[1].x_m = kNan; }));
  EXPECT_FALSE(ValidAfter<M>([](M& m) { m.agents[1].from_y_m = kInfinity; }));
  EXPECT_FALSE(ValidAfter<M>([](M& m) { m.agents[1].speed_m_s = -1; }));
  EXPECT_FALSE(ValidAfter<M>([](M& m) { m.agents[1].range_left_m = -1; }));
  EXPECT_FALSE(ValidAfter<M>([](M& m) { m.agents[1].busy_until_us = -1; }));
  EXPECT_FALSE(ValidAfter<M>([](M& m) { m.agents[1].decision = -2; }));
  using C = agent_changes_t;
  EXPECT_TRUE(ValidAfter<C>([](C& m) { m.agents[0].id = 4; }));
  EXPECT_FALSE(ValidAfter<C>([](C& m) { m.kind = 3; }));
  EXPECT_FALSE(ValidAfter<C>([](C& m) { m.base_tick = m.tick; }));
  EXPECT_FALSE(ValidAfter<C>([](C& m) { m.base_tick = -1; }));
  EXPECT_FALSE(ValidAfter<C>([](C& m) { m.applied_decision = -2; }));
  EXPECT_FALSE(ValidAfter<C>([](C& m) { m.first_id = -1; }));
  EXPECT_FALSE(ValidAfter<C>([](C& m) { m.first_id = 4; })) << "before the first";
  EXPECT_FALSE(ValidAfter<C>([](C& m) { m.last_id = 254; })) << "behind the last";
  EXPECT_FALSE(ValidAfter<C>([](C& m) { m.agents[1].id = 3; })) << "twice";
  EXPECT_FALSE(ValidAfter<C>([](C& m) { m.agents[1].x_m = kNan; }));
  using S = schedule_t;
  EXPECT_FALSE(ValidAfter<S>([](S& m) { m.decision = -1; }));
  EXPECT_FALSE(ValidAfter<S>([](S& m) { m.weight = kNan; }));
  EXPECT_FALSE(ValidAfter<S>([](S& m) { m.bound = kInfinity; }));
  EXPECT_TRUE(ValidAfter<S>([](S& m) { m.bound = 13; }));
  EXPECT_FALSE(ValidAfter<S>([](S& m) { m.actions[9].kind = 10; }));
  EXPECT_FALSE(ValidAfter<S>([](S& m) { m.actions[9].x_m = kNan; }));
  EXPECT_FALSE(ValidAfter<S>([](S& m) { m.actions[9].charge_id = -2; }));
  using W = world_state_t;
  EXPECT_FALSE(ValidAfter<W>([](W& m) { m.done = 5; }));
  EXPECT_FALSE(ValidAfter<W>([](W& m) { m.done = -1; }));
  EXPECT_FALSE(ValidAfter<W>([](W& m) { m.task_status[3] = 8; }));
  EXPECT_FALSE(ValidAfter<W>([](W& m) { m.activities[1].kind = 2; }));
  EXPECT_FALSE(ValidAfter<W>([](W& m) { m.activities[1].end_us = 9; }));
  EXPECT_FALSE(ValidAfter<W>([](W& m) { m.activities[1].partner_id = -1; }));
}

}  // namespace
}  // namespace muster
