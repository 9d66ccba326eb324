#include "scheduler/solver/matchings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "scheduler/solver/dual.h"
#include "scheduler/solver/plan.h"
#include "tests/scheduler/solver/explicit_graph.h"

namespace muster::scheduler {
namespace {

using testing::BruteForce;
using testing::RandomInstance;

Assignment AssignmentOf(const Plan& plan) {
  Assignment assignment;
  for (const Column& column : plan.column) {
    assignment.uavs.push_back({column.site, column.uav_arc, column.partner_arc});
  }
  for (const Dual::Solo* own : plan.own) {
    assignment.partner_solo.push_back(own == nullptr ? -1 : own->arc);
  }
  return assignment;
}

bool Never() { return false; }

/// Nobody but the first UAV acts, so that much is left to do.
Plan Poor(const Instance& instance, const Planner& planner, const Dual& dual) {
  Plan plan = planner.Empty();
  if (instance.n_uavs() > 0 && dual.best(0).site >= 0) planner.Put(&plan, 0, dual.best(0));
  planner.Weigh(&plan);
  return plan;
}

TEST(Matchings, PlansStayValidAndGetNoWorse) {
  int better = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Instance instance = RandomInstance(seed, 14, 12 + static_cast<int>(seed % 5), 10);
    Dual dual(instance, 1);
    dual.Evaluate();
    const Planner planner(instance, dual);
    Plan plan = planner.Empty();
    planner.Fill(&plan);
    planner.Weigh(&plan);
    const double before = plan.weight;
    Matchings matchings(instance, dual, 1);
    matchings.Improve(&plan, Never);
    const Assignment assignment = AssignmentOf(plan);
    ASSERT_TRUE(IsValid(instance, assignment));
    ASSERT_NEAR(WeightOf(instance, assignment), plan.weight, 1e-9);
    ASSERT_GE(plan.weight, before);
    better += plan.weight > before + 1e-6;
    EXPECT_GT(matchings.work(), 0);
  }
  EXPECT_GT(better, 40);
}

TEST(Matchings, ReachNearlyEveryOptimumOfSmallInstances) {
  int optimal = 0, all = 0;
  double weights = 0, optima = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Instance instance =
        RandomInstance(seed, 2 + static_cast<int>(seed % 3), 2 + static_cast<int>(seed / 3 % 3), 3);
    Dual dual(instance, 1);
    dual.Evaluate();
    const Planner planner(instance, dual);
    Plan plan = Poor(instance, planner, dual);
    Matchings matchings(instance, dual, 1);
    matchings.Improve(&plan, Never);
    const double optimum = BruteForce(instance).Best();
    ASSERT_TRUE(IsValid(instance, AssignmentOf(plan)));
    ASSERT_LE(plan.weight, optimum + 1e-9);
    optimal += plan.weight >= optimum - 1e-6;
    ++all;
    weights += plan.weight;
    optima += optimum;
  }
  EXPECT_GE(optimal, all * 9 / 10) << optimal << " of " << all;
  EXPECT_GE(weights, 0.95 * optima);
}

/// One site, and two UAVs and partners with one arc each to it or to the next.
TEST(Matchings, APartnerThatIsLeftOverIsTakenAlong) {
  Instance instance;
  instance.uavs = {{.stay = 0.5}, {.stay = 0.5}};
  instance.partners = {{.stay = 0.5}, {.stay = 0.5}};
  instance.capacity = {1, 1};
  const auto uav = [](std::int32_t u) {
    return Instance::UavArc{.uav = u, .base = 100, .pair_gain = 1};
  };
  const auto partner = [](std::int32_t p) {
    return Instance::PartnerArc{.partner = p, .gain = 1, .solo = false};
  };
  // UAV 0 can go to both sites, UAV 1 to the first alone; partner 0 to both, partner 1 to the
  // second.
  instance.uav_arcs = {uav(0), uav(1), uav(0)};
  instance.uav_begin = {0, 2, 3};
  instance.partner_arcs = {partner(0), partner(0), partner(1)};
  instance.partner_begin = {0, 1, 3};
  Dual dual(instance, 1);
  dual.Evaluate();
  const Planner planner(instance, dual);
  Plan plan = planner.Empty();
  planner.Put(&plan, 0, {0, 0, 0, 0});  // UAV 0 and partner 0 where UAV 1 has its only site
  Matchings matchings(instance, dual, 1);
  matchings.Improve(&plan, Never);
  EXPECT_NEAR(plan.weight, 204, 1e-9);
  EXPECT_EQ(plan.partner_of[0], 1);
  EXPECT_EQ(plan.partner_of[1], 0);
}

TEST(Matchings, StopWhenTheyAreTold) {
  const Instance instance = RandomInstance(5, 14, 16, 12);
  Dual dual(instance, 1);
  dual.Evaluate();
  const Planner planner(instance, dual);
  Plan plan = Poor(instance, planner, dual);
  const double before = plan.weight;
  Matchings(instance, dual, 2).Improve(&plan, [] { return true; });
  EXPECT_EQ(plan.weight, before);
}

}  // namespace
}  // namespace muster::scheduler
