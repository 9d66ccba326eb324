// Sums over many places, taken together by cells: close to those over each place, and the same as
// ever. Where a change is meant to move them, the new lines (printed by a failure) and the reason
// belong in its commit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "base/random.h"
#include "scheduler/solver/expected_costs.h"

namespace muster::scheduler {
namespace {

constexpr std::size_t kEveryOneExact = std::numeric_limits<std::size_t>::max();
/// Of one sum; the weights that are made of many are closer (expected_costs_test.cc).
constexpr double kClose = 1e-2;

enum class Spread { kEven, kTowns, kLine, kSpots, kGrid };

/// Places in a square; on the grid their ways are whole intervals of 6 km, along it.
std::vector<Point> Places(Random* random, Spread spread, std::size_t n, double side_m) {
  std::vector<Point> places;
  const auto uniform = [&] { return random->Uniform() * side_m; };
  for (std::size_t i = 0; i < n; ++i) {
    Point p{uniform(), uniform()};
    switch (spread) {
      case Spread::kEven:
        break;
      case Spread::kTowns:
        p = {std::floor(p.x_m / 30e3) * 30e3 + std::fmod(p.x_m, 30e3) / 6,
             std::floor(p.y_m / 30e3) * 30e3 + std::fmod(p.y_m, 30e3) / 6};
        break;
      case Spread::kLine:
        p.y_m = 500;
        break;
      case Spread::kSpots:
        p = {std::round(p.x_m / 9e3) * 9e3, std::round(p.y_m / 7e3) * 7e3};
        break;
      case Spread::kGrid:
        p = {std::round(p.x_m / 6e3) * 6e3, 0};
        break;
    }
    places.push_back(p);
  }
  return places;
}

struct PlacesCase {
  Spread spread;
  std::size_t places, queries;
  double side_m, speed_m_s;
  const char* found;  ///< sums of means and of levels, weighed so that order counts
};

TEST(PlaceSums, IsTheSoftmaxMeanWrittenOut) {
  const Rules rules;
  const LevelOf level(10, rules);  // 6 km an interval
  const std::vector<Point> places = {{0, 0}, {7e3, 0}, {0, 13e3}};
  const std::vector<double> values = {2, 5, 11};
  const double expected = (2 * std::exp(-1) + 5 * std::exp(-2) + 11 * std::exp(-3)) /
                          (std::exp(-1) + std::exp(-2) + std::exp(-3));
  Queries from({{0, 0}, {0, 1e8}});
  const std::vector<double> means = PlaceSums(places, values, {}).SoftmaxMeans(&from, level);
  EXPECT_NEAR(means[0], expected, 1e-12);
  // All very far away: the nearest decide.
  EXPECT_NEAR(means[1], 11, 2);
  EXPECT_EQ(PlaceSums({}, {}, {}).SoftmaxMeans(&from, level)[0], 0);
}

TEST(LevelSums, CountsEveryAgentsIntervals) {
  const LevelOf level(10, Rules{});
  Queries to({{0, 0}});
  EXPECT_EQ(LevelSums(std::vector<Point>{{0, 0}, {6e3, 0}, {6001, 0}}, level, {}).Sums(&to)[0], 4);
}

TEST(PlaceSums, OfManyPlacesAreThoseTheyWere) {
  const PlacesCase cases[] = {
      {Spread::kEven, 700, 300, 100e3, 1000.0 / 60, "3473.7175949 3095758.9065"},
      {Spread::kEven, 3000, 400, 300e3, 12.5, "5533.9638437 78830009.678"},
      {Spread::kEven, 900, 200, 15e3, 10, "1873.3888355 686074.29385"},
      {Spread::kTowns, 2000, 400, 240e3, 1000.0 / 60, "5556.1977794 32030995.977"},
      {Spread::kTowns, 600, 100, 90e3, 5, "689.07549749 1438080.883"},
      {Spread::kLine, 800, 300, 200e3, 10, "3403.2463025 7223056.1455"},
      {Spread::kSpots, 1500, 200, 60e3, 500.0 / 60, "2408.601089 5675324.6074"},
      {Spread::kGrid, 600, 200, 120e3, 10, "1833.4642739 1826207.8632"},
      {Spread::kEven, 65, 33, 40e3, 10, "187.6748765 12149.456025"},
      {Spread::kEven, 5000, 100, 1000e3, 1000.0 / 60, "703.58744485 41689119.784"},
      {Spread::kTowns, 4000, 64, 600e3, 40, "398.35408631 5083080.3525"},
      {Spread::kSpots, 300, 50, 20e3, 30, "632.14245359 46170.39"},
  };
  std::uint64_t seed = 0;
  for (const PlacesCase& c : cases) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed++, Stream::kTest);
    const LevelOf level(c.speed_m_s, Rules{});
    const std::vector<Point> places = Places(&random, c.spread, c.places, c.side_m);
    std::vector<double> values;
    for (std::size_t i = 0; i < places.size(); ++i) {
      values.push_back(i % 5 == 0 ? 3 : 2 + 6 * random.Uniform());
    }
    std::vector<Point> at = Places(&random, c.spread, c.queries, c.side_m);
    at.push_back({3 * c.side_m, -c.side_m});  // from afar
    if (c.spread == Spread::kSpots) at.insert(at.end(), 40, at.front());
    Queries queries(at);
    const std::vector<double> means =
        PlaceSums(places, values, {}, 64).SoftmaxMeans(&queries, level);
    const std::vector<double> sums = LevelSums(places, level, {}, 64).Sums(&queries);
    const std::vector<double> exact_means =
        PlaceSums(places, values, {}, kEveryOneExact).SoftmaxMeans(&queries, level);
    const std::vector<double> exact_sums =
        LevelSums(places, level, {}, kEveryOneExact).Sums(&queries);
    // Where all ways are whole intervals, what is taken together counts to either side.
    const double close = c.spread == Spread::kGrid ? 0.1 : kClose;
    double sum_of_means = 0, sum_of_sums = 0, weight = 1;
    for (std::size_t i = 0; i < at.size(); ++i) {
      ASSERT_NEAR(means[i], exact_means[i], close * exact_means[i]) << i;
      ASSERT_NEAR(sums[i], exact_sums[i], close * exact_sums[i]) << i;
      sum_of_means += weight * means[i];
      sum_of_sums += weight * sums[i];
      weight += 0.01;
    }
    EXPECT_EQ(fmt::format("{:.11g} {:.11g}", sum_of_means, sum_of_sums), c.found);
    // Two threads change nothing, nor do the places' blocks, once made.
    EXPECT_EQ(PlaceSums(places, values, {}, 64).SoftmaxMeans(&queries, level, 2), means);
    EXPECT_EQ(LevelSums(places, level, {}, 64).Sums(&queries, 2), sums);
  }
}

/// By hand: 100 places at 7 km (level 2) and 50 at 13 km (level 3), all at two spots.
TEST(PlaceSums, OfTwoSpotsByHand) {
  const LevelOf level(10, Rules{});
  std::vector<Point> places(100, {7e3, 0});
  places.insert(places.end(), 50, {0, 13e3});
  std::vector<double> values(100, 4);
  values.insert(values.end(), 50, 10);
  Queries from(std::vector<Point>(20, {0, 0}));
  const double a = 100 * std::exp(-2), b = 50 * std::exp(-3);
  for (const double mean : PlaceSums(places, values, {}, 0).SoftmaxMeans(&from, level)) {
    EXPECT_NEAR(mean, (4 * a + 10 * b) / (a + b), 1e-6);
  }
  for (const double sum : LevelSums(places, level, {}, 0).Sums(&from)) EXPECT_EQ(sum, 350);
}

}  // namespace
}  // namespace muster::scheduler
