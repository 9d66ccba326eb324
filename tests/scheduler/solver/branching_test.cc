#include "scheduler/solver/branching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "scheduler/solver/dual.h"
#include "scheduler/solver/relaxation.h"
#include "tests/scheduler/solver/explicit_graph.h"

namespace muster::scheduler {
namespace {

const auto kGoOn = [] { return false; };

/// The three pairs of a triangle: any two share an agent or the site, so one can be taken, but the
/// relaxation takes a half of each.
TEST(Branching, ATriangleHasOneOfItsThreePairs) {
  const std::vector<std::int32_t> capacity(6, 1);  // two UAVs, two partners, two sites
  PackingLp lp(capacity);
  lp.AddColumn(10, {0, 2, 4});
  lp.AddColumn(9, {0, 3, 5});
  lp.AddColumn(8, {1, 2, 5});
  double best = 0;
  int whole = 0;
  Branching search(&lp, 2, 0,
                   {kGoOn, [&] { return best; },
                    [&] {
                      double weight = 0;
                      for (std::int32_t k = 0; k < 3; ++k) {
                        if (lp.value(k) > 0.5) weight += lp.cost(k);
                      }
                      best = std::max(best, weight);
                      ++whole;
                    }});
  EXPECT_TRUE(lp.Solve(1'000'000, kGoOn));
  EXPECT_NEAR(lp.Bound(), 13.5, 1e-9);
  EXPECT_NEAR(search.Search(std::numeric_limits<double>::infinity(), 1'000'000), 10, 1e-9);
  EXPECT_NEAR(best, 10, 1e-9);
  EXPECT_GT(whole, 0);
  // All is open again.
  EXPECT_TRUE(lp.Solve(1'000'000, kGoOn));
  EXPECT_NEAR(lp.Bound(), 13.5, 1e-9);
}

/// Where closing a column does not keep it out (here as it costs too little, elsewhere by
/// rounding), the same agents are picked again and again; the search ends all the same, and what it
/// returns is a bound.
TEST(Branching, EndsWhereClosedColumnsAreUsed) {
  int ended = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Instance instance = testing::RandomInstance(seed, 3, 11, 3);
    Dual dual(instance, 1);
    Relaxation relaxation(instance, &dual, 1);
    relaxation.Solve(1'000'000'000, kGoOn);
    const double stay = relaxation.stay_weight();
    Branching search(relaxation.lp(), instance.n_uavs(), dual.slack(),
                     {kGoOn, [] { return 0.0; }, [] {}}, 1e-3);
    const double bound =
        search.Search(std::numeric_limits<double>::infinity(), 1'000'000'000) + stay;
    ended += search.work() < 100'000'000;
    ASSERT_GE(bound, testing::BruteForce(instance).Best() - 1e-9);
  }
  EXPECT_EQ(ended, 400);
}

}  // namespace
}  // namespace muster::scheduler
