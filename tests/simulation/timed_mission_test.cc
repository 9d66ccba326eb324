// Missions whose tasks are reported and expire while they run: every policy's are audited, and no
// policy knows of a task before it is reported.
#include <gtest/gtest.h>

#include <cctype>
#include <string>
#include <vector>

#include "base/random.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/simulation/audited.h"
#include "tools/record/run_record.h"
#include "tools/record/service.h"

namespace muster::tools {
namespace {

/// A third of Random_1; `times`: of the tasks.
Scenario Draw(std::uint64_t seed, bool times) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.width_km = settings.height_km = 14;
  settings.uavs = 9;
  settings.workers = 13;
  settings.vehicles = 6;
  settings.tasks = 40;
  settings.charging_points = 5;
  settings.rules.limit_us = 120 * kMinuteUs;
  if (seed % 2 == 1) settings.rules.availability = Availability::kOverrun;
  if (seed % 3 == 1) settings.disturbances = {{0.1, 0.5}, {100, 900}, {0.005, 0.02}, {0.05, 0.2}};
  Scenario scenario = Generate(settings, seed);
  if (!times) return scenario;
  Random random(seed, Stream::kTest);
  for (Task& task : scenario.tasks) {
    const auto minutes = [&](std::uint32_t most) { return kMinuteUs * TimeUs{random.Below(most)}; };
    if (random.Below(3) != 0) task.reported_us = minutes(100);
    if (random.Below(2) == 0) task.due_us = task.reported_us + minutes(40);
    if (random.Below(2) == 0) {
      task.expires_us = (task.due_us == kNever ? task.reported_us : task.due_us) + minutes(40);
    }
    task.priority = static_cast<Priority>(random.Below(4));
  }
  return scenario;
}

RunRecord Play(const Scenario& scenario, const std::string& policy) {
  RunRecord record;
  Audited audited;
  Simulate(ScenarioToJson(scenario), policy, [&](const Packet& packet) {
    record.Add(packet);
    audited.Add(packet);
  });
  return record;
}

class TimedMission : public ::testing::TestWithParam<const char*> {};

TEST_P(TimedMission, PassesTheAudit) {
  const bool meets_by_chance = std::string(GetParam()) == "greedy-nearest";
  int reported = 0, expired = 0, done = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scenario scenario = Draw(seed, true);
    scenario.rules.start_on_meeting = meets_by_chance;
    const RunRecord record = Play(scenario, GetParam());
    for (const event_t& event : record.events()) {
      reported += event.kind == EventKind::kTaskReported;
      expired += event.kind == EventKind::kTaskExpired;
      done += event.kind == EventKind::kSensingDone;
    }
  }
  EXPECT_GT(reported, 100);
  EXPECT_GT(expired, 10);
  EXPECT_GT(done, 20);
}

TEST_P(TimedMission, KnowsOfNoTaskBeforeItIsReported) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scenario scenario = Draw(seed, false);
    const RunRecord without = Play(scenario, GetParam());
    Random random(seed, Stream::kTest, 1);
    for (int i = 0; i < 30; ++i) {
      Task task = scenario.tasks[random.Below(40)];
      task.at.x_m = 14'000 * random.Uniform();
      task.priority = Priority::kEmergency;
      task.reported_us = scenario.rules.limit_us - 1;
      task.due_us = scenario.rules.limit_us;
      scenario.tasks.push_back(task);
    }
    const RunRecord with = Play(scenario, GetParam());
    ASSERT_EQ(with.schedules().size(), without.schedules().size());
    for (const auto& [decision, schedule] : without.schedules()) {
      const auto& other = with.schedules().at(decision);
      ASSERT_EQ(other.actions.size(), schedule.actions.size()) << "decision " << decision;
      for (std::size_t i = 0; i < schedule.actions.size(); ++i) {
        const action_t &a = schedule.actions[i], &b = other.actions[i];
        ASSERT_TRUE(a.kind == b.kind && a.uav_id == b.uav_id && a.worker_id == b.worker_id &&
                    a.vehicle_id == b.vehicle_id && a.task_id == b.task_id &&
                    a.charge_id == b.charge_id && a.weight == b.weight)
            << "decision " << decision;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, TimedMission,
                         ::testing::Values("greedy-nearest", "kwta", "mpq", "ils", "certified",
                                           "horizon", "horizon-steps", "rollout",
                                           "rollout:expect=5"),
                         [](const auto& policy) {
                           std::string name = policy.param;
                           std::erase_if(name, [](char c) { return std::isalnum(c) == 0; });
                           return name;
                         });

TEST(TimedMissionWorth, HorizonDecidesForWhatMatters) {
  double seeing = 0, blind = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Scenario scenario = Generate(PresetByName("Random_1"), seed);
    Random random(seed, Stream::kTest);
    for (Task& task : scenario.tasks) {
      task.reported_us = kMinuteUs * TimeUs{random.Below(150)};
      task.priority = static_cast<Priority>(random.Below(4));
      task.due_us = task.reported_us + kMinuteUs * (60 - 15 * static_cast<int>(task.priority));
    }
    Scenario plain = scenario;
    for (Task& task : plain.tasks) {
      task.priority = Priority::kNormal;
      task.due_us = kNever;
    }
    seeing += ServiceOf(Play(scenario, "horizon"), scenario).worth_done;
    blind += ServiceOf(Play(plain, "horizon"), scenario).worth_done;
  }
  EXPECT_GT(seeing, 1.1 * blind);
}

}  // namespace
}  // namespace muster::tools
