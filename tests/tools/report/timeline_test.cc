#include "tools/report/timeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "base/sha256.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "tests/tools/fake_mission.h"
#include "tools/record/report_json.h"
#include "tools/report/mission_feed.h"
#include "tools/report/page_chunk.h"

namespace muster::tools {
namespace {

constexpr std::int64_t kMinuteMs = 60'000;

MissionFeed FeedOf(const std::vector<Packet>& packets) {
  MissionFeed feed;
  for (const Packet& packet : packets) feed.Add(packet);
  feed.Finish();
  return feed;
}

Timeline::Stop PlaceAt(const Timeline::Agent& agent, double t_ms) {
  const auto& rows = agent.stops.rows;
  std::size_t i = 0;
  while (i + 1 < rows.size() && static_cast<double>(rows[i + 1].t_ms) <= t_ms) ++i;
  if (i + 1 == rows.size()) return rows[i];
  const double share = (t_ms - static_cast<double>(rows[i].t_ms)) /
                       static_cast<double>(rows[i + 1].t_ms - rows[i].t_ms);
  Timeline::Stop at = rows[i];
  at.x_m += share * (rows[i + 1].x_m - at.x_m);
  at.y_m += share * (rows[i + 1].y_m - at.y_m);
  return at;
}

AgentStatus StatusAt(const Timeline::Agent& agent, std::int64_t t_ms) {
  int status = 0;
  for (const Timeline::Span& span : agent.spans.rows) {
    if (span.t_ms <= t_ms) status = span.status;
  }
  return static_cast<AgentStatus>(status);
}

std::vector<std::pair<std::int64_t, AgentStatus>> SpansOf(const Timeline::Agent& agent) {
  std::vector<std::pair<std::int64_t, AgentStatus>> spans;
  for (const Timeline::Span& s : agent.spans.rows) {
    spans.emplace_back(s.t_ms, static_cast<AgentStatus>(s.status));
  }
  return spans;
}

TEST(Timeline, KnowsWhereAUavWasBetweenTheTicks) {
  const MissionFeed feed = FeedOf(Encoded(MakeFakeMission()));
  ASSERT_TRUE(feed.ready());
  const Timeline::Agent& uav = feed.timeline().agents()[0];
  // Decision 0: from (1, 1) km to (4, 1) by minute 3; decision 1: to (6, 1) by minute 12.
  EXPECT_NEAR(PlaceAt(uav, 1.5 * kMinuteMs).x_m, 2500, 1);
  EXPECT_NEAR(PlaceAt(uav, 3.0 * kMinuteMs).x_m, 4000, 1);
  EXPECT_NEAR(PlaceAt(uav, 9.9 * kMinuteMs).x_m, 4000, 1);
  EXPECT_NEAR(PlaceAt(uav, 11.0 * kMinuteMs).x_m, 5000, 1);
  EXPECT_NEAR(PlaceAt(uav, 25.0 * kMinuteMs).x_m, 6000, 1);
}

TEST(Timeline, KeepsLegsAndNotTicks) {
  // Two legs, sensing and charging: a tenth of the tick changes nothing but a few more kinks.
  const auto coarse = FeedOf(Encoded(MakeFakeMission()));
  const auto fine = FeedOf(Encoded(MakeFakeMission(6'000'000)));
  for (std::size_t i = 0; i < 5; ++i) {
    const auto& stops = fine.timeline().agents()[i].stops.rows;
    EXPECT_LE(stops.size(), 14U) << i;
    EXPECT_LE(coarse.timeline().agents()[i].stops.rows.size(), 14U) << i;
  }
}

TEST(Timeline, SaysExactlyWhatAUavDidWhen) {
  const MissionFeed feed = FeedOf(Encoded(MakeFakeMission()));
  const auto spans = SpansOf(feed.timeline().agents()[0]);
  // It waits from minute 3 for the worker, who comes after the square root of 52 minutes; senses
  // for 2; charges 7 km from minute 12 until 13.167.
  ASSERT_EQ(spans.size(), 7U);
  EXPECT_EQ(spans[0], std::pair(std::int64_t{0}, AgentStatus::kMoving));
  EXPECT_EQ(spans[1], std::pair(3 * kMinuteMs, AgentStatus::kWaiting));
  EXPECT_EQ(spans[2].second, AgentStatus::kSensing);
  EXPECT_NEAR(static_cast<double>(spans[2].first), 7.2111 * kMinuteMs, 10);
  EXPECT_EQ(spans[3].second, AgentStatus::kIdle);
  EXPECT_NEAR(static_cast<double>(spans[3].first), 9.2111 * kMinuteMs, 10);
  EXPECT_EQ(spans[4], std::pair(10 * kMinuteMs, AgentStatus::kMoving));
  EXPECT_EQ(spans[5], std::pair(12 * kMinuteMs, AgentStatus::kCharging));
  EXPECT_EQ(spans[6].second, AgentStatus::kIdle);
  EXPECT_NEAR(static_cast<double>(spans[6].first), 13.1667 * kMinuteMs, 10);
}

TEST(Timeline, OrderOfArrivalAndDoublesChangeNothing) {
  const std::vector<Packet> packets = Encoded(MakeFakeMission());
  PageCursor cursor;
  const std::string expected = PageChunk(FeedOf(packets), "run", &cursor, true)["stops"].dump();
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::vector<Packet> mixed;
    for (std::size_t i = 0; i < packets.size(); ++i) {
      mixed.push_back(packets[i]);
      if (random() % 4 == 0) mixed.push_back(packets[i]);
      // Swaps with one of the last few, as repairs do.
      const std::size_t back = random() % 6;
      if (mixed.size() > back + 1) std::swap(mixed.back(), mixed[mixed.size() - 1 - back]);
    }
    PageCursor again;
    EXPECT_EQ(PageChunk(FeedOf(mixed), "run", &again, true)["stops"].dump(), expected);
  }
}

TEST(Timeline, AgreesWithEveryStateOfTheLog) {
  const FakeLog log = MakeFakeMission(20'000'000);
  const MissionFeed feed = FeedOf(Encoded(log));
  int looked = 0;
  for (const FakeMessage& message : log) {
    const auto* states = std::get_if<agent_states_t>(&message.body);
    if (states == nullptr) continue;
    const auto kind = static_cast<AgentKind>(states->kind);
    for (const agent_t& a : states->agents) {
      const Timeline::Agent& agent =
          feed.timeline().agents()[feed.timeline().IndexOf(kind, static_cast<std::size_t>(a.id))];
      const double t_ms = static_cast<double>(states->header.sim_us) / 1000;
      EXPECT_NEAR(PlaceAt(agent, t_ms).x_m, a.x_m, 1.5);
      EXPECT_NEAR(PlaceAt(agent, t_ms).y_m, a.y_m, 1.5);
      // A decision takes effect at its tick's time, after the states of that tick were said.
      if (states->header.sim_us % 600'000'000 != 0) {
        EXPECT_EQ(StatusAt(agent, states->header.sim_us / 1000), static_cast<AgentStatus>(a.status))
            << ToString(kind) << a.id << " at " << t_ms;
      }
      ++looked;
    }
  }
  EXPECT_GT(looked, 300);
}

/// What tools/report/page/src/run.js does with a chunk's rows, for one kind of list.
void Apply(nlohmann::json* lists, const nlohmann::json& chunk, const char* key, std::size_t width) {
  for (const auto& [index, from, rows] :
       chunk.value(key, std::vector<std::tuple<std::size_t, std::size_t, nlohmann::json>>())) {
    auto& list = (*lists)[index];
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(from * width), list.end());
    for (const auto& value : rows) list.push_back(value);
  }
}

/// The feed of all that is said until `until_us`, with no state of the UAVs at ticks 4 to 6.
MissionFeed FeedWithAGap(std::int64_t until_us,
                         const std::function<void(agent_states_t&)>& edit_after) {
  FakeLog log = MakeFakeMission();
  MissionFeed feed;
  for (FakeMessage& message : log) {
    if (message.header().sim_us > until_us) continue;
    if (auto* states = std::get_if<agent_states_t>(&message.body);
        states != nullptr && static_cast<AgentKind>(states->kind) == AgentKind::kUav) {
      if (states->tick >= 4 && states->tick <= 6) continue;
      if (states->tick > 6) edit_after(*states);
    }
    feed.Add(message.Encoded());
  }
  return feed;
}

TEST(Timeline, AProcessThatReturnsIsShownAtOnce) {
  const auto last_ms = [](const MissionFeed& feed) {
    return feed.timeline().agents()[0].stops.rows.back().t_ms;
  };
  const std::int64_t tick_us = 60'000'000;
  const auto restarted = [](agent_states_t& states) { states.header.boot_id = 1; };
  EXPECT_EQ(last_ms(FeedWithAGap(7 * tick_us, restarted)), 7 * kMinuteMs);
  // Not started again, it was stopped or cut off: shown when the gap is older than any repair.
  const auto cut_off = [](agent_states_t& states) {
    states.header.wall_us += 1'000'000 * states.tick;
  };
  EXPECT_EQ(last_ms(FeedWithAGap(8 * tick_us, cut_off)), 3 * kMinuteMs);
  EXPECT_EQ(last_ms(FeedWithAGap(10 * tick_us, cut_off)), 10 * kMinuteMs);
}

TEST(Timeline, AgentsOfALostProcessHaveFailedUntilItReturns) {
  FakeLog log = MakeFakeMission();
  const std::int64_t lost_us = 3 * 60'000'000 + 1;
  ForEach<rulings_t>(&log, [&](rulings_t& rulings) {
    if (rulings.tick < 4 || rulings.tick > 6) return;
    rulings.rulings = {{static_cast<std::int8_t>(AgentKind::kUav), 0,
                        static_cast<std::int8_t>(RulingKind::kLost), lost_us}};
    rulings.n = 1;
  });
  MissionFeed feed;
  for (FakeMessage& message : log) {
    auto* states = std::get_if<agent_states_t>(&message.body);
    if (states != nullptr && static_cast<AgentKind>(states->kind) == AgentKind::kUav) {
      if (states->tick >= 4 && states->tick <= 6) continue;
      if (states->tick > 6) states->header.boot_id = 1;
    }
    feed.Add(message.Encoded());
  }
  feed.Finish();
  const Timeline::Agent& uav = feed.timeline().agents()[0];
  EXPECT_NE(StatusAt(uav, 3 * kMinuteMs - 1), AgentStatus::kFailed);
  EXPECT_EQ(StatusAt(uav, 3 * kMinuteMs + 1000), AgentStatus::kFailed);
  EXPECT_EQ(StatusAt(uav, 6 * kMinuteMs), AgentStatus::kFailed);
  EXPECT_EQ(StatusAt(uav, 7 * kMinuteMs), AgentStatus::kWaiting);
}

TEST(Timeline, ATickAfterTheLastIsNone) {
  std::vector<Packet> packets = Encoded(MakeFakeMission());
  PageCursor cursor;
  const std::string expected = PageChunk(FeedOf(packets), "run", &cursor, true)["stops"].dump();
  for (std::size_t i = 0; i < packets.size(); ++i) {
    auto states = DecodeValid<agent_states_t>(packets[i].bytes);
    if (packets[i].channel != channel::kUavs || !states) continue;
    for (const std::int64_t tick : {std::int64_t{1} << 55, states->tick + 1000}) {
      states->tick = tick;
      states->header.seq += 1000;
      for (agent_t& agent : states->agents) agent.x_m += 1;
      packets.insert(packets.begin() + static_cast<std::ptrdiff_t>(i),
                     {packets[i].channel, Encode(*states)});
    }
    break;
  }
  PageCursor again;
  EXPECT_EQ(PageChunk(FeedOf(packets), "run", &again, true)["stops"].dump(), expected);
}

TEST(PageChunk, PartsAddUpToTheWhole) {
  const std::vector<Packet> packets = Encoded(MakeFakeMission());
  PageCursor whole_cursor;
  const nlohmann::json whole = PageChunk(FeedOf(packets), "run", &whole_cursor, true);

  MissionFeed feed;
  PageCursor cursor;
  nlohmann::json stops(5, nlohmann::json::array()), spans = stops;
  nlohmann::json tasks(2, nlohmann::json::array());
  std::size_t parts = 0;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    feed.Add(packets[i]);
    if (i + 1 == packets.size()) feed.Finish();
    if (!feed.ready() || (i % 7 != 0 && i + 1 != packets.size())) continue;
    const nlohmann::json chunk = PageChunk(feed, "run", &cursor, false);
    EXPECT_EQ(chunk.contains("scenario"), parts == 0);
    Apply(&stops, chunk, "stops", 4);
    Apply(&spans, chunk, "spans", 2);
    Apply(&tasks, chunk, "tasks", 2);
    ++parts;
  }
  EXPECT_GT(parts, 20U);
  for (const auto& [key, lists] :
       {std::pair("stops", stops), std::pair("spans", spans), std::pair("tasks", tasks)}) {
    for (const auto& row : whole[key]) EXPECT_EQ(lists[row[0].get<std::size_t>()], row[2]) << key;
  }
  const nlohmann::json silence = PageChunk(feed, "run", &cursor, false);
  EXPECT_FALSE(silence.contains("stops") || silence.contains("spans") || silence.contains("done") ||
               silence.contains("decisions") || silence.contains("events"))
      << silence;
}

TEST(PageChunk, HasTheNumbersOfTheReport) {
  const MissionFeed feed = FeedOf(Encoded(MakeFakeMission()));
  PageCursor cursor;
  const nlohmann::json chunk = PageChunk(feed, "name", &cursor, true);
  const nlohmann::json report = Report(feed.record());
  for (const char* key : {"completion_rate", "tasks_done", "charges", "flown_m", "digest", "policy",
                          "seed", "decision_time", "log", "processes", "faults"}) {
    EXPECT_EQ(chunk["report"][key], report[key]) << key;
  }
  EXPECT_EQ(chunk["name"], "name");
  ASSERT_EQ(chunk["decisions"][1].size(), 3U);
  EXPECT_EQ(chunk["decisions"][1][2][2], report["decisions"][2]["weight"]);
  EXPECT_EQ(chunk["done"][1].back(), 2);
}

TEST(PageChunk, NamesTheNumbersOfItsRows) {
  FakeLog log = MakeFakeMission();
  fault_t fault{};
  fault.header = log.back().header();
  fault.fault_id = "f";
  fault.kind = NumberOf(FaultKind::kForeign);
  log.push_back({std::string(channel::kFault), fault});
  Renumber(&log);
  PageCursor cursor;
  const nlohmann::json chunk = PageChunk(FeedOf(Encoded(log)), "name", &cursor, false);
  EXPECT_EQ(chunk["faults"][0][1], "foreign");
  EXPECT_EQ(chunk["events"][1][0][0], "agent_online");
  EXPECT_EQ(chunk["words"]["agents"], nlohmann::json({"uav", "worker", "vehicle"}));
  EXPECT_EQ(chunk["words"]["statuses"][6], "failed");
  EXPECT_EQ(chunk["words"]["tasks"][1], "reserved");
  EXPECT_EQ(chunk["words"]["actions"][8], "UiCyVk");
}

/// The fake mission with tasks in time, its scenario as `edit` makes it.
MissionFeed OpenFeed(const std::function<void(nlohmann::json&)>& edit) {
  FakeLog log = MakeFakeMission();
  ForEach<scenario_t>(&log, [&](scenario_t& scenario) {
    nlohmann::json json = nlohmann::json::parse(scenario.json);
    json["version"] = 2;
    json["tasks"][0]["due_min"] = 20;
    edit(json);
    scenario.json = json.dump();
    scenario.sha256 = Sha256(scenario.json);
  });
  return FeedOf(Encoded(log));
}

TEST(PageChunk, TellsWhatOrdersHaveMadeOfTheScenario) {
  const MissionFeed before = OpenFeed([](nlohmann::json&) {});
  const MissionFeed after = OpenFeed([](nlohmann::json& json) {
    json["tasks"][1].update({{"x_km", 1.5}, {"y_km", 2.5}, {"priority", 3}, {"due_min", 10}});
    json["tasks"][1]["name"] = "school";
    json["uavs"][1]["full_range_km"] = 42;
    json["workers"][0]["online_until_min"] = 29;
  });
  const auto told = [](const MissionFeed& feed, PageCursor* cursor) -> nlohmann::json {
    return PageChunk(feed, "name", cursor, false);
  };
  PageCursor cursor;
  EXPECT_FALSE(told(before, &cursor).contains("task_rows")) << "the first chunk has all";
  nlohmann::json chunk = told(before, &cursor);
  EXPECT_FALSE(chunk.contains("task_rows") || chunk.contains("agent_rows")) << "nothing is other";
  chunk = told(after, &cursor);
  EXPECT_EQ(chunk["task_rows"],
            nlohmann::json::parse(R"([[1, 1500, 2500, 2000, 0, 600000, null, 3, "school"]])"));
  EXPECT_EQ(chunk["agent_rows"], nlohmann::json::parse("[[1, 42000], [2, 0]]"));
  chunk = told(after, &cursor);
  EXPECT_FALSE(chunk.contains("task_rows") || chunk.contains("agent_rows")) << "each once";
  PageCursor late;
  chunk = told(after, &late);
  EXPECT_EQ(chunk["scenario"]["tasks"][3], 1500) << "who comes late is told how it stands";
  EXPECT_FALSE(chunk.contains("task_rows"));
}

TEST(PageChunk, SaysHowManyAgentsAreVacant) {
  const MissionFeed feed = OpenFeed([](nlohmann::json& json) {
    json["workers"][1]["online_from_min"] = json["workers"][1]["online_until_min"] = 0;
  });
  PageCursor cursor;
  const nlohmann::json chunk = PageChunk(feed, "name", &cursor, false);
  EXPECT_EQ(chunk["scenario"]["vacant"], nlohmann::json({0, 1, 0}));
  EXPECT_EQ(chunk["scenario"]["task_times"][0], nlohmann::json({0, 1'200'000, nullptr, 1, ""}));
  EXPECT_FALSE(chunk.contains("task_rows") || chunk.contains("agent_rows"));
  PageCursor again;
  const nlohmann::json whole = PageChunk(FeedOf(Encoded(MakeFakeMission())), "name", &again, false);
  EXPECT_FALSE(whole["scenario"].contains("vacant")) << "of missions that are not open";
}

TEST(PageChunk, LeavesOutADecisionThatNeverWasInForce) {
  FakeLog log = MakeFakeMission();
  ForEach<clock_t>(&log, [](clock_t& clock) {
    if (clock.required_decision == 1) clock.required_decision = 0;
  });
  const MissionFeed feed = FeedOf(Encoded(log));
  PageCursor cursor;
  const nlohmann::json chunk = PageChunk(feed, "name", &cursor, true);
  ASSERT_EQ(chunk["report"]["skipped_decisions"], nlohmann::json({1}));
  ASSERT_EQ(chunk["decisions"][1].size(), 2U);
  EXPECT_EQ(chunk["decisions"][1][0][0], 0);
  EXPECT_EQ(chunk["decisions"][1][1][0], 2);
}

}  // namespace
}  // namespace muster::tools
