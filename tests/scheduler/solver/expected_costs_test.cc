#include "scheduler/solver/expected_costs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "base/random.h"
#include "model/generator.h"
#include "scheduler/solver/build.h"

namespace muster::scheduler {
namespace {

constexpr std::size_t kAlwaysExact = std::numeric_limits<std::size_t>::max();

/// Every weight of a decision, against the weight of staying (moves that hardly gain weigh next to
/// nothing and do not compete), on 8 times Random_29's size, spread evenly or in towns.
void ExpectWeightsWithinTolerance(bool towns) {
  const GeneratorSettings settings = Scaled(PresetByName("Random_29"), 8);
  Scenario scenario = Generate(settings, 5);
  if (towns) {
    const auto gather = [](Point* p) {
      p->x_m = std::floor(p->x_m / 30e3) * 30e3 + std::fmod(p->x_m, 30e3) / 4;
      p->y_m = std::floor(p->y_m / 30e3) * 30e3 + std::fmod(p->y_m, 30e3) / 4;
    };
    for (auto& task : scenario.tasks) gather(&task.at);
    for (auto& charge : scenario.charging_points) gather(&charge.at);
    for (auto* agents : {&scenario.uavs, &scenario.workers, &scenario.vehicles}) {
      for (AgentSpec& agent : *agents) gather(&agent.at);
    }
  }
  Situation situation;
  situation.site = std::make_shared<const Site>(scenario);
  Random random(1, Stream::kTest);
  const auto add = [&](AgentKind kind, std::vector<AgentState>* agents) {
    std::int32_t id = 0;
    for (AgentSpec spec : scenario.agents(kind)) {
      spec.online_from_us = 0;
      spec.range_m *= random.Uniform(0.2, 1);
      agents->push_back(StartOf(kind, id++, spec, *scenario.ways));
    }
  };
  add(AgentKind::kUav, &situation.uavs);
  add(AgentKind::kWorker, &situation.workers);
  add(AgentKind::kVehicle, &situation.vehicles);
  situation.task_status.assign(scenario.tasks.size(), TaskStatus::kOpen);
  situation.charging_load.assign(scenario.charging_points.size(), 0);
  ASSERT_GT(scenario.tasks.size(), 3 * kExactPlaces);

  const Instance exact = BuildInstance(situation, 1, kAlwaysExact).instance;
  const Instance fast = BuildInstance(situation, 1, 64).instance;
  ASSERT_EQ(exact.uav_arcs.size(), fast.uav_arcs.size());
  ASSERT_EQ(exact.partner_arcs.size(), fast.partner_arcs.size());
  ASSERT_GT(exact.partner_arcs.size(), 10000u);
  double worst = 0;
  const auto compare = [&](double a, double b) {
    if (a != Instance::kNone) worst = std::max(worst, std::abs(a - b) / std::log(2.0));
  };
  for (std::size_t i = 0; i < exact.uav_arcs.size(); ++i) {
    compare(exact.uav_arcs[i].solo, fast.uav_arcs[i].solo);
    compare(exact.uav_arcs[i].pair_gain, fast.uav_arcs[i].pair_gain);
  }
  for (std::size_t j = 0; j < exact.partner_arcs.size(); ++j) {
    compare(exact.partner_arcs[j].gain, fast.partner_arcs[j].gain);
  }
  ::testing::Test::RecordProperty("worst", std::to_string(worst));
  EXPECT_LE(worst, kCostTolerance);
  EXPECT_GT(worst, 0);
}

TEST(LongExpectedCosts, WeightsOfAnEvenSpreadAreWithinTolerance) {
  ExpectWeightsWithinTolerance(false);
}
TEST(LongExpectedCosts, WeightsOfTownsAreWithinTolerance) { ExpectWeightsWithinTolerance(true); }

}  // namespace
}  // namespace muster::scheduler
