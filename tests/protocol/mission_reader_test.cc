#include "protocol/mission_reader.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"

namespace muster {
namespace {

header_t From(const std::string& sender, std::int64_t seq, std::int64_t run_id = 1) {
  header_t header{};
  header.run_id = run_id;
  header.sender = sender;
  header.seq = seq;
  return header;
}

Packet EventOf(const header_t& header) {
  event_t event{};
  event.header = header;
  event.uav_id = event.worker_id = event.vehicle_id = event.task_id = event.charge_id = -1;
  return {std::string(channel::kEvent), Encode(event)};
}

Packet ClockOf(const header_t& header, ClockPhase phase) {
  clock_t clock{};
  clock.header = header;
  clock.tick_us = 30 * kSecondUs;
  clock.decision = clock.required_decision = -1;
  clock.phase = NumberOf(phase);
  return {std::string(channel::kClock), Encode(clock)};
}

Packet ScenarioOf(const header_t& header, const std::string& json) {
  scenario_t scenario{};
  scenario.header = header;
  scenario.sha256 = std::string(64, '0');
  scenario.json = json;
  return {std::string(channel::kScenario), Encode(scenario)};
}

std::string Json(const std::string& name = "one") {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  scenario.name = name;
  return ScenarioToJson(scenario);
}

/// What was visited, as (channel, seq), in order.
using Visited = std::vector<std::pair<std::string, std::int64_t>>;

Visited Read(MissionReader* reader, const std::vector<Packet>& packets) {
  Visited visited;
  for (const Packet& packet : packets) {
    reader->Add(packet, [&](const Message& message, const Packet& of) {
      EXPECT_EQ(DecodeHeader(of)->seq, HeaderOf(message).seq);
      EXPECT_TRUE(reader->scenario());
      visited.emplace_back(of.channel, HeaderOf(message).seq);
    });
  }
  return visited;
}

const std::string kScenario(channel::kScenario);
const std::string kEvent(channel::kEvent);
const std::string kClock(channel::kClock);

TEST(MissionReader, TellsEachMessageOnceTheScenarioFirst) {
  MissionReader reader;
  const Packet early = EventOf(From("world", 0)), late = EventOf(From("world", 2));
  const Packet scenario = ScenarioOf(From("world", 1), Json());
  EXPECT_EQ(Read(&reader, {early, early}), Visited());
  EXPECT_FALSE(reader.scenario());
  EXPECT_EQ(Read(&reader, {scenario, late, scenario, late, early}),
            (Visited{{kScenario, 1}, {kEvent, 0}, {kEvent, 2}}));
  EXPECT_EQ(reader.counts(), (MissionReader::Counts{.messages = 3, .duplicates = 4}));
  EXPECT_EQ(reader.run_id(), 1);
  EXPECT_EQ(reader.scenario()->name, "one");
  // Another start counts anew.
  header_t again = From("world", 2);
  again.boot_id = 1;
  EXPECT_EQ(Read(&reader, {EventOf(again)}), (Visited{{kEvent, 2}}));
  EXPECT_EQ(reader.seqs().size(), 2u);
}

TEST(MissionReader, LeavesOutGarbageOtherRunsAndForeignChannels) {
  MissionReader reader;
  const Packet garbage{kClock, {1, 2, 3}}, foreign{"CAMERA", {1}};
  const Packet stranger = EventOf(From("world", 0, 2));
  EXPECT_EQ(Read(&reader, {garbage, foreign, stranger, ScenarioOf(From("world", 0), Json()),
                           garbage, foreign, stranger, ScenarioOf(From("world", 1, 2), Json("2"))}),
            (Visited{{kScenario, 0}}));
  EXPECT_EQ(reader.counts(),
            (MissionReader::Counts{.messages = 1, .strangers = 3, .undecodable = 2, .foreign = 2}));
  EXPECT_EQ(reader.scenario()->name, "one");
  EXPECT_EQ(reader.heard_run_id(), 2);
}

TEST(MissionReader, KnowsItsRunWhenTold) {
  MissionReader reader(1);
  EXPECT_EQ(
      Read(&reader, {ScenarioOf(From("world", 0, 2), Json("two")), EventOf(From("world", 1, 2)),
                     EventOf(From("world", 1)), ScenarioOf(From("world", 0), Json())}),
      (Visited{{kScenario, 0}, {kEvent, 1}}));
  EXPECT_EQ(reader.counts(), (MissionReader::Counts{.messages = 2, .strangers = 2}));
  EXPECT_EQ(reader.scenario()->name, "one");
}

TEST(MissionReader, AnImpossibleScenarioIsNone) {
  MissionReader reader;
  EXPECT_EQ(Read(&reader, {ScenarioOf(From("world", 0, 2), "{\"version\": 1}"),
                           ScenarioOf(From("world", 0), "no JSON"), EventOf(From("world", 1))}),
            Visited());
  EXPECT_FALSE(reader.scenario() || reader.run_id());
  EXPECT_EQ(reader.heard_run_id(), 1);
  // That of its own run was said all the same: its number is no gap.
  EXPECT_EQ(Read(&reader, {ScenarioOf(From("world", 2), Json())}),
            (Visited{{kScenario, 2}, {kScenario, 0}, {kEvent, 1}}));
  EXPECT_EQ(reader.run_id(), 1);
  EXPECT_EQ(reader.counts(),
            (MissionReader::Counts{.messages = 3, .strangers = 1, .undecodable = 2}));
}

TEST(MissionReader, BelievesNobodyWhoMayNotPublishThere) {
  MissionReader reader;
  EXPECT_EQ(Read(&reader, {ScenarioOf(From("world", 0), Json()),
                           ClockOf(From("uav", 0), ClockPhase::kRunning)}),
            (Visited{{kScenario, 0}}));
  EXPECT_EQ(reader.counts().messages, 2);
  EXPECT_EQ(reader.epoch_us(), std::nullopt);
}

TEST(MissionReader, AnIntrudersScenarioIsNone) {
  MissionReader reader;
  EXPECT_EQ(Read(&reader, {ScenarioOf(From("uav", 0, 2), Json("another")),
                           ScenarioOf(From("world", 0), Json())}),
            (Visited{{kScenario, 0}}));
  EXPECT_EQ(reader.scenario()->name, "one");
  EXPECT_EQ(reader.run_id(), 1);
}

TEST(MissionReader, TheFirstClockThatRunsTellsTheWallTime) {
  MissionReader reader;
  header_t header = From("world", 1);
  header.wall_us = 1'000'000'000;
  Read(&reader, {ScenarioOf(From("world", 0), Json()), ClockOf(header, ClockPhase::kReady)});
  EXPECT_EQ(reader.epoch_us(), std::nullopt);
  header.seq = 2;
  Read(&reader, {ClockOf(header, ClockPhase::kRunning)});
  EXPECT_EQ(reader.epoch_us(), 970'000'000);
  header.seq = 3;
  header.wall_us = 2'000'000'000;
  Read(&reader, {ClockOf(header, ClockPhase::kRunning)});
  EXPECT_EQ(reader.epoch_us(), 970'000'000);
}

TEST(MissionReader, HoldsBackSoMuchAndNoMore) {
  MissionReader reader;
  std::vector<Packet> packets;
  for (std::size_t i = 0; i < MissionReader::kMostHeldBack; ++i) {
    packets.push_back(EventOf(From("world", static_cast<std::int64_t>(i))));
  }
  Read(&reader, packets);
  EXPECT_FALSE(reader.overflowed());
  Read(&reader, {EventOf(From("world", 1'000'000))});
  EXPECT_TRUE(reader.overflowed());
  const Visited visited = Read(&reader, {ScenarioOf(From("world", 2'000'000), Json())});
  ASSERT_EQ(visited.size(), 1 + MissionReader::kMostHeldBack);
  EXPECT_EQ(visited.front().first, kScenario);
  EXPECT_EQ(visited.back().second, MissionReader::kMostHeldBack - 1);
}

}  // namespace
}  // namespace muster
