#include "tools/top/attention.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "base/sha256.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/tools/fake_mission.h"
#include "tools/report/mission_feed.h"
#include "tools/top/approach.h"
#include "tools/top/top_view.h"

namespace muster::tools {
namespace {

std::vector<std::string> Told(const FakeLog& log, const std::vector<std::string>& silent = {}) {
  MissionFeed feed;
  for (const Packet& packet : Encoded(log)) feed.Add(packet);
  feed.Finish();
  std::vector<std::string> told;
  for (const Concern& c : Attention(feed.timeline(), silent)) {
    told.push_back(fmt::format("{}: {} {}", c.kind, c.who, c.note));
  }
  return told;
}

TEST(Attention, TellsNothingOfAMissionThatWentWell) {
  EXPECT_EQ(Told(MakeFakeMission()), std::vector<std::string>());
}

TEST(Attention, PutsTheMostHarmfulFirst) {
  FakeLog log = MakeFakeMission();
  ForEach<agent_states_t>(&log, [](agent_states_t& states) {
    for (agent_t& agent : states.agents) {
      if (states.tick < 20) continue;
      if (states.kind == NumberOf(AgentKind::kWorker) && agent.id == 0) {
        agent.status = NumberOf(AgentStatus::kFailed);
      }
      if (states.kind == NumberOf(AgentKind::kWorker) && agent.id == 1) {
        agent.status = NumberOf(AgentStatus::kWaiting);
      }
      if (states.kind == NumberOf(AgentKind::kUav)) {
        agent.status = NumberOf(AgentStatus::kIdle);
        agent.range_left_m = agent.id == 0 ? 0 : 0.1 * agent.range_full_m;
        if (agent.id == 0) agent.x_m = 0;
        if (agent.id == 1) agent.x_m = 6000;
        if (agent.id == 1) agent.y_m = 1000;
      }
    }
  });
  ForEach<world_state_t>(&log, [](world_state_t& world) {
    for (auto& status : world.task_status) status = 0;
  });
  const std::vector<std::string> told = Told(log, {"vehicle"});
  ASSERT_EQ(told.size(), 7u) << fmt::format("{}", fmt::join(told, "\n"));
  EXPECT_EQ(told[0], "processes silent: vehicle ");
  EXPECT_TRUE(told[1].starts_with("agents failed: worker:0 since 0:")) << told[1];
  EXPECT_TRUE(told[2].starts_with("cannot reach a charging point: uav:0 0.0 km left")) << told[2];
  EXPECT_EQ(told[3], "tasks not done: task 0 ");
  EXPECT_EQ(told[4], "tasks not done: task 1 ");
  EXPECT_TRUE(told[5].starts_with("waiting for a partner: worker:1 for ")) << told[5];
  EXPECT_TRUE(told[6].starts_with("low range: uav:1 ")) << told[6];
}

Flying FlyingOf(const nlohmann::json& numbers) {
  return {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]};
}

TEST(Approach, IsThatOfTheSharedTable) {
  std::ifstream file(MUSTER_SOURCE_DIR "/tests/tools/top/approaches.json");
  for (const nlohmann::json& one : nlohmann::json::parse(file)) {
    SCOPED_TRACE(one["what"]);
    for (const bool turned : {false, true}) {
      const auto approach = turned
                                ? ApproachOf(FlyingOf(one["b"]), FlyingOf(one["a"]), Separation())
                                : ApproachOf(FlyingOf(one["a"]), FlyingOf(one["b"]), Separation());
      ASSERT_EQ(approach.has_value(), one.contains("note"));
      if (!approach) continue;
      EXPECT_NEAR(approach->in_s, one["in_s"], 1e-9);
      EXPECT_NEAR(approach->across_m, one["across_m"], 1e-9);
      EXPECT_NEAR(approach->up_m, one["up_m"], 1e-9);
      EXPECT_EQ(ToText(*approach), one["note"]);
    }
  }
}

/// All UAVs fly at one altitude, apart from each other. The measured one says that it is 20 m
/// beside another one.
TEST(Attention, AMeasuredUavThatStraysNearAnotherIsNamedBeforehand) {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  auto air = std::make_shared<ScenarioAir>();
  air->separation->ceiling_m = air->separation->lowest_m;
  scenario.air = air;
  std::vector<Message> messages;
  Simulate(TextOf(scenario), "horizon", [&](const Packet& packet) {
    if (auto message = DecodeMessage(packet)) messages.push_back(std::move(*message));
  });
  scenario.uavs[15].measured = true;
  // Decision 1, at minute 10, sends uav:3 and uav:15.
  const auto at_minute_12 = [&](bool strays) {
    auto timeline = std::make_unique<Timeline>(scenario);
    for (Message message : messages) {
      if (HeaderOf(message).sim_us > 12 * kMinuteUs) break;
      if (auto* states = std::get_if<agent_states_t>(&message)) {
        if (strays && states->kind == NumberOf(AgentKind::kUav) && states->tick > 21) {
          states->agents[15].x_m = states->agents[3].x_m + 20;
          states->agents[15].y_m = states->agents[3].y_m;
        }
      }
      timeline->Add(message);
    }
    return timeline;
  };
  EXPECT_TRUE(NearPairs(*at_minute_12(false)).empty());
  const auto strayed = at_minute_12(true);
  const std::vector<NearPair> pairs = NearPairs(*strayed);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].a, 15);
  EXPECT_EQ(pairs[0].b, 3);
  EXPECT_LE(pairs[0].approach.across_m, 20);
  const std::vector<Concern> concerns = Attention(*strayed, {});
  ASSERT_FALSE(concerns.empty());
  EXPECT_EQ(concerns[0].kind, "UAVs come too close");
  EXPECT_EQ(concerns[0].who, "uav:15 and uav:3");
  const auto picture = AirPictureOf(*strayed);
  ASSERT_TRUE(picture && picture->nearest);
  EXPECT_EQ(picture->n, 2u);
  EXPECT_EQ(picture->lowest_m, 30);
  EXPECT_EQ(picture->highest_m, 30);
  EXPECT_NEAR(picture->nearest->approach.across_m, 20, 0.5);
}

/// The fake mission until a minute, its tasks as `edit` makes them.
FakeLog Timed(const std::function<void(nlohmann::json&)>& edit, std::int64_t until_min) {
  FakeLog log = MakeFakeMission();
  ForEach<scenario_t>(&log, [&](scenario_t& scenario) {
    nlohmann::json json = nlohmann::json::parse(scenario.json);
    json["version"] = 2;
    edit(json["tasks"]);
    scenario.json = json.dump();
    scenario.sha256 = Sha256(scenario.json);
  });
  std::erase_if(
      log, [&](FakeMessage& message) { return message.header().sim_us > until_min * 60'000'000; });
  Renumber(&log);
  return log;
}

TEST(Attention, ATaskIsAtRiskWhenItsStartIsTooLateOrNobodyIsOnTheWay) {
  // Task 0 is reserved and begins after 7.2 minutes; nobody is sent to task 1 before minute 10.
  const auto told = [](double due0, double due1, int priority1, std::int64_t until_min) {
    return Told(Timed(
        [&](nlohmann::json& tasks) {
          if (due0 > 0) tasks[0]["due_min"] = due0;
          if (due1 > 0) tasks[1]["due_min"] = due1;
          tasks[1]["priority"] = priority1;
        },
        until_min));
  };
  using Lines = std::vector<std::string>;
  EXPECT_EQ(told(8, 25, 1, 4), Lines()) << "in time, and not soon";
  EXPECT_EQ(told(5, 0, 1, 4), Lines({"tasks at risk: task 0 starts at 0:07:12, 2 min too late"}));
  EXPECT_EQ(told(5, 6, 1, 4), Lines({"tasks at risk: task 1 due in 2 min, nobody is on the way",
                                     "tasks at risk: task 0 starts at 0:07:12, 2 min too late"}));
  EXPECT_EQ(told(5, 6, 0, 4),
            Lines({"tasks at risk: task 0 starts at 0:07:12, 2 min too late",
                   "tasks at risk: task 1 low, due in 2 min, nobody is on the way"}))
      << "priority weighs most";
  EXPECT_EQ(told(0, 2, 3, 4),
            Lines({"tasks at risk: task 1 emergency, was due 2 min ago, nobody is on the way"}));
}

/// The page's attention.test.mjs holds `timeRisk` to the same cases.
TEST(Attention, RisksAreThoseOfTheCasesThatThePageHasToo) {
  std::ifstream in(MUSTER_SOURCE_DIR "/tests/tools/top/task_risks.json");
  const auto cases = nlohmann::json::parse(in);
  std::size_t risks = 0;
  for (const auto& one : cases) {
    SCOPED_TRACE(one.dump());
    const auto time = [&](const char* key) {
      return static_cast<TimeUs>(one.at(key).get<double>() * static_cast<double>(kMinuteUs));
    };
    Task task;
    if (one.contains("due_min")) task.due_us = time("due_min");
    if (one.contains("expires_min")) task.expires_us = time("expires_min");
    const auto status = FromString<TaskStatus>(one.at("status").get<std::string>());
    ASSERT_TRUE(status);
    const auto start = one.contains("start_min") ? std::optional(time("start_min")) : std::nullopt;
    const auto risk = RiskOf(task, *status, start, time("now_min"), time("interval_min"));
    ASSERT_EQ(risk.has_value(), one.contains("harm"));
    if (!risk) continue;
    EXPECT_NEAR(risk->harm, one.at("harm").get<double>(), 1e-9);
    EXPECT_EQ(risk->note, one.at("note").get<std::string>());
    ++risks;
  }
  EXPECT_GT(risks, 8u);
}

/// The page's attention.test.mjs holds `troubleOf` to the same cases.
TEST(Attention, TroublesAreThoseOfTheCasesThatThePageHasToo) {
  std::ifstream in(MUSTER_SOURCE_DIR "/tests/tools/top/agent_troubles.json");
  const auto cases = nlohmann::json::parse(in);
  constexpr const char* kNames[] = {"failed", "stranded", "wait", "range"};
  std::size_t troubles = 0;
  for (const auto& one : cases) {
    SCOPED_TRACE(one.dump());
    const auto us = [&](const char* key) {
      return static_cast<TimeUs>(one.at(key).get<double>() * static_cast<double>(kMinuteUs));
    };
    const auto nearest = [&]() -> std::optional<double> {
      if (!one.contains("nearest_km")) return {};
      return 1000 * one.at("nearest_km").get<double>();
    };
    const auto kind = FromString<AgentKind>(one.at("class").get<std::string>());
    const auto status = FromString<AgentStatus>(one.at("status").get<std::string>());
    ASSERT_TRUE(kind && status);
    const auto trouble =
        TroubleOf(*kind, *status, us("since_min"), us("now_min"), 1000 * one.value("range_km", 0.0),
                  1000 * one.value("full_km", 0.0), nearest);
    ASSERT_EQ(trouble.has_value(), one.contains("trouble"));
    if (!trouble) continue;
    EXPECT_EQ(kNames[static_cast<int>(trouble->kind)], one.at("trouble").get<std::string>());
    EXPECT_EQ(trouble->note, one.at("note").get<std::string>());
    EXPECT_NEAR(trouble->harm, one.at("harm").get<double>(), 1e-9);
    ++troubles;
  }
  EXPECT_GT(troubles, 7u);
}

TEST(Attention, TellsOfSchedulersThatDisagree) {
  FakeLog log = MakeFakeMission();
  event_t event{};
  event.header.run_id = 7;
  event.header.sender = "world";
  event.kind = NumberOf(EventKind::kDecisionsDiffer);
  event.uav_id = event.worker_id = event.vehicle_id = event.task_id = event.charge_id = -1;
  event.detail = "decision 0: scheduler-1 ...";
  log.push_back({std::string(channel::kEvent), event});
  Renumber(&log);
  EXPECT_EQ(Told(log),
            std::vector<std::string>{"schedulers disagree: once decision 0: scheduler-1 ..."});
}

TEST(Attention, TellsWhatAgentsThatAreNotReadyWaitFor) {
  FakeLog log = MakeFakeMission();
  ForEach<agent_states_t>(&log, [](agent_states_t& states) {
    for (agent_t& agent : states.agents) {
      if (states.kind == NumberOf(AgentKind::kWorker)) {
        agent.status = NumberOf(AgentStatus::kNotReady);
      }
    }
  });
  for (const char* what : {"a fix (4 satellites)", "a fix (6 satellites)"}) {
    event_t event{};
    event.header.run_id = 7;
    event.header.sender = "world";
    event.kind = NumberOf(EventKind::kDriverWaits);
    event.uav_id = event.vehicle_id = event.task_id = event.charge_id = -1;
    event.worker_id = 1;
    event.detail = what;
    log.push_back({std::string(channel::kEvent), event});
  }
  Renumber(&log);
  EXPECT_EQ(Told(log),
            std::vector<std::string>({"not ready: worker:0 since 0:00:00",
                                      "not ready: worker:1 waits for a fix (6 satellites)"}));
}

TEST(Attention, TellsWhoCallsForHelpUntilSomethingElseIsSaid) {
  FakeLog log = MakeFakeMission();
  TimeUs now_us = 0;
  ForEach<clock_t>(&log, [&](clock_t& clock) {
    clock.phase = NumberOf(ClockPhase::kRunning);
    now_us = std::max<TimeUs>(now_us, clock.tick_us);
  });
  const auto add = [&](TimeUs at_us, EventKind kind, std::int32_t worker, const char* what) {
    event_t event{};
    event.header.run_id = 7;
    event.header.sender = "world";
    event.kind = NumberOf(kind);
    event.uav_id = event.vehicle_id = event.task_id = event.charge_id = -1;
    event.worker_id = worker;
    event.detail = what;
    event.at_us = at_us;
    log.push_back({std::string(channel::kEvent), event});
    Renumber(&log);
  };
  using Lines = std::vector<std::string>;
  const TimeUs just_us = now_us - 10 * kMinuteUs, before_us = just_us - kMinuteUs;
  ASSERT_GT(before_us, 0);
  add(before_us, EventKind::kDriverCalls, 1, "trapped");
  add(before_us, EventKind::kDriverSays, 0, "shown no more");
  EXPECT_EQ(Told(log), Lines({"calls for help: worker:1 trapped"}));
  add(just_us, EventKind::kDriverSays, 0, "low clouds");
  EXPECT_EQ(Told(log), Lines({"calls for help: worker:1 trapped", "says: worker:0 low clouds"}));
  add(now_us, EventKind::kDriverSays, 1, "all right again");
  EXPECT_EQ(Told(log), Lines({"says: worker:0 low clouds", "says: worker:1 all right again"}));
}

TEST(Attention, AHeldTaskOfAMissionThatEndedIsNotDone) {
  FakeLog log = MakeFakeMission();
  ForEach<world_state_t>(&log, [](world_state_t& world) {
    world.task_status = {NumberOf(TaskStatus::kHeld), NumberOf(TaskStatus::kOpen)};
  });
  EXPECT_EQ(Told(log), std::vector<std::string>(
                           {"tasks not done: task 1 ", "tasks not done: task 0 held by an order"}));
}

TEST(Attention, ATaskThatExpiresIsWorseThanOneThatIsLate) {
  const auto told = [](double expires0, double expires1) {
    return Told(Timed(
        [&](nlohmann::json& tasks) {
          tasks[0]["expires_min"] = expires0;
          tasks[1]["expires_min"] = expires1;
          tasks[1]["due_min"] = 1;
        },
        4));
  };
  using Lines = std::vector<std::string>;
  EXPECT_EQ(told(7, 100), Lines({"tasks at risk: task 0 starts at 0:07:12, expires at 0:07:00",
                                 "tasks at risk: task 1 was due 3 min ago, nobody is on the way"}));
  EXPECT_EQ(told(8, 14), Lines({"tasks at risk: task 1 expires in 10 min, nobody is on the way"}));
}

TEST(Attention, TasksThatNobodyReportedAreNotMissed) {
  FakeLog log = MakeFakeMission();
  ForEach<world_state_t>(&log, [](world_state_t& world) {
    world.task_status = {NumberOf(TaskStatus::kUnreported), NumberOf(TaskStatus::kExpired)};
  });
  EXPECT_EQ(Told(log), std::vector<std::string>({"tasks not done: task 1 expired"}));
}

TEST(TopView, AgentsThatAreNeverOnlineAreNotCounted) {
  FakeLog log = MakeFakeMission();
  ForEach<scenario_t>(&log, [](scenario_t& scenario) {
    nlohmann::json json = nlohmann::json::parse(scenario.json);
    json["workers"][1]["online_from_min"] = json["workers"][1]["online_until_min"] = 0;
    scenario.json = json.dump();
    scenario.sha256 = Sha256(scenario.json);
  });
  ForEach<agent_states_t>(&log, [](agent_states_t& states) {
    for (agent_t& agent : states.agents) {
      if (states.kind == NumberOf(AgentKind::kWorker) && agent.id == 1) {
        agent.status = NumberOf(AgentStatus::kOffline);
      }
    }
  });
  TopView view;
  for (const Packet& packet : Encoded(log)) view.Add(packet);
  std::string text;
  for (const TopView::Line& line : view.Lines(0, 0)) text += line.text + "\n";
  EXPECT_NE(text.find("workers         1      1       0 "), std::string::npos) << text;
  EXPECT_NE(text.find("       0        0\nvehicles"), std::string::npos) << "none is offline\n"
                                                                         << text;
}

TEST(TopView, TellsLocalTimeWhereTheScenarioHasAStart) {
  FakeLog log = MakeFakeMission();
  const auto told = [&log] {
    TopView view;
    for (const Packet& packet : Encoded(log)) view.Add(packet);
    const auto json = nlohmann::json::parse(view.Json(0));
    return std::tuple(view.Lines(0, 0).front().text, json["at_s"].get<double>(), json["at"]);
  };
  const auto [before, at_s, none] = told();
  EXPECT_TRUE(none.is_null());
  ForEach<scenario_t>(&log, [](scenario_t& scenario) {
    nlohmann::json json = nlohmann::json::parse(scenario.json);
    json["start"] = "2010-01-16T23:50:00-05:00";
    scenario.json = json.dump();
    scenario.sha256 = Sha256(scenario.json);
  });
  ASSERT_EQ(at_s, 1800);
  const auto [line, same_s, at] = told();
  EXPECT_EQ(at, "2010-01-17T00:20:00-05:00");
  EXPECT_NE(line.find("0:30:00 of "), std::string::npos) << line;
  EXPECT_NE(line.find("  2010-01-17T00:20:00-05:00"), std::string::npos) << line;
  EXPECT_EQ(before.find("2010"), std::string::npos) << before;
}

TEST(Attention, IsInTheDisplayAndInJson) {
  TopView view;
  FakeLog log = MakeFakeMission();
  ForEach<world_state_t>(&log, [](world_state_t& world) {
    for (auto& status : world.task_status) status = 0;
  });
  for (const Packet& packet : Encoded(log)) view.Add(packet);
  std::string text;
  for (const TopView::Line& line : view.Lines(0, 0)) text += line.text + "\n";
  EXPECT_NE(text.find("ATTENTION: 2\ntasks not done: 2  task 0; task 1\n"), std::string::npos)
      << text;
  EXPECT_NE(view.Json(0).find("\"kind\": \"tasks not done\""), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
