#include "learning/practice_mission.h"

#include <gtest/gtest.h>

#include <string>

#include "base/check.h"
#include "learning/episode.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "scheduler/policies/learned/learned_policy.h"
#include "scheduler/policies/registry.h"
#include "simulation/simulator.h"
#include "tests/scheduler/policies/learned/learned_model.h"
#include "tests/simulation/audited.h"
#include "tests/temporary_folder.h"
#include "tools/record/run_record.h"

namespace muster::learning {
namespace {

GeneratorSettings Small() {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.width_km = settings.height_km = 12;
  settings.uavs = 6;
  settings.workers = 8;
  settings.vehicles = 4;
  settings.tasks = 25;
  settings.charging_points = 4;
  return settings;
}

/// Agents come online and leave as they do in a mission, and all that is decided is the same.
TEST(PracticeMission, GivesTheMissionsSituationsAndOutcomes) {
  const TemporaryFolder folder;
  const std::string learned = "learned:" + folder.path().string();
  WriteModel(scheduler::testing::RandomModel(scheduler::learned::ShapeOf(Generate(Small(), 1)), 4),
             folder.path().string());
  std::size_t done = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    for (const std::string& name : {std::string("horizon-steps"), std::string("kwta"), learned}) {
      SCOPED_TRACE(name + " seed " + std::to_string(seed));
      GeneratorSettings settings = Small();
      if (seed % 2 == 0) settings.rules.availability = Availability::kOverrun;
      const Scenario scenario = Generate(settings, seed);
      tools::RunRecord record;
      tools::Audited audited;
      tools::Simulate(ScenarioToJson(scenario), name, [&](const Packet& packet) {
        record.Add(packet);
        audited.Add(packet);
      });
      const auto policy = scheduler::MakePolicy(name);
      PracticeMission mission(*record.scenario());
      for (std::int32_t decision = 0; !mission.over(); ++decision) {
        const auto actions = policy->Decide(mission.situation()).actions;
        const auto commanded = record.schedules().find(decision);
        ASSERT_NE(commanded, record.schedules().end());
        ASSERT_EQ(commanded->second.actions.size(), actions.size()) << "decision " << decision;
        for (std::size_t i = 0; i < actions.size(); ++i) {
          EXPECT_EQ(commanded->second.actions[i].kind, static_cast<std::int8_t>(actions[i].kind));
          EXPECT_EQ(commanded->second.actions[i].x_m, actions[i].to.x_m);
        }
        mission.Step(actions);
      }
      done += mission.done();
    }
  }
  EXPECT_GT(done, 40u);
}

TEST(PlayEpisode, RewardsTheTasksThatGetDone) {
  const auto shape = scheduler::learned::ShapeOf(Generate(Small(), 1));
  double charged = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scenario scenario = Generate(Small(), seed);
    const Episode episode =
        PlayEpisode(scenario, shape, nullptr, 1, Random(seed, Stream::kTest), true);
    double reward = 0;
    for (const Turn& turn : episode.turns) {
      reward += turn.reward;
      charged += turn.charge_gain;
    }
    EXPECT_NEAR(reward, episode.completion * static_cast<double>(scenario.tasks.size()), 1e-6);
    EXPECT_EQ(episode.turns.size(), 18u);
    const Episode again =
        PlayEpisode(scenario, shape, nullptr, 1, Random(seed, Stream::kTest), false);
    EXPECT_EQ(again.completion, episode.completion);
    EXPECT_TRUE(again.turns.empty());
  }
  EXPECT_GT(charged, 0);
}

TEST(PracticeMission, RefusesTasksThatComeLater) {
  GeneratorSettings settings = Small();
  settings.arrivals.share = 1;
  EXPECT_THROW(PracticeMission(Generate(settings, 1)), InputError);
}

}  // namespace
}  // namespace muster::learning
