#include "model/ways.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "base/random.h"
#include "model/agent.h"
#include "model/feasibility.h"
#include "model/place_index.h"
#include "tests/model/manhattan_ways.h"

namespace muster {
namespace {

using testing::InManhattan;
using testing::ManhattanWays;

TEST(Ways, StraightOnesByHand) {
  const Ways& ways = StraightWays();
  EXPECT_TRUE(ways.straight(AgentKind::kWorker));
  EXPECT_EQ(ways.Length(AgentKind::kUav, {0, 0}, {300, 400}), 500);
  EXPECT_EQ(ways.PlaceAfter(AgentKind::kUav, {0, 0}, {300, 400}, 0.5), (Point{150, 200}));
  EXPECT_EQ(ways.LengthAfter(AgentKind::kUav, {0, 0}, {300, 400}, 0.5), 250);
  EXPECT_TRUE(ways.Corners(AgentKind::kUav, {0, 0}, {300, 400}).empty());
}

TEST(Ways, BentOnesByHand) {
  const ManhattanWays ways;
  EXPECT_FALSE(ways.straight(AgentKind::kWorker));
  EXPECT_EQ(ways.Length(AgentKind::kUav, {0, 0}, {300, 400}), 700);
  EXPECT_EQ(ways.Corners(AgentKind::kUav, {0, 0}, {300, 400}),
            (std::vector<Ways::Corner>{{{300, 0}, 300.0 / 700}}));
  const auto after = [&](double share) {
    return ways.PlaceAfter(AgentKind::kUav, {0, 0}, {300, 400}, share);
  };
  EXPECT_EQ(after(0), (Point{0, 0}));
  EXPECT_EQ(after(0.25), (Point{175, 0}));
  EXPECT_LT(Distance(after(0.75), {300, 225}), 1e-9);
  EXPECT_EQ(after(1), (Point{300, 400}));
  EXPECT_EQ(ways.LengthAfter(AgentKind::kUav, {0, 0}, {300, 400}, 0.25), 175);
  EXPECT_EQ(ways.PlaceAfter(AgentKind::kUav, {5, 5}, {5, 5}, 0.5), (Point{5, 5}));
}

TEST(Ways, AnAgentGoesRoundTheCornerAndSpendsTheWholeWay) {
  const InManhattan scope;
  Scenario scenario;
  AgentSpec spec;
  spec.speed_m_s = 10;
  spec.range_full_m = spec.range_m = 5000;
  spec.online_until_us = kNever;
  AgentState uav = StartOf(AgentKind::kUav, 0, spec, *scenario.ways);
  Action go;
  go.kind = ActionKind::kGoTo;
  go.uav = UavId(0);
  go.to = {3000, 4000};
  Begin(&uav, go, 0, 0, {}, 1);
  EXPECT_EQ(uav.arrive_us, 700 * kSecondUs);
  EXPECT_EQ(PositionAt(uav, 100 * kSecondUs), (Point{1000, 0}));
  EXPECT_LT(Distance(PositionAt(uav, 500 * kSecondUs), {3000, 2000}), 1e-9);
  EXPECT_DOUBLE_EQ(RangeAt(uav, 100 * kSecondUs, {}), 4000);
  // 5,000 m of range for a way of 7,000 m: it runs dry after 500 s, beyond the corner.
  EXPECT_EQ(RunsDryAt(uav), 500 * kSecondUs);
  const ChargingPoint north{{0, 900}, 1}, corner{{600, 600}, 1};
  EXPECT_EQ(NearestChargeM(*scenario.ways, {0, 0}, std::vector{north, corner}), 900);
  EXPECT_LT(NearestChargeM(StraightWays(), {0, 0}, std::vector{north, corner}), 900);
}

TEST(PlaceIndex, FindsByTheWayWhatAPlainScanFinds) {
  const ManhattanWays manhattan;
  std::size_t within = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed, Stream::kTest);
    const WaysOf ways{seed % 2 == 0 ? &manhattan : &StraightWays(), AgentKind::kWorker};
    const auto place = [&] { return Point{random.Uniform(0, 9000), random.Uniform(0, 4000)}; };
    std::vector<Point> places(seed % 40);
    for (Point& p : places) p = place();
    const PlaceIndex index(places, ways);
    for (int query = 0; query < 10; ++query) {
      const Point from = place();
      const double radius = random.Uniform(0, 5000);
      std::vector<double> out(places.size(), -1), back(places.size(), -1);
      index.WithinFrom(from, radius, [&](std::int32_t i, double way_m) {
        out[static_cast<std::size_t>(i)] = way_m;
      });
      index.WithinTo(from, radius, [&](std::int32_t i, double way_m) {
        back[static_cast<std::size_t>(i)] = way_m;
      });
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < places.size(); ++i) {
        const double way_m = ways.Length(from, places[i]);
        nearest = std::min(nearest, way_m);
        ASSERT_EQ(out[i], way_m <= radius ? way_m : -1);
        ASSERT_EQ(back[i], out[i]);  // Manhattan ways are as long in both directions
        within += way_m <= radius;
      }
      EXPECT_EQ(index.NearestFrom(from), nearest);
    }
  }
  EXPECT_GT(within, 1000u);
}

}  // namespace
}  // namespace muster
