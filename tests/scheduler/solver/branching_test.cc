#include "scheduler/solver/branching.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "base/random.h"
#include "scheduler/solver/dual.h"
#include "scheduler/solver/packing_lp.h"
#include "scheduler/solver/relaxation.h"
#include "tests/scheduler/solver/explicit_graph.h"

namespace muster::scheduler {
namespace {

const auto kGoOn = [] { return false; };

constexpr std::int32_t kNoRow = PackingLp::kNoRow;

/// By hand. The first column alone would be worth 5; the other two fill the same three rows for 6
/// (prices 3, 0, 3 and 0: reduced costs -1, 0, 0).
TEST(PackingLp, TwoColumnsInsteadOfTheDearest) {
  PackingLp lp(std::vector<std::int32_t>{1, 1, 1, 1});
  lp.AddColumn(5, {0, 1, 2});
  lp.AddColumn(3, {0, kNoRow, 3});
  lp.AddColumn(3, {kNoRow, 1, 2});
  ASSERT_TRUE(lp.Solve(1'000'000, kGoOn));
  EXPECT_NEAR(lp.Bound(), 6, 1e-9);
  EXPECT_NEAR(lp.value(0), 0, 1e-5);
  EXPECT_NEAR(lp.value(1), 1, 1e-5);
  EXPECT_NEAR(lp.value(2), 1, 1e-5);
  EXPECT_NEAR(lp.prices()[0] + lp.prices()[3], 3, 1e-9);
  EXPECT_NEAR(lp.prices()[1] + lp.prices()[2], 3, 1e-9);
  // A column that comes later: 4 for row 0 alone displaces the 3.
  lp.AddColumn(4, {0, kNoRow, kNoRow});
  ASSERT_TRUE(lp.Solve(1'000'000, kGoOn));
  EXPECT_NEAR(lp.Bound(), 7, 1e-9);
  // Without it, as before; with row 3 to be used up too.
  lp.Close(3, true);
  EXPECT_TRUE(lp.Require(3, true));
  EXPECT_FALSE(lp.Require(3, true));
  ASSERT_TRUE(lp.Solve(1'000'000, kGoOn));
  EXPECT_NEAR(lp.Bound(), 6, 1e-8);
  lp.Close(3, false);
  EXPECT_TRUE(lp.Require(3, false));
  ASSERT_TRUE(lp.Solve(1'000'000, kGoOn));
  EXPECT_NEAR(lp.Bound(), 7, 1e-8);
}

/// What closed columns cost leaves rounding, which Verify allows.
constexpr double kRounding = 1e-5;

/// Values within the rows and prices that no column exceeds, both of the same worth: neither can be
/// improved upon.
void ExpectOptimal(const PackingLp& lp, const std::vector<std::int32_t>& capacity) {
  std::vector<double> used(capacity.size(), 0);
  double worth = 0;
  for (std::int32_t k = 0; k < lp.n_columns(); ++k) {
    EXPECT_GE(lp.value(k), -kRounding);
    double reduced = lp.cost(k);
    for (const std::int32_t r : lp.rows(k)) {
      if (r < 0) continue;
      used[static_cast<std::size_t>(r)] += lp.value(k);
      reduced -= lp.prices()[static_cast<std::size_t>(r)];
    }
    EXPECT_LE(reduced, kRounding) << "column " << k;
    worth += lp.value(k) * lp.cost(k);
  }
  for (std::size_t r = 0; r < capacity.size(); ++r) {
    EXPECT_LE(used[r], capacity[r] + kRounding);
    EXPECT_GE(lp.prices()[r], -kRounding);
  }
  EXPECT_NEAR(worth, lp.Bound(), 1e-4 * (1 + lp.Bound()));
}

/// Few different costs and many columns for each row: nearly every step is degenerate. Pivots,
/// steps and optimum are those that they were.
TEST(PackingLp, ProvesItsOptimumWhereAllTies) {
  const char* known[] = {
      "432 428015 93.1666667",    "6685 21303114 315.298701",  "722 872047 80",
      "7002 11012041 83.0000003", "11710 71716174 455.759493", "3563 7111082 196.666667",
      "1406 5904685 131.666667",  "11224 68983427 426.562677", "5233 11258893 332.625",
      "8887 36512535 378",        "8845 40077504 393.744966",  "11494 63142289 443.259662"};
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed, Stream::kPolicy, 0, 0);
    const auto n = 5 + random.Below(60);
    std::vector<std::int32_t> capacity(std::size_t{3} * n, 1);
    for (std::size_t r = std::size_t{2} * n; r < capacity.size(); ++r) {
      capacity[r] += static_cast<std::int32_t>(random.Below(3));
    }
    PackingLp lp(capacity);
    const auto add = [&](std::uint32_t columns) {
      for (std::uint32_t k = 0; k < columns; ++k) {
        const auto row = [&](std::uint32_t kind) {
          return static_cast<std::int32_t>(kind * n + random.Below(n));
        };
        const double cost = 1 + random.Below(4);
        const std::int32_t uav = random.Below(8) == 0 ? kNoRow : row(0);
        const std::int32_t partner = random.Below(8) == 0 ? kNoRow : row(1);
        lp.AddColumn(cost, {uav, partner, row(2)});
      }
    };
    for (int round = 0; round < 3; ++round) {
      add(10 * n);
      ASSERT_TRUE(lp.Solve(100'000'000, kGoOn));
      ExpectOptimal(lp, capacity);
    }
    // Whatever is closed and opened again, the program is the one it was; some go on for long
    // enough that devex weights take over.
    const double bound = lp.Bound();
    const std::int64_t until = seed % 4 == 0 ? 11'000'000 : 0;
    for (int round = 0; round < 20 || lp.work() < until; ++round) {
      std::vector<std::int32_t> closed;
      for (std::uint32_t k = 0; k < n; ++k) {
        closed.push_back(
            static_cast<std::int32_t>(random.Below(static_cast<std::uint32_t>(lp.n_columns()))));
        lp.Close(closed.back(), true);
      }
      ASSERT_TRUE(lp.Solve(100'000'000, kGoOn));
      EXPECT_LE(lp.Bound(), bound + kRounding);
      for (const std::int32_t k : closed) lp.Close(k, false);
      ASSERT_TRUE(lp.Solve(100'000'000, kGoOn));
      EXPECT_NEAR(lp.Bound(), bound, kRounding);
    }
    ExpectOptimal(lp, capacity);
    EXPECT_EQ(fmt::format("{} {} {:.9g}", lp.pivots(), lp.work(), lp.Bound()), known[seed - 1]);
  }
}

/// As many rows as a decision of several hundred agents has. Its inverse fills up, and devex
/// weights grow until they overflowed, so that the best columns counted for nothing.
TEST(PackingLp, ProvesItsOptimumWhereTheInverseFillsUp) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed, Stream::kPolicy, 0, 0);
    const std::uint32_t n = 300;
    const std::vector<std::int32_t> capacity(std::size_t{3} * n, 1);
    PackingLp lp(capacity);
    for (int round = 0; round < 2; ++round) {
      for (std::uint32_t k = 0; k < 4 * n; ++k) {
        const auto row = [&](std::uint32_t kind) {
          return static_cast<std::int32_t>(kind * n + random.Below(n));
        };
        const double cost = 1 + random.Below(4);
        lp.AddColumn(cost, {row(0), row(1), row(2)});
      }
      ASSERT_TRUE(lp.Solve(3'000'000'000, kGoOn));
      ExpectOptimal(lp, capacity);
    }
    EXPECT_TRUE(lp.has_factors());
    const double bound = lp.Bound();
    std::vector<std::int32_t> closed;
    for (std::uint32_t k = 0; k < n / 10; ++k) {
      closed.push_back(
          static_cast<std::int32_t>(random.Below(static_cast<std::uint32_t>(lp.n_columns()))));
      lp.Close(closed.back(), true);
    }
    ASSERT_TRUE(lp.Solve(3'000'000'000, kGoOn));
    EXPECT_LE(lp.Bound(), bound + kRounding);
    for (const std::int32_t k : closed) lp.Close(k, false);
    ASSERT_TRUE(lp.Solve(3'000'000'000, kGoOn));
    EXPECT_NEAR(lp.Bound(), bound, 1e-3);
    ExpectOptimal(lp, capacity);
  }
}

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
  std::int64_t work = 0;
  double bounds = 0;
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
    work += search.work() + relaxation.work() + dual.work();
    bounds += bound + relaxation.bound();
    ASSERT_GE(bound, testing::BruteForce(instance).Best() - 1e-9);
  }
  EXPECT_EQ(ended, 400);
  EXPECT_EQ(fmt::format("{} {:.10g}", work, bounds), "176592 86455.20314")
      << "steps and bounds were others";
}

}  // namespace
}  // namespace muster::scheduler
