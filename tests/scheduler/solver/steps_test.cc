// How the solver gets where it gets: weights and sizes of instances, and weight, bound and number
// of steps of their solutions. Steps are a measure of speed that repeats on every machine. Where a
// change is meant to move them, the new lines (printed by a failure) and what was gained belong in
// its commit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "scheduler/solver/build.h"
#include "scheduler/solver/solver.h"
#include "tests/scheduler/situation_builder.h"
#include "tests/scheduler/solver/explicit_graph.h"

namespace muster::scheduler {
namespace {

std::string Found(const Instance& instance) {
  SolverLimits limits;
  limits.work = 1'000'000;
  const SolverResult solution = Solve(instance, limits);
  EXPECT_TRUE(IsValid(instance, solution.assignment));
  return fmt::format("{:.10g} {:.10g} {}", solution.assignment.weight, solution.bound,
                     solution.work);
}

TEST(Steps, OfRandomInstancesAreThoseTheyWere) {
  struct Case {
    std::uint64_t seed;
    int uavs, partners, sites;
    const char* found;
  };
  const Case cases[] = {
      {1, 6, 7, 6, "279.6333333 279.6333333 3539"},
      {2, 6, 7, 6, "297.3888889 297.3888889 1930"},
      {3, 9, 9, 8, "279.3701728 279.3701728 569"},
      {4, 12, 10, 8, "372.5651804 372.5651804 3246"},
      {5, 14, 16, 12, "1092.686053 1092.686053 25916"},
      {6, 20, 22, 16, "1382.172498 1382.172498 36857"},
      {7, 30, 36, 24, "1978.266667 1978.266667 381575"},
      {8, 30, 30, 30, "2656.777778 2656.777778 742343"},
      {9, 40, 44, 30, "2653.733333 2781.655556 1038180"},
      {10, 60, 50, 40, "3302.033333 3750.955556 3263132"},
      {11, 70, 90, 60, "5049.937083 5734.94306 1721039"},
      {12, 80, 70, 60, "5247.024008 5980.418592 1080504"},
      {14, 90, 100, 60, "6245.513276 9090.038315 1131903"},
      {19, 90, 100, 60, "5157.8 6052.15 1156368"},
      {21, 24, 20, 16, "1108.149754 1108.149754 59592"},
      {22, 24, 20, 16, "1239.533333 1239.533333 95369"},
      {23, 40, 40, 20, "1448.3722 1448.3722 23029"},
      {24, 40, 60, 20, "1838.936413 1838.936413 77796"},
      {25, 25, 12, 30, "1240.114114 1240.114114 74667"},
      {26, 50, 60, 50, "4840.533333 5139.1 1082731"},
      {27, 50, 60, 50, "3995.206022 4564.668475 1091112"},
      {28, 24, 24, 6, "474.8406801 474.8406801 1492"},
  };
  for (const Case& c : cases) {
    EXPECT_EQ(Found(testing::RandomInstance(c.seed, c.uavs, c.partners, c.sites)), c.found)
        << "seed " << c.seed << ", " << c.uavs << " UAVs";
  }
}

/// Twenty at a time: sums of weights, bounds and steps.
TEST(Steps, OfManySmallInstancesAreThoseTheyWere) {
  struct Case {
    int uavs, partners, sites;
    std::int64_t work;  ///< limit
    double weight, bound;
    std::int64_t steps;
  };
  const Case cases[] = {
      {12, 12, 9, 30000, 10700.86578, 10725.71578, 169618},
      {12, 12, 9, 300000, 10212.49445, 10212.49445, 134084},
      {16, 18, 14, 300000, 18368.42321, 18368.42321, 1358104},
      {18, 9, 12, 300000, 13058.40528, 13058.40528, 171908},
      {9, 18, 12, 300000, 11199.53707, 11199.53707, 312292},
      {20, 20, 8, 300000, 11981.75674, 11981.75674, 164497},
      {24, 26, 24, 500000, 38763.8863, 39951.18693, 9034059},
      {16, 16, 30, 300000, 27726.44825, 27884.65081, 1403273},
      {30, 30, 20, 20000, 35232.10402, 41648.03023, 636613},
      {30, 30, 20, 3000, 31094.25796, 54709.38225, 350266},
  };
  std::uint64_t seed = 100;
  for (const Case& c : cases) {
    double weight = 0, bound = 0;
    std::int64_t steps = 0;
    for (int i = 0; i < 20; ++i) {
      SolverLimits limits;
      limits.work = c.work;
      const SolverResult solution =
          Solve(testing::RandomInstance(seed++, c.uavs, c.partners, c.sites), limits);
      weight += solution.assignment.weight;
      bound += solution.bound;
      steps += solution.work;
    }
    EXPECT_EQ(fmt::format("{:.10g}, {:.10g}, {}", weight, bound, steps),
              fmt::format("{:.10g}, {:.10g}, {}", c.weight, c.bound, c.steps))
        << c.uavs << " UAVs";
  }
}

/// Number of arcs and sums over them, each weighed by its place so that order counts.
std::string Told(const Instance& instance) {
  double uavs = 0, partners = 0, places = 1;
  for (const auto& arc : instance.uav_arcs) {
    uavs += places * (arc.level + (arc.solo == Instance::kNone ? -1 : arc.solo) + arc.base +
                      (arc.pair_gain == Instance::kNone ? -2 : arc.pair_gain));
    places += 0.1;
  }
  for (const auto& arc : instance.partner_arcs) {
    partners += places * (arc.level + arc.gain + (arc.solo ? 1 : 0));
    places += 0.1;
  }
  return fmt::format("{} {} {:.11g} {:.11g}", instance.uav_arcs.size(),
                     instance.partner_arcs.size(), uavs, partners);
}

TEST(Steps, OfSituationsAreThoseTheyWere) {
  struct Case {
    std::uint64_t seed;
    Availability availability;
    std::size_t exact_up_to, all_pairs_up_to;
    const char *told, *found;
  };
  const auto strict = Availability::kStrict, overrun = Availability::kOverrun;
  const Case cases[] = {
      {1, strict, 512, kAllPairs, "582 1138 803475.83498 590167.22999",
       "1959.575925 1959.575925 22708"},
      {2, strict, 512, kAllPairs, "681 1495 1037838.6197 1067982.0675",
       "1769.91221 1769.91221 17644"},
      {3, overrun, 512, kAllPairs, "922 3450 2253889.5194 6854910.2754",
       "1704.580037 1704.580037 32418"},
      {4, overrun, 512, 0, "1316 3594 3686605.0304 7544200.9994", "2317.583682 2317.583682 42437"},
      {5, overrun, 8, 0, "1031 3312 2454033.9372 5753320.9199", "2104.842964 2104.842964 51933"},
      {6, strict, 8, kAllPairs, "788 1057 1409942.8012 651127.98548",
       "2197.269379 2197.269379 12513"},
      {7, strict, 8, kAllPairs, "1040 1317 2806143.2175 1062835.5866",
       "2070.981936 2070.981936 22390"},
      {8, overrun, 8, kAllPairs, "1012 3492 2386264.0273 7440307.5317",
       "2072.372059 2072.372059 35474"},
      {9, strict, 1, kAllPairs, "689 1186 1133118.926 757339.7178",
       "1648.502756 1648.502756 33213"},
      {10, overrun, 20, 100, "1168 3226 2958808.3685 5963929.891", "2055.756082 2055.756082 58555"},
  };
  for (const Case& c : cases) {
    Rules rules;
    rules.availability = c.availability;
    const Situation situation = testing::RandomSituation(c.seed, {40, 50, 30, 90, 40, 40}, rules);
    const Instance instance =
        BuildInstance(situation, 1, c.exact_up_to, c.all_pairs_up_to).instance;
    EXPECT_EQ(Told(instance), c.told) << "seed " << c.seed;
    EXPECT_EQ(Found(instance), c.found) << "seed " << c.seed;
  }
}

}  // namespace
}  // namespace muster::scheduler
