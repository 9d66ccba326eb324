#include "scheduler/policies/baselines/distance_sums.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/random.h"

namespace muster::scheduler {
namespace {

double SumTo(const std::vector<Point>& targets, Point from) {
  double sum = 0;
  for (const Point target : targets) sum += Distance(from, target);
  return sum;
}

std::vector<Point> Targets(std::uint64_t seed, int n, double side_m) {
  Random random(seed, Stream::kTest);
  std::vector<Point> targets;
  for (int i = 0; i < n; ++i) {
    const double x_m = side_m * random.Uniform();
    targets.push_back({x_m, side_m * random.Uniform()});
  }
  return targets;
}

TEST(DistanceSums, BoundsHoldTheSumOfEveryCell) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    // From all targets close to the cells to most of them far away.
    const double side_m = 20e3 * static_cast<double>(seed * seed);
    const std::vector<Point> targets = Targets(seed, 400, side_m);
    DistanceSums sums(targets, 1000);
    for (int row = 0; row < 50; ++row) {
      for (int column = 0; column < 50; ++column) {
        const double sum = SumTo(targets, {(column + 0.5) * 1000, (row + 0.5) * 1000});
        const auto [least, most] = sums.BoundsOf(column, row);
        EXPECT_LE(least, sum);
        EXPECT_GE(most, sum);
        EXPECT_LT(most - least, 0.1 * sum);
      }
    }
  }
}

/// A single far target: the polynomial alone, good to the fourth power of block over distance.
TEST(DistanceSums, BoundsAreCloseWhereTargetsAreFar) {
  const std::vector<Point> targets = {{1e6, 3e5}, {8e5, -4e5}};
  DistanceSums sums(targets, 1000);
  const double sum = SumTo(targets, {500, 500});
  const auto [least, most] = sums.BoundsOf(0, 0);
  EXPECT_NEAR((least + most) / 2, sum, 1e-2);
  EXPECT_LT(most - least, 0.05);
  // Of the polynomial, the fourth power of what is from the middle of the block is left out.
  const auto beside_the_middle = sums.BoundsOf(7, 8), corner = sums.BoundsOf(15, 0);
  EXPECT_LT(beside_the_middle.most - beside_the_middle.least, 1e-4);
  EXPECT_NEAR(corner.most - corner.least, most - least, 1e-6);
}

}  // namespace
}  // namespace muster::scheduler
