#include "scheduler/solver/solver.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "scheduler/solver/build.h"
#include "tests/cases.h"
#include "tests/scheduler/solver/explicit_graph.h"
#include "tests/scheduler/solver/generated_situation.h"

namespace muster::scheduler {
namespace {

using testing::BruteForce;
using testing::CbcOptimum;
using testing::GeneratedSituation;
using testing::RandomInstance;

/// Weights and bounds differ from another solver's by the order of additions alone.
constexpr double kSame = 1e-6;

TEST(Solver, FindsAndProvesTheOptimumOfSmallInstances) {
  std::uint64_t pairs = 0, not_proven = 0;
  for (std::uint64_t seed = 0; seed < Cases(200, 1500); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Instance instance =
        RandomInstance(seed, 1 + static_cast<int>(seed % 4), 1 + static_cast<int>(seed / 4 % 4),
                       1 + static_cast<int>(seed / 16 % 3));
    const SolverResult solution = Solve(instance);
    const double optimum = BruteForce(instance).Best();
    ASSERT_TRUE(IsValid(instance, solution.assignment));
    ASSERT_NEAR(solution.assignment.weight, optimum, kSame);
    ASSERT_GE(solution.bound, optimum);
    not_proven += solution.bound > optimum + kSame;
    for (const auto& choice : solution.assignment.uavs) pairs += choice.partner_arc >= 0;
  }
  EXPECT_EQ(not_proven, 0U);
  EXPECT_GT(pairs, Cases(60, 500));
}

TEST(Solver, BoundHoldsAtAnyWorkLimit) {
  for (std::uint64_t seed = 0; seed < Cases(150, 1000); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Instance instance = RandomInstance(seed, 4, 4, 3);
    SolverLimits limits;
    limits.work = 1 + static_cast<std::int64_t>(seed % 40) * 10;
    const SolverResult solution = Solve(instance, limits);
    const double optimum = BruteForce(instance).Best();
    ASSERT_TRUE(IsValid(instance, solution.assignment));
    ASSERT_GE(solution.bound, optimum);
    ASSERT_LE(solution.assignment.weight, optimum + kSame);
    ASSERT_NEAR(solution.assignment.weight, WeightOf(instance, solution.assignment), 1e-9);
  }
}

TEST(Solver, AnyDeadlineGivesAValidAnswerAndABound) {
  const auto after = [](int microseconds) {
    SolverLimits limits;
    limits.deadline = std::chrono::steady_clock::now() + std::chrono::microseconds(microseconds);
    return limits;
  };
  for (std::uint64_t seed = 0; seed < Cases(60, 300); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Instance instance = RandomInstance(seed, 4, 4, 3);
    const SolverResult solution = Solve(instance, after(static_cast<int>(seed % 30)));
    const double optimum = BruteForce(instance).Best();
    ASSERT_TRUE(IsValid(instance, solution.assignment));
    ASSERT_GE(solution.bound, optimum);
    ASSERT_LE(solution.assignment.weight, optimum + kSame);
  }
  const Instance large =
      BuildInstance(GeneratedSituation(Scaled(PresetByName("Random_29"), 8), 3, 6, 0.5)).instance;
  const SolverResult whole = Solve(large);
  for (const int microseconds : {-1000, 0, 100, 1000, 5000, 20000}) {
    SCOPED_TRACE(std::to_string(microseconds) + " us");
    const SolverResult solution = Solve(large, after(microseconds));
    EXPECT_TRUE(IsValid(large, solution.assignment));
    EXPECT_GE(solution.bound, whole.assignment.weight);
    EXPECT_LE(solution.assignment.weight, whole.bound);
    // Nobody is left without an action that the first prices already tell of.
    EXPECT_GE(solution.assignment.weight, 0.5 * whole.assignment.weight);
  }
}

TEST(Solver, EqualsCbcOnMissionsUpTo10000Nodes) {
  int proven = 0, compared = 0;
  std::int64_t most_nodes = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const GeneratorSettings& preset = Presets()[(seed * 5) % Presets().size()];
    SCOPED_TRACE(preset.name + " seed " + std::to_string(seed));
    const Situation situation =
        GeneratedSituation(preset, seed, static_cast<std::int32_t>(3 + seed % 10),
                           0.1 * static_cast<double>(seed % 9));
    const BuiltInstance built = BuildInstance(situation);
    const std::int64_t nodes = CountNodes(built.instance);
    if (nodes > 10000) continue;
    const auto optimum = CbcOptimum(built.instance, 20);
    if (!optimum) continue;
    ++compared;
    most_nodes = std::max(most_nodes, nodes);
    SolverLimits limits;
    limits.work = 200'000'000;
    const SolverResult solution = Solve(built.instance, limits);
    EXPECT_TRUE(IsValid(built.instance, solution.assignment));
    EXPECT_NEAR(solution.assignment.weight, *optimum, kSame) << nodes << " nodes";
    EXPECT_GE(solution.bound, *optimum - kSame);
    EXPECT_LE(solution.gap(), 0.001);
    proven += solution.bound <= *optimum + kSame;
  }
  EXPECT_GE(compared, 8);
  EXPECT_GE(most_nodes, 3000);
  EXPECT_GE(proven, compared - 1);
}

TEST(Solver, EqualsCbcOnDenseRandomInstances) {
  for (std::uint64_t seed = 0; seed < Cases(4, 25); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Instance instance = RandomInstance(seed, 8, 9, 7);
    const auto optimum = CbcOptimum(instance, 20);
    ASSERT_TRUE(optimum.has_value());
    SolverLimits limits;
    limits.work = 200'000'000;
    const SolverResult solution = Solve(instance, limits);
    EXPECT_TRUE(IsValid(instance, solution.assignment));
    EXPECT_NEAR(solution.assignment.weight, *optimum, kSame);
    EXPECT_GE(solution.bound, *optimum - kSame);
  }
}

TEST(Solver, BoundsCountPartnersThatAreNotListed) {
  int tight = 0, fewer = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Situation situation = GeneratedSituation(
        Scaled(PresetByName("Random_29"), 1 + static_cast<double>(seed % 2)), seed, 3, 0.4);
    auto site = std::make_shared<Site>(*situation.site);
    site->rules.availability = Availability::kOverrun;
    situation.site = site;
    if (seed % 4 == 0) {
      // All workers in a corner, so that those far away count.
      double y_m = 0;
      for (AgentState& worker : situation.workers) worker.from = worker.to = {0, y_m += 1};
    }
    const Instance all = BuildInstance(situation).instance;
    const Instance near = BuildInstance(situation, 1, kExactPlaces, 0).instance;
    const SolverResult optimum = Solve(all), solution = Solve(near);
    EXPECT_TRUE(IsValid(near, solution.assignment));
    EXPECT_GE(solution.bound, optimum.assignment.weight - kSame);
    EXPECT_LE(solution.assignment.weight, optimum.bound + kSame);
    tight += solution.bound <= optimum.assignment.weight * (1 + 1e-3);
    fewer += near.partner_arcs.size() < all.partner_arcs.size();
  }
  EXPECT_GE(fewer, 8);
  EXPECT_GE(tight, 6);
}

TEST(Solver, TwoThreadsGiveTheAnswerOfOne) {
  const Situation situation = GeneratedSituation(Scaled(PresetByName("Random_29"), 12), 3, 6, 0.5);
  const BuiltInstance one = BuildInstance(situation, 1), two = BuildInstance(situation, 2);
  ASSERT_EQ(one.instance.uav_arcs.size(), two.instance.uav_arcs.size());
  ASSERT_GT(one.instance.uav_arcs.size() + one.instance.partner_arcs.size(), 100000u);
  for (std::size_t i = 0; i < one.instance.uav_arcs.size(); ++i) {
    ASSERT_EQ(one.instance.uav_arcs[i].solo, two.instance.uav_arcs[i].solo);
    ASSERT_EQ(one.instance.uav_arcs[i].pair_gain, two.instance.uav_arcs[i].pair_gain);
  }
  SolverLimits limits;
  limits.work = 20'000'000;
  const SolverResult a = Solve(one.instance, limits);
  limits.threads = 2;
  const SolverResult b = Solve(two.instance, limits);
  EXPECT_EQ(a.assignment.weight, b.assignment.weight);
  EXPECT_EQ(a.bound, b.bound);
  for (std::size_t u = 0; u < a.assignment.uavs.size(); ++u) {
    ASSERT_EQ(a.assignment.uavs[u].uav_arc, b.assignment.uavs[u].uav_arc);
    ASSERT_EQ(a.assignment.uavs[u].partner_arc, b.assignment.uavs[u].partner_arc);
  }
  EXPECT_EQ(a.assignment.partner_solo, b.assignment.partner_solo);
}

}  // namespace
}  // namespace muster::scheduler
