#include "tools/record/run_record.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lcmtypes/channels.h"
#include "tests/tools/fake_mission.h"
#include "tests/tools/record/record_of.h"
#include "tools/record/digest.h"
#include "tools/record/summary.h"

namespace muster::tools {
namespace {

bool IsStates(const FakeMessage& message, std::string_view on, std::int64_t tick) {
  const auto* states = std::get_if<agent_states_t>(&message.body);
  return states != nullptr && message.channel == on && states->tick == tick;
}

TEST(RunRecord, GathersAWholeMission) {
  const FakeLog log = MakeFakeMission();
  const RunRecord record = RecordOf(log);
  ASSERT_TRUE(record.scenario());
  EXPECT_EQ(record.run_id(), 7);
  EXPECT_EQ(record.counts().messages, static_cast<std::int64_t>(log.size()));
  EXPECT_EQ(record.counts().duplicates, 0);
  EXPECT_EQ(record.schedules().size(), 3u);
  // 5 agents online, 3 activities that start and end.
  EXPECT_EQ(record.events().size(), 11u);
  EXPECT_EQ(record.processes().size(), 5u);
  ASSERT_TRUE(record.final_world());
  EXPECT_EQ(record.final_world()->done, 2);
  EXPECT_TRUE(record.CheckComplete().complete);
  // From 1 s to 1 s + 1800 ms of wall time.
  EXPECT_DOUBLE_EQ(record.wall_s(), 1.8);
}

TEST(RunRecord, WallTimeDoesNotCountAClockThatIsSet) {
  constexpr std::int64_t kDayUs = 24 * 60 * kMinuteUs;
  for (const bool is_forward : {true, false}) {
    FakeLog log = MakeFakeMission();
    ForEach<clock_t>(&log, [&](clock_t& clock) {
      if ((clock.tick >= 10) == is_forward) clock.header.wall_us += kDayUs;
    });
    // 1.8 s in steps of 60 ms, but for one.
    EXPECT_DOUBLE_EQ(RecordOf(log).wall_s(), 1.74);
  }
}

TEST(RunRecord, AddsUpTheFlownWayAndKeepsTheLastRange) {
  const RunRecord record = RecordOf(MakeFakeMission());
  // UAV 0: 3 km to task 0, 2 km to the charging point, then full; UAV 1: 1 km, then sqrt(73) km.
  EXPECT_NEAR(record.tracks()[0].length_m(), 5000, 1e-6);
  EXPECT_NEAR(record.tracks()[1].length_m(), 1000 + 1000 * std::sqrt(73.0), 1e-6);
  EXPECT_DOUBLE_EQ(record.tracks()[0].final_range_m(), 30000);
  EXPECT_NEAR(record.tracks()[1].final_range_m(), 27000 - 1000 * std::sqrt(73.0), 1e-6);
}

TEST(RunRecord, DropsDuplicates) {
  std::vector<Packet> packets = Encoded(MakeFakeMission());
  const std::size_t n = packets.size();
  for (std::size_t i = 0; i < n; i += 3) packets.push_back(packets[i]);
  const RunRecord record = RecordOf(packets);
  EXPECT_EQ(record.counts().messages, static_cast<std::int64_t>(n));
  EXPECT_EQ(record.counts().duplicates, static_cast<std::int64_t>((n + 2) / 3));
  EXPECT_EQ(record.events().size(), 11u);
  EXPECT_TRUE(record.CheckComplete().complete);
}

TEST(RunRecord, GivesTheSameInAnyOrder) {
  std::vector<Packet> packets = Encoded(MakeFakeMission());
  const RunRecord sorted = RecordOf(packets);
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    std::shuffle(packets.begin(), packets.end(), random);
    const RunRecord record = RecordOf(packets);
    EXPECT_EQ(Digest(record), Digest(sorted)) << "round " << round;
    EXPECT_TRUE(record.CheckComplete().complete) << "round " << round;
    EXPECT_EQ(record.tracks()[1].length_m(), sorted.tracks()[1].length_m());
    EXPECT_EQ(record.wall_s(), sorted.wall_s());
  }
}

TEST(RunRecord, LeavesOutOtherRunsGarbageAndForeignChannels) {
  std::vector<Packet> packets = Encoded(MakeFakeMission());
  FakeLog other = MakeFakeMission();
  for (FakeMessage& message : other) message.header().run_id = 8;
  const std::vector<Packet> strangers = Encoded(other);
  packets.insert(packets.end(), strangers.begin(), strangers.end());
  packets.push_back({std::string(channel::kWorld), {1, 2, 3}});
  packets.push_back({std::string(channel::kWorld), {}});
  packets.push_back({"CAMERA", {1}});
  const RunRecord record = RecordOf(packets);
  EXPECT_EQ(record.counts().strangers, static_cast<std::int64_t>(other.size()));
  EXPECT_EQ(record.counts().undecodable, 2);
  EXPECT_EQ(record.counts().foreign, 1);
  EXPECT_EQ(Digest(record), Digest(RecordOf(MakeFakeMission())));
}

TEST(RunRecord, KnowsItsRunWhenTold) {
  std::vector<Packet> packets = Encoded(MakeFakeMission());
  FakeLog other = MakeFakeMission();
  for (FakeMessage& message : other) message.header().run_id = 8;
  const std::vector<Packet> strangers = Encoded(other);
  packets.insert(packets.begin(), strangers.begin(), strangers.end());
  RunRecord record(7);
  for (const Packet& packet : packets) record.Add(packet);
  EXPECT_EQ(record.counts().strangers, static_cast<std::int64_t>(other.size()));
  EXPECT_TRUE(record.CheckComplete().complete);
}

TEST(RunRecord, ListsGapsAndTheTicksThatTheyHide) {
  FakeLog log = MakeFakeMission();
  std::int64_t first = -1, last = -1;
  std::erase_if(log, [&](FakeMessage& message) {
    if (!IsStates(message, channel::kWorkers, 4) && !IsStates(message, channel::kWorkers, 5)) {
      return false;
    }
    (IsStates(message, channel::kWorkers, 4) ? first : last) = message.header().seq;
    return true;
  });
  const RunRecord::Completeness result = RecordOf(log).CheckComplete();
  EXPECT_FALSE(result.complete);
  ASSERT_EQ(result.gaps.size(), 1u);
  EXPECT_EQ(result.gaps[0].sender, "worker");
  EXPECT_EQ(result.gaps[0].boot_id, 0);
  EXPECT_EQ(result.gaps[0].first_seq, first);
  EXPECT_EQ(result.gaps[0].last_seq, last);
  EXPECT_EQ(result.n_missing, 4);
  ASSERT_EQ(result.missing.size(), 2u);
  EXPECT_EQ(result.missing[0].owner, "worker:0");
  EXPECT_EQ(result.missing[0].first_tick, 4);
  EXPECT_EQ(result.missing[0].last_tick, 5);
  EXPECT_EQ(result.missing[1].owner, "worker:1");
}

TEST(RunRecord, SeesEveryKindOfMissingMessageWithoutAGap) {
  const struct {
    const char* owner;
    std::function<bool(const FakeMessage&)> missing;
  } cases[] = {
      {"clock",
       [](const FakeMessage& m) {
         const auto* c = std::get_if<clock_t>(&m.body);
         return c != nullptr && c->tick == 6;
       }},
      {"world",
       [](const FakeMessage& m) {
         const auto* w = std::get_if<world_state_t>(&m.body);
         return w != nullptr && w->tick == 6;
       }},
      {"rulings",
       [](const FakeMessage& m) {
         const auto* r = std::get_if<rulings_t>(&m.body);
         return r != nullptr && r->tick == 6;
       }},
      {"schedule",
       [](const FakeMessage& m) {
         const auto* s = std::get_if<schedule_t>(&m.body);
         return s != nullptr && s->decision == 1;
       }},
      {"end",
       [](const FakeMessage& m) {
         const auto* c = std::get_if<clock_t>(&m.body);
         return c != nullptr && c->phase == 2;
       }},
      {"vehicle:0", [](const FakeMessage& m) { return IsStates(m, channel::kVehicles, 30); }},
  };
  for (const auto& c : cases) {
    FakeLog log = MakeFakeMission();
    std::erase_if(log, c.missing);
    Renumber(&log);
    const RunRecord::Completeness result = RecordOf(log).CheckComplete();
    EXPECT_FALSE(result.complete) << c.owner;
    EXPECT_TRUE(result.gaps.empty()) << c.owner;
    ASSERT_EQ(result.missing.size(), 1u) << c.owner;
    EXPECT_EQ(result.missing[0].owner, c.owner);
    EXPECT_EQ(result.n_missing, 1) << c.owner;
  }
}

TEST(RunRecord, AsksAMissionWithoutAnEndForNothingThatNeverWas) {
  constexpr std::int64_t kStopped = 12;
  FakeLog log = MakeFakeMission();
  std::erase_if(log, [](FakeMessage& m) {
    return m.channel != channel::kScenario && m.header().sim_us > kStopped * 60'000'000;
  });
  // The newest tick was under way: not everybody had told of it.
  std::erase_if(log,
                [](const FakeMessage& m) { return IsStates(m, channel::kVehicles, kStopped); });
  Renumber(&log);
  const RunRecord record = RecordOf(log);
  const RunRecord::Completeness result = record.CheckComplete();
  EXPECT_FALSE(result.complete);
  EXPECT_FALSE(result.ended);
  EXPECT_EQ(result.last_tick, kStopped - 1);
  ASSERT_EQ(result.missing.size(), 1u);
  EXPECT_EQ(result.missing[0].owner, "end");
  EXPECT_EQ(result.n_missing, 1);
  EXPECT_NE(Summary(record).find("; ends at 11.0 of 30 min, all until then is there\n"),
            std::string::npos)
      << Summary(record);
  // What is missing before it still is.
  std::erase_if(log, [](const FakeMessage& m) { return IsStates(m, channel::kVehicles, 5); });
  Renumber(&log);
  EXPECT_EQ(RecordOf(log).CheckComplete().missing[0].owner, "vehicle:0");
}

TEST(RunRecord, TakesTheSameTickFromARestartedProcessOnly) {
  FakeLog log = MakeFakeMission();
  FakeLog tail;
  for (FakeMessage& message : log) {
    if (!IsStates(message, channel::kUavs, 12)) continue;
    tail.push_back(message);
    tail.back().header().boot_id = 1;
  }
  ASSERT_EQ(tail.size(), 1u);
  FakeLog restarted = log;
  restarted.push_back(tail[0]);
  for (FakeMessage& message : restarted) {
    const auto* states = std::get_if<agent_states_t>(&message.body);
    if (message.channel == channel::kUavs && states->tick > 12) message.header().boot_id = 1;
  }
  Renumber(&restarted);
  const RunRecord::Completeness again = RecordOf(restarted).CheckComplete();
  EXPECT_EQ(again.repeated, 0);
  EXPECT_TRUE(again.gaps.empty());

  FakeLog twice = log;
  twice.push_back(tail[0]);
  twice.back().header().boot_id = 0;
  Renumber(&twice);
  EXPECT_EQ(RecordOf(twice).CheckComplete().repeated, 2);

  FakeLog overlap = log;
  overlap.push_back(tail[0]);
  overlap.back().header().sender = "uav-2";
  Renumber(&overlap);
  EXPECT_EQ(RecordOf(overlap).CheckComplete().repeated, 2);
}

TEST(RunRecord, TakesEventsThatARestartedWorldSaysAgainOnce) {
  FakeLog log = MakeFakeMission();
  FakeLog again;
  for (const FakeMessage& message : log) {
    if (message.channel != channel::kEvent) continue;
    again.push_back(message);
    again.back().header().boot_id = 1;
  }
  log.insert(log.end(), again.begin(), again.end());
  Renumber(&log);
  EXPECT_EQ(RecordOf(log).events().size(), 11u);
}

/// The reason that a driver gave is lost with the world and the process that knew it.
TEST(RunRecord, TakesWhatARestartedWorldSaysInOtherWordsOnce) {
  FakeLog log = MakeFakeMission();
  FakeLog again;
  for (FakeMessage& message : log) {
    if (message.channel != channel::kEvent || message.header().sender != process_name::kWorld) {
      continue;
    }
    again.push_back(message);
    again.back().header().boot_id = 1;
    std::get<event_t>(again.back().body).detail += " once more";
  }
  ASSERT_FALSE(again.empty());
  const auto before = RecordOf(log).events();
  log.insert(log.end(), again.begin(), again.end());
  Renumber(&log);
  const auto after = RecordOf(log).events();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(after[i].detail, before[i].detail);
}

TEST(RunRecord, IgnoresMessagesThatDoNotFitTheScenario) {
  FakeLog log = MakeFakeMission();
  const std::string before = Digest(RecordOf(log));
  for (const FakeMessage& message : FakeLog(log)) {
    FakeMessage bad = message;
    if (IsStates(message, channel::kUavs, 3)) {
      std::get<agent_states_t>(bad.body).agents[1].id = 2;
    } else if (auto* world = std::get_if<world_state_t>(&bad.body); world && world->tick == 30) {
      world->task_status = {0, 0, 0};
      world->n_tasks = 3;
    } else if (auto* schedule = std::get_if<schedule_t>(&bad.body)) {
      schedule->decision += 3;
    } else if (auto* clock = std::get_if<clock_t>(&bad.body); clock && clock->tick == 30) {
      clock->tick = 1'000'000'000'000;
    } else {
      continue;
    }
    log.push_back(bad);
  }
  Renumber(&log);
  const RunRecord record = RecordOf(log);
  EXPECT_EQ(Digest(record), before);
  // UAV states, world, three schedules; the clocks of phase 1 and 2.
  EXPECT_EQ(record.counts().undecodable, 7);
}

TEST(RunRecord, WithoutAScenarioIsNotComplete) {
  FakeLog log = MakeFakeMission();
  std::erase_if(log, [](const FakeMessage& m) { return m.channel == channel::kScenario; });
  const RunRecord::Completeness result = RecordOf(log).CheckComplete();
  EXPECT_FALSE(result.complete);
  ASSERT_EQ(result.missing.size(), 1u);
  EXPECT_EQ(result.missing[0].owner, "scenario");
}

TEST(RunRecord, DamageMakesItIncomplete) {
  RunRecord record = RecordOf(MakeFakeMission());
  record.NoteDamage("mission.lcm: torn at byte 1234");
  EXPECT_FALSE(record.CheckComplete().complete);
}

TEST(Track, BoundsItsWindowAndForgivesALateTick) {
  const Scenario scenario;
  Track track(scenario);
  for (int tick = 0; tick < 1000; ++tick) {
    if (tick != 500) track.Add(tick, {static_cast<double>(tick), 0}, 10);
    if (tick == 530) track.Add(500, {500, 3}, 10);   // in the window: counts
    if (tick == 900) track.Add(400, {400, 50}, 10);  // long summed up: does not
  }
  EXPECT_NEAR(track.length_m(), 997 + 2 * std::sqrt(1 + 9.0), 1e-9);
  EXPECT_EQ(track.final_tick(), 999);
}

}  // namespace
}  // namespace muster::tools
