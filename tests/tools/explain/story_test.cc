#include "tools/explain/story.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>

#include "base/check.h"
#include "base/program.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "tests/temporary_folder.h"
#include "tests/tools/explain/mission_log.h"
#include "tools/explain/explain_command.h"
#include "tools/explain/redecide_command.h"

namespace muster::tools {
namespace {

using scheduler::AgentCondition;
using scheduler::Obstacle;
using scheduler::TaskVerdict;

AgentSpec Spec(Point at, double speed_m_s) {
  AgentSpec spec;
  spec.at = at;
  spec.speed_m_s = speed_m_s;
  spec.online_until_us = 60 * kMinuteUs;
  return spec;
}

/// An hour, decisions every 10 min; a UAV (10 m/s, 12 of 30 km of range), a worker (5 m/s) that
/// leaves at 25 min, two tasks and a charging point. By hand: the pair senses task 0 from 400 s to
/// 700 s. Task 1 needs 5 + 3 + 4.12 km first, which is 0.12 km too much; at 10 min the UAV is busy;
/// at 20 min it has 6 km left and needs 4 + 3 + 4.12; then the worker is gone.
Scenario TwoTasks() {
  Scenario scenario;
  scenario.name = "two tasks";
  scenario.seed = 1;
  scenario.width_m = scenario.height_m = 10e3;
  scenario.rules.limit_us = 60 * kMinuteUs;
  AgentSpec uav = Spec({1e3, 1e3}, 10);
  uav.range_full_m = 30e3;
  uav.range_m = 12e3;
  scenario.uavs = {uav};
  AgentSpec worker = Spec({2e3, 1e3}, 5);
  worker.online_until_us = 25 * kMinuteUs;
  scenario.workers = {worker};
  AgentSpec vehicle = Spec({9e3, 9e3}, 10);  // takes no part: online after the last decision
  vehicle.charge_rate_m_s = 100;
  vehicle.online_from_us = 55 * kMinuteUs;
  scenario.vehicles = {vehicle};
  scenario.tasks = {{{4e3, 1e3}, 3e3}, {{4e3, 5e3}, 3e3}};
  scenario.charging_points = {{{5e3, 1e3}, 1}};
  return scenario;
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(TaskStory, TellsWhatStoodAgainstATask) {
  const DecisionLog log = Logged(SimulatedPackets(TwoTasks(), "certified"));
  const TaskStory story = TellTask(log, "run", 1, {});
  ASSERT_EQ(story.chapters.size(), 6u);
  const Obstacle expected[] = {Obstacle::kRange,     Obstacle::kNoUav,     Obstacle::kRange,
                               Obstacle::kNoPartner, Obstacle::kNoPartner, Obstacle::kNoPartner};
  for (std::size_t d = 0; d < 6; ++d) {
    EXPECT_EQ(story.chapters[d].answer.verdict, TaskVerdict::kInfeasible) << d;
    EXPECT_EQ(story.chapters[d].answer.look.obstacle, expected[d]) << d;
    EXPECT_EQ(story.chapters[d].policy, "certified");
  }
  EXPECT_EQ(story.last_status, TaskStatus::kOpen);
  const std::string text = ToText(story);
  EXPECT_TRUE(Contains(text,
                       "task:1 at (4.00, 5.00) km takes 3.00 km of range to sense, 4.12 km "
                       "from there to charge: not done\n"))
      << text;
  EXPECT_TRUE(Contains(text,
                       "decision   0  0:00:00  infeasible, range (constraint 6): uav:0 has "
                       "12.00 km of range and needs 12.12 km: 5.00 km to the task, 3.00 km "
                       "to sense, 4.12 km to charge\n"))
      << text;
  EXPECT_TRUE(Contains(text, "decision   1  0:10:00  infeasible, no UAV is free (1 under way)\n"))
      << text;
  EXPECT_TRUE(Contains(text,
                       "decision   2  0:20:00  infeasible, range (constraint 6): uav:0 has "
                       "6.00 km of range and needs 11.12 km: 4.00 km"))
      << text;
  EXPECT_TRUE(
      Contains(text, "decision   3  0:30:00  infeasible, no worker is free (0 under way)\n"))
      << text;
  EXPECT_TRUE(Contains(text,
                       "Of 6 decisions: infeasible in 6 (no idle uav 1, no idle worker 3, "
                       "range 2).\n"))
      << text;
  const auto json = ToJson(story);
  EXPECT_EQ(json["status"], "open");
  EXPECT_TRUE(json["done_s"].is_null());
  EXPECT_EQ(json["decisions"][0]["verdict"], "infeasible");
  EXPECT_EQ(json["decisions"][0]["pairs"]["obstacle"], "range");
  EXPECT_EQ(json["decisions"][0]["pairs"]["nearest_by_range"]["range_m"], 12e3);
  EXPECT_NEAR(json["decisions"][0]["pairs"]["nearest_by_range"]["needs_m"].get<double>(),
              8000 + std::hypot(1000, 4000), 1e-6);
  EXPECT_EQ(json["decisions"][3]["pairs"]["obstacle"], "no idle partner");
}

TEST(TaskStory, TellsATaskThatIsDone) {
  const DecisionLog log = Logged(SimulatedPackets(TwoTasks(), "certified"));
  const TaskStory story = TellTask(log, "run", 0, {});
  EXPECT_EQ(story.chapters[0].answer.verdict, TaskVerdict::kChosen);
  EXPECT_EQ(story.chapters[1].answer.verdict, TaskVerdict::kUnderWay);
  EXPECT_EQ(story.chapters[2].answer.verdict, TaskVerdict::kDone);
  const std::string text = ToText(story);
  EXPECT_TRUE(Contains(text, "done at 0:11:40 by uav:0 and worker:0\n")) << text;
  EXPECT_TRUE(Contains(text, "chosen: uav:0 and worker:0 sense task:0 (10")) << text;
  EXPECT_TRUE(Contains(text, "* 0:06:40 sensing started uav:0 worker:0 task:0\n")) << text;
  EXPECT_TRUE(Contains(
      text,
      "decision   1  0:10:00  under way: uav:0 and worker:0 sense it from 0:06:40 to 0:11:40"))
      << text;
  EXPECT_TRUE(Contains(text, "Of 6 decisions: done in 4, under way in 1, chosen in 1.\n")) << text;
  EXPECT_FALSE(Contains(text, "decision   3"));
  EXPECT_TRUE(Contains(ToText(TellTask(log, "run", 0, 3)), "decision   3  0:30:00  done\n"));
}

TEST(AgentStory, TellsWhatAnAgentDidAndWhyNotMore) {
  const DecisionLog log = Logged(SimulatedPackets(TwoTasks(), "certified"));
  const AgentStory worker = TellAgent(log, "run", AgentKind::kWorker, 0, {});
  EXPECT_EQ(worker.chapters[0].answer.condition, AgentCondition::kIdle);
  EXPECT_EQ(worker.chapters[1].answer.condition, AgentCondition::kBusy);
  EXPECT_EQ(worker.chapters[2].answer.condition, AgentCondition::kIdle);
  EXPECT_EQ(worker.chapters[3].answer.condition, AgentCondition::kOffline);
  const std::string text = ToText(worker);
  EXPECT_TRUE(Contains(text, "worker:0 is online from 0:00:00 to 0:25:00\n")) << text;
  EXPECT_TRUE(Contains(text, "decision   0  0:00:00  idle: uav:0 and worker:0 sense task:0 (10"))
      << text;
  EXPECT_TRUE(Contains(text,
                       "not 1 task: at task:1, which comes nearest, range (constraint 6): "
                       "uav:0 has 12.00 km of range and needs 12.12 km"))
      << text;
  EXPECT_TRUE(Contains(text,
                       "busy until 0:11:40: uav:0 and worker:0 sense task:0 (since decision "
                       "0)\n"))
      << text;
  EXPECT_TRUE(Contains(text, "* 0:25:00 agent offline worker:0\n")) << text;
  EXPECT_TRUE(Contains(text, "decision   3  0:30:00  offline\n")) << text;
  const auto json = ToJson(worker);
  EXPECT_EQ(json["agent"], "worker:0");
  EXPECT_EQ(json["decisions"][0]["did"]["symbol"], "UiTxWj");
  EXPECT_EQ(json["decisions"][1]["under_way"]["until_s"], 700.0);
  EXPECT_EQ(json["decisions"][2]["blocked"][0]["obstacle"], "range");
}

TEST(AgentStory, TellsAFailedAgent) {
  Scenario scenario = TwoTasks();
  scenario.disturbances.agent_failure = {1, 1};
  const DecisionLog log = Logged(SimulatedPackets(scenario, "certified"));
  const AgentStory uav = TellAgent(log, "run", AgentKind::kUav, 0, {});
  EXPECT_EQ(uav.chapters[0].answer.condition, AgentCondition::kFailed);
  const std::string text = ToText(uav);
  EXPECT_TRUE(Contains(text, "decision   0  0:00:00  failed\n")) << text;
  EXPECT_TRUE(Contains(text, "* 0:00:00 agent failed uav:0\n")) << text;
}

TEST(AgentStory, TellsWhatWasLeftOutForWantOfAnAltitude) {
  GeneratorSettings settings = PresetByName("Random_10");
  settings.rules.limit_us = 90 * kMinuteUs;
  Scenario scenario = Generate(settings, 2);
  ScenarioAir air;
  air.separation = Separation{2000, 50, 30, 60};  // one altitude for all within 2 km
  UseAir(std::move(air), &scenario);
  for (const char* policy : {"certified", "horizon-steps", "rollout-steps"}) {
    SCOPED_TRACE(policy);
    const DecisionLog log = Logged(SimulatedPackets(scenario, policy));
    int withheld = 0, pairs = 0;
    for (const event_t& event : log.events) {
      if (event.kind != EventKind::kActionWithheld) continue;
      ++withheld;
      const auto d = static_cast<std::int32_t>(event.at_us / scenario.rules.interval_us);
      const AgentStory uav = TellAgent(log, "run", AgentKind::kUav, event.uav_id, d);
      ASSERT_EQ(uav.chapters.size(), 1u);
      ASSERT_EQ(uav.chapters[0].withheld.size(), 1u);
      const auto& how = uav.chapters[0].how;
      EXPECT_TRUE(!how || how->again) << d;
      const auto json = ToJson(uav);
      EXPECT_EQ(json["decisions"][0]["withheld"].size(), 1u);
      if (event.worker_id < 0) continue;
      ++pairs;
      const std::string words = fmt::format(
          "decided, but left out: uav:{} and worker:{} sent to task:{} (no altitude is "
          "free within 2 min)",
          event.uav_id, event.worker_id, event.task_id);
      EXPECT_TRUE(Contains(ToText(uav), words)) << ToText(uav);
      const std::string worker =
          ToText(TellAgent(log, "run", AgentKind::kWorker, event.worker_id, d));
      EXPECT_TRUE(Contains(worker, words)) << worker;
      const std::string task = ToText(TellTask(log, "run", event.task_id, d));
      EXPECT_TRUE(Contains(task, words)) << task;
    }
    EXPECT_GE(withheld, 3);
    EXPECT_GE(pairs, 1);
  }
}

TEST(TaskStory, TellsOfTasksThatAreReportedAndExpire) {
  GeneratorSettings settings = PresetByName("Random_10");
  settings.rules.limit_us = 90 * kMinuteUs;
  settings.arrivals.share = 0.8;
  settings.expires_min = {Always(15), Always(15), Always(15), Always(15)};
  const Scenario scenario = Generate(settings, 2);
  for (const char* policy : {"mpq", "certified", "horizon", "rollout-steps"}) {
    SCOPED_TRACE(policy);
    const DecisionLog log = Logged(SimulatedPackets(scenario, policy));
    std::map<std::string, int> verdicts, obstacles;
    std::vector<std::int32_t> all(scenario.tasks.size());
    std::iota(all.begin(), all.end(), 0);
    const std::vector<TaskStory> together = TellTasks(log, "run", all, {});
    for (const std::int32_t x : all) {
      const TaskStory story = TellTask(log, "run", x, {});
      EXPECT_FALSE(ToText(story).empty());
      EXPECT_EQ(ToText(story), ToText(together[static_cast<std::size_t>(x)]));
      const Task& task = scenario.tasks[static_cast<std::size_t>(x)];
      const auto json = ToJson(story);
      for (const auto& chapter : json["decisions"]) {
        const std::string verdict = chapter["verdict"];
        ++verdicts[verdict];
        const TimeUs t = chapter["decision"].get<int>() * scenario.rules.interval_us;
        EXPECT_EQ(verdict == "unreported", t < task.reported_us) << "task " << x;
        EXPECT_EQ(verdict == "expired" && t < task.expires_us, false) << "task " << x;
        if (chapter.contains("pairs")) ++obstacles[chapter["pairs"]["obstacle"]];
      }
    }
    EXPECT_GT(verdicts["unreported"], 20);
    EXPECT_GT(verdicts["expired"], 20);
    EXPECT_GT(obstacles["expiry"], 0);
    for (const AgentKind kind : kAgentKinds) {
      for (std::int32_t id = 0; id < 5; ++id) {
        EXPECT_FALSE(ToText(TellAgent(log, "run", kind, id, {})).empty());
      }
    }
  }
}

TEST(TaskStory, SaysOfEachTaskWhatTheLogSays) {
  GeneratorSettings settings = PresetByName("Random_10");
  settings.rules.limit_us = 90 * kMinuteUs;
  settings.disturbances = {{0.1, 0.4}, {100, 500}, {0.05, 0.2}, {0.1, 0.3}};
  const Scenario scenario = Generate(settings, 2);
  const DecisionLog log = Logged(SimulatedPackets(scenario, "mpq"));
  std::map<TaskVerdict, int> verdicts;
  int aborted = 0, unmatched = 0;
  for (std::int32_t x = 0; x < static_cast<std::int32_t>(scenario.tasks.size()); ++x) {
    SCOPED_TRACE(fmt::format("task {}", x));
    const TaskStory story = TellTask(log, "run", x, {});
    ASSERT_EQ(story.chapters.size(), 9u);
    for (std::size_t d = 0; d < 9; ++d) {
      const auto& logged = log.decisions.at(static_cast<std::int32_t>(d));
      std::int8_t status = -1;
      for (const Packet& packet : logged.told) {
        if (packet.channel != channel::kWorld) continue;
        status = Decode<world_state_t>(packet.bytes)->task_status[static_cast<std::size_t>(x)];
      }
      const auto& actions = logged.schedules.at(0).actions;
      const bool sent = std::any_of(actions.begin(), actions.end(), [x](const action_t& a) {
        return a.kind == 7 && a.task_id == x;
      });
      const auto& chapter = story.chapters[d];
      ++verdicts[chapter.answer.verdict];
      switch (chapter.answer.verdict) {
        case TaskVerdict::kDone:
          ASSERT_EQ(status, 3);
          break;
        case TaskVerdict::kUnderWay:
          ASSERT_TRUE(status == 1 || status == 2);
          ASSERT_TRUE(chapter.answer.activity);
          break;
        case TaskVerdict::kChosen:
          ASSERT_EQ(status, 0);
          ASSERT_TRUE(sent);
          break;
        case TaskVerdict::kLost:
        case TaskVerdict::kInfeasible:
          ASSERT_EQ(status, 0);
          ASSERT_FALSE(sent);
          break;
        default:
          ADD_FAILURE() << ToString(chapter.answer.verdict);
      }
      if (chapter.answer.forcing) {
        ASSERT_TRUE(chapter.answer.forcing->exact);
        ASSERT_GE(chapter.answer.forcing->cost, 0);
        // Nothing that was commanded outweighs the best decision.
        ASSERT_LE(chapter.quality.weight, chapter.quality.best.weight + 1e-6);
      }
      for (const event_t& event : chapter.events) {
        ASSERT_EQ(event.task_id, x);
        if (event.kind != 6 && event.kind != 10) continue;
        ++(event.kind == 6 ? aborted : unmatched);
        if (event.kind == 10) {
          ASSERT_EQ(chapter.answer.verdict, TaskVerdict::kChosen);
        }
        if (d + 1 == 9) continue;
        const TaskVerdict next = story.chapters[d + 1].answer.verdict;
        ASSERT_NE(next, TaskVerdict::kDone);  // the task is open again
        ASSERT_NE(next, TaskVerdict::kUnderWay);
      }
    }
    ASSERT_EQ(story.done.has_value(), story.last_status == TaskStatus::kDone);
  }
  for (const TaskVerdict verdict :
       {TaskVerdict::kDone, TaskVerdict::kUnderWay, TaskVerdict::kChosen, TaskVerdict::kLost,
        TaskVerdict::kInfeasible}) {
    EXPECT_GT(verdicts[verdict], 0) << ToString(verdict);
  }
  EXPECT_GT(aborted, 0);
  EXPECT_GT(unmatched, 0);
}

/// A UAV between two tasks with a worker beside each: one interval to task 0, two to task 1.
Scenario NearAndFar() {
  Scenario scenario = TwoTasks();
  scenario.width_m = scenario.height_m = 30e3;
  scenario.uavs[0].at = {10e3, 1e3};
  scenario.uavs[0].range_m = 30e3;
  scenario.workers = {Spec({8e3, 1e3}, 5), Spec({18e3, 1e3}, 5)};
  scenario.tasks = {{{8e3, 1e3}, 1e3}, {{18e3, 1e3}, 1e3}};
  scenario.charging_points = {{{10e3, 2e3}, 1}};
  return scenario;
}

TEST(TaskStory, TellsWhatATaskLostToAndItsPrice) {
  const DecisionLog log = Logged(SimulatedPackets(NearAndFar(), "certified"));
  const TaskStory story = TellTask(log, "run", 1, 0);
  ASSERT_EQ(story.chapters.size(), 1u);
  const auto& answer = story.chapters[0].answer;
  ASSERT_EQ(answer.verdict, TaskVerdict::kLost);
  ASSERT_TRUE(answer.forcing && answer.forcing->exact);
  const std::string text = ToText(story);
  // 8 km at 10 m/s and 1 km of sensing.
  EXPECT_TRUE(Contains(text, "lost: uav:0 and worker:1 could sense it by 0:15:00 (5")) << text;
  EXPECT_TRUE(Contains(text, "to:   uav:0 and worker:0 sense task:0 (10")) << text;
  EXPECT_TRUE(
      Contains(text, fmt::format("forcing it costs {:.3f} of {:.3f}; uav:0 and worker:1 "
                                 "sense task:1, and task:0 is not\n",
                                 answer.forcing->cost, story.chapters[0].quality.best.weight)))
      << text;
  const auto json = ToJson(story)["decisions"][0];
  EXPECT_EQ(json["verdict"], "lost");
  EXPECT_EQ(json["forcing"]["cost"], answer.forcing->cost);
  EXPECT_NEAR(json["forcing"]["cost"].get<double>(), 50, 3);
  EXPECT_EQ(json["forcing"]["tasks_displaced"], nlohmann::ordered_json::array({0}));
  EXPECT_EQ(json["lost_to"][0]["task"], 0);
  EXPECT_EQ(json["options"][0]["uav_did"]["task"], 0);
  EXPECT_EQ(json["options"][0]["pair"]["end_s"], 900.0);
  EXPECT_FALSE(json["own_weights"].get<bool>());
}

/// The packets with another name in the place of the policy's.
std::vector<Packet> Renamed(std::vector<Packet> packets, const std::string& policy) {
  for (Packet& packet : packets) {
    if (packet.channel != channel::kSchedule) continue;
    auto schedule = *Decode<schedule_t>(packet.bytes);
    schedule.policy = policy;
    packet.bytes = Encode(schedule);
  }
  return packets;
}

TEST(TaskStory, APolicyWithWeightsOfItsOwnIsNamed) {
  const auto packets = Renamed(SimulatedPackets(NearAndFar(), "horizon"), "mine");
  const TaskStory outside = TellTask(Logged(packets), "run", 1, {});
  EXPECT_EQ(outside.terms, Terms::kPaper);
  EXPECT_TRUE(Contains(ToText(outside),
                       "In the paper's weights, though policy mine decides by weights of its own"));
  const DecisionLog paper = Logged(SimulatedPackets(NearAndFar(), "mpq"));
  const std::string text = ToText(TellTask(paper, "run", 1, {}));
  EXPECT_TRUE(Contains(text, "In the paper's weights, by which mpq decides.\n")) << text;
  EXPECT_FALSE(Contains(text, "weights of its own"));
}

TEST(TaskStory, HorizonIsToldInItsOwnTerms) {
  const DecisionLog log = Logged(SimulatedPackets(TwoTasks(), "horizon"));
  const TaskStory story = TellTask(log, "run", 1, {});
  EXPECT_EQ(story.terms, Terms::kHorizon);
  ASSERT_EQ(story.chapters.size(), 6u);
  for (const auto& chapter : story.chapters) {
    ASSERT_TRUE(chapter.how);
    EXPECT_TRUE(chapter.how->again);
    EXPECT_EQ(chapter.answer.verdict, TaskVerdict::kImpossible);
  }
  const std::string text = ToText(story);
  EXPECT_TRUE(Contains(text,
                       "In horizon's own terms: what a pair is worth to its matching, in tasks (1: "
                       "done before the next decision).\n"))
      << text;
  EXPECT_TRUE(Contains(text,
                       "decision   0  0:00:00  impossible, range (constraint 6): uav:0 has 12.00 "
                       "km of range and needs 12.12 km: 5.00 km to the task, 3.00 km to sense, "
                       "4.12 km to charge\n"))
      << text;
  // At 10 min the UAV is busy until 11:40 and takes part as free at 20 min, with 6 km.
  EXPECT_TRUE(Contains(text,
                       "decision   1  0:10:00  impossible, range (constraint 6): uav:0 (free at "
                       "0:20:00) has 6.00 km of range and needs 11.12 km: 4.00 km"))
      << text;
  EXPECT_TRUE(Contains(text,
                       "decision   3  0:30:00  impossible, no worker is idle or free within 2 "
                       "decisions (0 under way for longer)\n"))
      << text;
  EXPECT_TRUE(Contains(text, "Of 6 decisions: impossible in 6 (no worker soon 3, range 3).\n"))
      << text;
  EXPECT_FALSE(Contains(text, "paper"));
  const auto json = ToJson(story);
  EXPECT_EQ(json["version"], 2);
  EXPECT_EQ(json["terms"], "horizon");
  EXPECT_EQ(json["unit"], "tasks");
  EXPECT_EQ(json["decisions"][1]["verdict"], "impossible");
  EXPECT_EQ(json["decisions"][1]["pairs"]["nearest_by_range"]["free_s"], 1200.0);
  EXPECT_FALSE(json["decisions"][1].contains("best_weight"));
}

TEST(TaskStory, OutbidInTasksAndByTheForecast) {
  const DecisionLog log = Logged(SimulatedPackets(NearAndFar(), "rollout"));
  const TaskStory story = TellTask(log, "run", 1, {});
  const auto& chapter = story.chapters[0];
  ASSERT_TRUE(chapter.how);
  EXPECT_TRUE(chapter.how->again);
  const auto& answer = chapter.answer;
  const auto& quality = chapter.quality;
  ASSERT_TRUE(answer.forcing && quality.forecast_done && answer.forcing->forecast_done);
  // Nobody comes later and nothing fails: what is forecast happens, as far as horizon decides on.
  int done = 0;
  for (const event_t& event : log.events) done += event.kind == EventKind::kSensingDone ? 1 : 0;
  EXPECT_EQ(*quality.forecast_done, static_cast<std::size_t>(done));
  const std::string text = ToText(story);
  EXPECT_TRUE(Contains(text, fmt::format("forcing it costs {:.3f} of {:.3f} tasks",
                                         answer.forcing->cost, quality.best.weight)))
      << text;
  EXPECT_TRUE(Contains(text, "; the forecast ends with ")) << text;
  EXPECT_TRUE(Contains(text, "decided by variant ")) << text;
  const auto json = ToJson(story)["decisions"][0];
  EXPECT_EQ(json["forcing"]["cost"], answer.forcing->cost);
  EXPECT_EQ(json["forecast_done"], done);
  EXPECT_EQ(json["options"][0]["outbid_by"][0]["task"], 0);
}

TEST(TaskStory, ARolloutThatExpectsTasksIsToldInItsOwnTerms) {
  const DecisionLog log = Logged(SimulatedPackets(NearAndFar(), "rollout:expect=6"));
  const TaskStory story = TellTask(log, "run", 1, {});
  EXPECT_EQ(story.terms, Terms::kHorizon);
  EXPECT_EQ(story.policy, "rollout:expect=6");
  ASSERT_TRUE(story.chapters[0].how);
  EXPECT_TRUE(story.chapters[0].how->again);
}

TEST(TaskStory, LearnedWeightingsAreThoseOfTheSituation) {
  for (const char* policy : {"horizon-learned", "rollout-learned"}) {
    const DecisionLog log = Logged(SimulatedPackets(NearAndFar(), policy));
    const TaskStory story = TellTask(log, "run", 1, {});
    EXPECT_EQ(story.terms, Terms::kHorizon) << policy;
    for (const auto& chapter : story.chapters) {
      ASSERT_TRUE(chapter.how) << policy;
      EXPECT_TRUE(chapter.how->again) << policy << " at decision " << chapter.decision;
      EXPECT_TRUE(chapter.settings.starts_with("patience ")) << chapter.settings;
    }
  }
}

TEST(AgentStory, HorizonIsToldInItsOwnTerms) {
  const DecisionLog log = Logged(SimulatedPackets(TwoTasks(), "horizon"));
  const AgentStory story = TellAgent(log, "run", AgentKind::kWorker, 0, {});
  EXPECT_EQ(story.terms, Terms::kHorizon);
  const std::string text = ToText(story);
  EXPECT_TRUE(Contains(text, "decision   0  0:00:00  idle: uav:0 and worker:0 sense task:0 ("))
      << text;
  EXPECT_TRUE(Contains(text, "matched: uav:0 and worker:0 for task:0 by 0:11:40 (")) << text;
  EXPECT_TRUE(Contains(text, "takes part as free at 0:20:00\n")) << text;
  EXPECT_TRUE(Contains(text, "decision   3  0:30:00  offline\n")) << text;
  const auto json = ToJson(story);
  EXPECT_EQ(json["decisions"][0]["matched"][0]["task"], 0);
  EXPECT_EQ(json["decisions"][1]["free_s"], 1200.0);
}

TEST(TaskStory, ALogWithHolesIsToldAsFarAsItGoes) {
  std::vector<Packet> packets = SimulatedPackets(TwoTasks(), "certified");
  std::erase_if(packets, [](const Packet& packet) {
    return packet.channel == channel::kRulings && Decode<rulings_t>(packet.bytes)->tick == 20;
  });
  const TaskStory story = TellTask(Logged(packets), "run", 1, {});
  EXPECT_EQ(story.chapters[1].missing, "rulings_t");
  EXPECT_EQ(story.chapters[2].missing, "");
  EXPECT_TRUE(Contains(ToText(story),
                       "decision   1  0:10:00  cannot be told, the log lacks "
                       "rulings_t\n"));
}

class Commands : public ::testing::Test {
 protected:
  Commands() {
    EventLogWriter writer(file_);
    for (const Packet& packet : SimulatedPackets(NearAndFar(), "certified")) {
      writer.Write(1, packet);
    }
    writer.Flush();
  }

  /// Exit code; what it prints goes to out_.
  template <class Command>
  int Run(Command command, std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), {"muster", file_.c_str()});
    ::testing::internal::CaptureStdout();
    int code = -1;
    try {
      code = command(static_cast<int>(arguments.size()), arguments.data());
    } catch (...) {
      std::fflush(stdout);
      ::testing::internal::GetCapturedStdout();
      throw;
    }
    std::fflush(stdout);
    out_ = ::testing::internal::GetCapturedStdout();
    return code;
  }

  const TemporaryFolder folder_;
  const std::string file_ = folder_.File("mission.lcm");
  std::string out_;
};

TEST_F(Commands, ExplainPrintsTextAndJson) {
  EXPECT_EQ(Run(ExplainCommand, {"--task", "1"}), kExitOk);
  EXPECT_TRUE(Contains(out_, "task:1 at")) << out_;
  const std::string of_option = out_;
  EXPECT_EQ(Run(ExplainCommand, {"task:1"}), kExitOk);
  EXPECT_EQ(out_, of_option);
  EXPECT_EQ(Run(ExplainCommand, {"uav:0"}), kExitOk);
  EXPECT_TRUE(Contains(out_, "uav:0")) << out_;
  EXPECT_EQ(Run(ExplainCommand, {"--agent", "uav:0", "--decision", "0", "--json"}), kExitOk);
  const auto json = nlohmann::json::parse(out_);
  EXPECT_EQ(json["version"], 2);
  EXPECT_EQ(json["terms"], "paper");
  EXPECT_EQ(json["agent"], "uav:0");
  ASSERT_EQ(json["decisions"].size(), 1u);
  EXPECT_EQ(json["decisions"][0]["options"][0]["task"], 1);
  for (const std::vector<const char*>& bad :
       std::vector<std::vector<const char*>>{{},
                                             {"--task", "1", "--agent", "uav:0"},
                                             {"--task", "1", "uav:0"},
                                             {"drone:0"},
                                             {"--task", "2"},
                                             {"--task", "-1"},
                                             {"--task", "1x"},
                                             {"--agent", "uav:1"},
                                             {"--agent", "drone:0"},
                                             {"--agent", "uav"},
                                             {"--task", "1", "--decision", "6"}}) {
    EXPECT_THROW(Run(ExplainCommand, bad), InputError);
  }
}

/// Room for orders is no task and no agent.
TEST(Story, OfWhatNoOrderHasAddedThereIsNone) {
  DecisionLog log;
  log.scenario = Generate(PresetByName("Random_1"), 1);
  AddRoom({3, {1, 1, 1}}, &log.scenario);
  EXPECT_THROW(TellTask(log, "run", 120, {}, {}), InputError);
  EXPECT_THROW(TellAgent(log, "run", AgentKind::kUav, 30, {}, {}), InputError);
  EXPECT_NO_THROW(TellTask(log, "run", 119, {}, {}));
}

TEST_F(Commands, RedecideTellsByItsExitCode) {
  EXPECT_EQ(Run(RedecideCommand, {}), kExitOk);
  EXPECT_TRUE(Contains(out_, "every decision is the same, bit for bit")) << out_;
  EXPECT_EQ(Run(RedecideCommand, {"--policy", "certified", "--json"}), kExitOk);
  auto json = nlohmann::json::parse(out_);
  EXPECT_TRUE(json["same"].get<bool>());
  EXPECT_EQ(json["schedules"], 6);
  EXPECT_EQ(Run(RedecideCommand, {"--policy", "greedy-sum", "--json"}), kExitOk);
  json = nlohmann::json::parse(out_);
  ASSERT_EQ(json["decisions"].size(), 6u);
  EXPECT_EQ(json["decisions"][0]["logged"]["policy"], "certified");
  EXPECT_EQ(json["decisions"][0]["redecided"]["policy"], "greedy-sum");
  EXPECT_GT(json["decisions"][0]["dropped"], 0);
  EXPECT_EQ(Run(RedecideCommand, {"--policy", "greedy-sum"}), kExitOk);
  EXPECT_TRUE(Contains(out_, " of 6 decisions have the same actions")) << out_;
  EXPECT_THROW(Run(RedecideCommand, {"--policy", "nonsense"}), InputError);

  // The same log with one schedule's weight changed by its last bit.
  std::vector<Packet> packets = SimulatedPackets(NearAndFar(), "certified");
  std::filesystem::remove(file_);
  {
    EventLogWriter writer(file_);
    for (Packet& packet : packets) {
      if (packet.channel == channel::kSchedule) {
        schedule_t schedule = *Decode<schedule_t>(packet.bytes);
        if (schedule.decision == 0) schedule.weight = std::nextafter(schedule.weight, 0);
        packet.bytes = Encode(schedule);
      }
      writer.Write(1, packet);
    }
    writer.Flush();
  }
  EXPECT_EQ(Run(RedecideCommand, {}), kExitCheckFailed);
  EXPECT_TRUE(Contains(out_, "0:00:00  decision 0: weight is ")) << out_;
  EXPECT_EQ(Run(RedecideCommand, {"--json"}), kExitCheckFailed);
  json = nlohmann::json::parse(out_);
  EXPECT_FALSE(json["same"].get<bool>());
  EXPECT_EQ(json["divergences"][0]["decision"], 0);
}

}  // namespace
}  // namespace muster::tools
