// Decisions whose linear relaxation is degenerate: everybody is online for long, weights tie, and a
// site, a partner or a UAV is what all wait for.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <ostream>
#include <string>

#include "scheduler/solver/build.h"
#include "scheduler/solver/dual.h"
#include "scheduler/solver/relaxation.h"
#include "scheduler/solver/solver.h"
#include "tests/scheduler/solver/explicit_graph.h"
#include "tests/scheduler/solver/generated_situation.h"

namespace muster::scheduler {
namespace {

using testing::CbcOptimum;
using testing::GeneratedSituation;

struct Family {
  std::string name;
  GeneratorSettings settings;
  std::string found;  ///< steps, pivots, weights and bounds of all seeds, as they were
};
void PrintTo(const Family& family, std::ostream* out) { *out << family.name; }

GeneratorSettings LongOnline(int uavs, int workers, int vehicles, int tasks, double side_km) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.online_min = Always(180);
  settings.uavs = uavs;
  settings.workers = workers;
  settings.vehicles = vehicles;
  settings.tasks = tasks;
  settings.width_km = settings.height_km = side_km;
  settings.worker_speed_km_per_min = settings.vehicle_speed_km_per_min = 1;
  return settings;
}

class Degenerate : public ::testing::TestWithParam<Family> {};

TEST_P(Degenerate, RelaxationIsTheLinearProgramsAndTheAnswerWithinAThousandth) {
  int integral = 0, compared = 0;
  std::int64_t work = 0, pivots = 0;
  double weights = 0, bounds = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation =
        GeneratedSituation(GetParam().settings, seed, static_cast<std::int32_t>(1 + seed), 0.1);
    const Instance instance = BuildInstance(situation).instance;
    const auto value = CbcOptimum(instance, 20, testing::Nodes::kShared);
    ASSERT_TRUE(value.has_value());
    Dual dual(instance, 1);
    Relaxation relaxation(instance, &dual, 1);
    relaxation.Solve(100'000'000, [] { return false; });
    EXPECT_TRUE(relaxation.solved()) << CountNodes(instance) << " nodes";
    EXPECT_NEAR(relaxation.bound(), *value, 1e-8 * *value);
    const SolverResult solution = Solve(instance);
    EXPECT_TRUE(IsValid(instance, solution.assignment));
    EXPECT_LE(solution.gap(), 1e-3);
    EXPECT_LE(solution.assignment.weight, *value * (1 + 1e-9));
    integral += solution.assignment.weight >= *value * (1 - 1e-8);
    ++compared;
    work += solution.work + relaxation.work() + dual.work();
    pivots += relaxation.lp()->pivots();
    weights += solution.assignment.weight;
    bounds += solution.bound + relaxation.bound();
  }
  EXPECT_EQ(fmt::format("{} {} {:.10g} {:.10g}", work, pivots, weights, bounds), GetParam().found);
  EXPECT_GE(2 * integral, compared);
}

/// Fast UAVs, a small area and free places for all: nearly every action ties, and the relaxation
/// was not reached with the work that a decision may take, the gap up to a tenth.
TEST(DegenerateSettings, WhereNearlyAllTiesTheAnswerIsProven) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    GeneratorSettings settings = LongOnline(90, 96, 4, 80, 12);
    settings.uav_speed_km_per_min = 2;
    settings.charging_points = 2;
    settings.capacity = std::nullopt;
    const Instance instance = BuildInstance(GeneratedSituation(settings, seed, 6, 0.1)).instance;
    const SolverResult solution = Solve(instance);
    EXPECT_TRUE(IsValid(instance, solution.assignment));
    EXPECT_FALSE(std::isnan(solution.relaxation)) << CountNodes(instance) << " nodes";
    EXPECT_LE(solution.gap(), 1e-9);
  }
}

/// A limit that leaves the bound far off is raised, one that does not is kept.
TEST(DegenerateSettings, ARelaxationThatIsFarOffTakesMoreWork) {
  const Situation situation = GeneratedSituation(LongOnline(70, 20, 10, 40, 20), 1, 2, 0.1);
  const Instance instance = BuildInstance(situation).instance;
  const auto solve = [&](std::int64_t limit, std::int64_t if_far, std::int64_t* work) {
    Dual dual(instance, 1);
    Relaxation relaxation(instance, &dual, 1);
    relaxation.Solve(
        limit, [] { return false; }, if_far);
    *work = dual.work() + relaxation.work();
    return relaxation.solved();
  };
  std::int64_t needed = 0, work = 0;
  ASSERT_TRUE(solve(100'000'000, 0, &needed));
  EXPECT_FALSE(solve(needed / 2, 0, &work));
  EXPECT_LT(work, needed);
  EXPECT_FALSE(solve(needed / 2, 100'000'000, &work)) << "its bound is near by then";
  EXPECT_TRUE(solve(needed / 40, 100'000'000, &work));
  EXPECT_FALSE(solve(needed / 40, needed / 4, &work)) << "the second limit holds too";
  EXPECT_LT(work, needed / 2);
}

INSTANTIATE_TEST_SUITE_P(Families, Degenerate,
                         ::testing::Values(Family{"EqualSpeeds", LongOnline(30, 15, 20, 60, 30),
                                                  "5107368 2174 6854.842143 13709.68429"},
                                           Family{"SmallArea", LongOnline(30, 15, 20, 30, 10),
                                                  "8590336 2269 6890.529414 13781.05883"},
                                           Family{"ManyUavs", LongOnline(70, 20, 10, 40, 20),
                                                  "16361440 4135 8767.662761 17535.32552"},
                                           Family{"FewPartners", LongOnline(50, 5, 3, 60, 20),
                                                  "1798078 1149 2311.466095 4622.932325"}),
                         [](const auto& family) { return family.param.name; });

}  // namespace
}  // namespace muster::scheduler
