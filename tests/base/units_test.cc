#include "base/units.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/geometry.h"
#include "base/random.h"

namespace muster {
namespace {

TEST(Units, IntervalsAreCountedExactlyAtTheirBoundaries) {
  constexpr TimeUs kInterval = 10 * kMinuteUs;
  EXPECT_EQ(Intervals(0, kInterval), 1);
  EXPECT_EQ(Intervals(1, kInterval), 1);
  EXPECT_EQ(Intervals(kInterval - 1, kInterval), 1);
  EXPECT_EQ(Intervals(kInterval, kInterval), 1);
  EXPECT_EQ(Intervals(kInterval + 1, kInterval), 2);
  EXPECT_EQ(Intervals(2 * kInterval, kInterval), 2);
  EXPECT_EQ(Intervals(2 * kInterval + 1, kInterval), 3);
  EXPECT_EQ(Intervals(-5, kInterval), 1);
  EXPECT_EQ(Intervals(1'000'000, 1), 1'000'000);
}

TEST(Units, IntervalsOfNeverDoNotOverflow) {
  EXPECT_EQ(Intervals(kNever, kMinuteUs), kNever / kMinuteUs + 1);
  EXPECT_EQ(Intervals(kNever, 1), kNever);
  EXPECT_EQ(Intervals(kNever, kNever), 1);
}

TEST(Units, TravelOfAWholeIntervalTakesOneInterval) {
  // 10 km at 1 km/min and 7.5 km at 0.75 km/min both take ten minutes; a rounding error upwards
  // would cost a decision.
  EXPECT_EQ(TravelUs(10'000, 1000.0 / 60), 10 * kMinuteUs);
  EXPECT_EQ(TravelUs(7'500, 750.0 / 60), 10 * kMinuteUs);
  EXPECT_EQ(TravelUs(5'000, 500.0 / 60), 10 * kMinuteUs);
  EXPECT_EQ(Intervals(TravelUs(10'000, 1000.0 / 60), 10 * kMinuteUs), 1);
}

TEST(Units, SecondsRoundToTheNearestMicrosecond) {
  EXPECT_EQ(ToUs(1.5), 1'500'000);
  EXPECT_EQ(ToUs(0.4e-6), 0);
  EXPECT_EQ(ToUs(0.6e-6), 1);
  EXPECT_EQ(ToUs(-2), -2'000'000);
  EXPECT_EQ(ToUs(1e300), kNever);
  EXPECT_EQ(ToUs(std::numeric_limits<double>::infinity()), kNever);
  EXPECT_EQ(ToSeconds(2'500'000), 2.5);
  EXPECT_EQ(ToMinutes(90 * kSecondUs), 1.5);
}

TEST(Units, HalvesRoundAwayFromZeroAsInTheLibrary) {
  const double half = 0.5, below = std::nextafter(half, 0.0);
  for (const double x : {0.0, -0.0, half, -half, below, -below, 1.5, 2.5, -2.5, 1e15 + half, 0x1p52,
                         0x1p52 - half, 0x1p53 + 2, 9e18, -9e18}) {
    EXPECT_EQ(RoundHalfAway(x), std::llround(x)) << x;
  }
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed, Stream::kTest);
    for (int i = 0; i < 500; ++i) {
      const double x = std::exp(random.Uniform(-3, 43)) * (random.Below(2) == 0 ? 1 : -1);
      EXPECT_EQ(RoundHalfAway(x), std::llround(x)) << "seed " << seed << " " << x;
      const double tie = std::floor(x) + half;
      EXPECT_EQ(RoundHalfAway(tie), std::llround(tie)) << "seed " << seed << " " << tie;
      EXPECT_EQ(RoundHalfAway(std::nextafter(tie, 0.0)), std::llround(std::nextafter(tie, 0.0)));
    }
  }
}

TEST(Geometry, DistanceIsEuclidean) {
  EXPECT_EQ(Distance({0, 0}, {3000, 4000}), 5000);
  EXPECT_EQ(Distance({7, -2}, {7, -2}), 0);
  EXPECT_EQ(Lerp({0, 10}, {10, 30}, 0.25), (Point{2.5, 15}));
}

}  // namespace
}  // namespace muster
