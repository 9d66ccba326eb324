#include "learning/node_value.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "scheduler/policies/horizon/horizon.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::learning {
namespace {

using scheduler::HorizonSettings;
using scheduler::WeightCoefficients;
using scheduler::WeightedFor;
using scheduler::testing::RandomSituation;

GeneratorSettings Scant() {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.width_km = settings.height_km = 12;
  settings.uavs = 3;
  settings.workers = 4;
  settings.vehicles = 2;
  settings.tasks = 30;
  settings.charging_points = 2;
  return settings;
}

TEST(WeightedFor, WithoutCoefficientsIsHandSet) {
  HorizonSettings usual;
  usual.steps = true;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto situation = RandomSituation(seed);
    const HorizonSettings settings = WeightedFor(situation, {});
    EXPECT_EQ(settings.patience, usual.patience);
    EXPECT_EQ(settings.expected_way, usual.expected_way);
    EXPECT_TRUE(settings.steps);
    EXPECT_EQ(scheduler::LearnedHorizonPolicy(WeightCoefficients{}).Decide(situation).actions,
              scheduler::HorizonPolicy(usual).Decide(situation).actions);
  }
}

TEST(WeightedFor, GrowsByTheExponentialOfTheFeatures) {
  const auto situation = RandomSituation(3);
  const auto features = scheduler::SituationFeatures(situation);
  EXPECT_EQ(features[0], 1);
  WeightCoefficients coefficients = {};
  coefficients[2] = {0.5, 0.25, 0, 0, 0};
  EXPECT_NEAR(WeightedFor(situation, coefficients).uav_way,
              HorizonSettings().uav_way * std::exp(0.5 + 0.25 * features[1]), 1e-12);
  coefficients[2] = {50, 0, 0, 0, 0};
  EXPECT_NEAR(WeightedFor(situation, coefficients).uav_way, HorizonSettings().uav_way * std::exp(2),
              1e-12)
      << "never without bounds";
}

TEST(LearnNodeValue, FindsTheSameAgainAndScoresMore) {
  NodeValueSettings settings;
  settings.scenarios = {Scant()};
  settings.generations = 3;
  settings.candidates = 6;
  settings.best = 2;
  std::vector<NodeValueProgress> told;
  const auto learn = [&] {
    return LearnNodeValue(settings, [&](const NodeValueProgress& now) { told.push_back(now); });
  };
  const WeightCoefficients first = learn();
  EXPECT_EQ(learn(), first);
  EXPECT_NE(first, WeightCoefficients{});
  ASSERT_EQ(told.size(), 6u);
  EXPECT_EQ(told[2].generation, 3);
  for (const NodeValueProgress& now : told) {
    EXPECT_GE(now.best, now.mean);
    EXPECT_GT(now.best, 0.2);
    EXPECT_LT(now.best, 1.2);
  }
}

}  // namespace
}  // namespace muster::learning
