#include "model/airspace.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/index.h"
#include "base/json_tree.h"
#include "base/random.h"
#include "model/air_ways.h"
#include "model/made_up.h"
#include "model/order.h"
#include "model/scenario.h"

namespace muster {
namespace {

constexpr AgentKind kUav = AgentKind::kUav;
constexpr double kNoWay = std::numeric_limits<double>::infinity();

Zone Square(double x0, double y0, double x1, double y1) {
  return {"square", {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}}};
}

Zone Parsed(const std::string& json) {
  const JsonValue tree = ParseJson(json, "zones");
  return ReadZone(ObjectReader(tree, "", "zones"));
}

/// By the definition: metres to the nearest edge, 0 inside.
double Away(const Zone& zone, Point place) {
  if (IsInside(zone, place)) return 0;
  double least_m = kNoWay;
  for (const auto& ring : zone.rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point a = ring[i], b = ring[(i + 1) % ring.size()];
      const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
      const double share = std::clamp(
          ((place.x_m - a.x_m) * dx + (place.y_m - a.y_m) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
      least_m = std::min(least_m, Distance(place, Lerp(a, b, share)));
    }
  }
  return least_m;
}

TEST(Airspace, AroundASquareByHand) {
  const Airspace air({Square(100, 100, 200, 200)}, 10, {});
  // The octagon around a corner of the square has corners 10 m and 10 tan 22.5 degrees away.
  const double t = 10 * std::tan(std::acos(-1) / 8);
  const double expected = 2 * std::hypot(100 - t, 60) + 100 + 2 * t;
  EXPECT_NEAR(air.Length({0, 150}, {300, 150}), expected, 1e-9);
  EXPECT_EQ(air.Length({0, 150}, {89, 150}), 89);
  EXPECT_EQ(air.Length({0, 0}, {300, 0}), 300);
  EXPECT_EQ(air.Length({0, 90}, {300, 90}), 300);  // along the margin
  EXPECT_EQ(air.Length({0, 150}, {150, 150}), kNoWay);
  EXPECT_EQ(air.Length({0, 150}, {95, 150}), kNoWay);  // in the margin
  EXPECT_EQ(air.Length({150, 150}, {150, 150}), 0);
  const auto flight = air.FlightBetween({0, 150}, {300, 150});
  ASSERT_EQ(flight->corners.size(), 4U);
  EXPECT_NEAR(flight->corners[1].x_m, 100 - t, 1e-9);
  EXPECT_EQ(flight->reached_m.back(), air.Length({0, 150}, {300, 150}));
}

TEST(Airspace, WhoIsInsideLeavesByTheNearestEdge) {
  const Airspace air({Square(100, 100, 200, 200)}, 10, {});
  EXPECT_NEAR(air.Length({130, 150}, {0, 150}), 130, 1e-9);
  EXPECT_NEAR(air.Length({150, 190}, {150, 400}), 210, 1e-9);
  EXPECT_NEAR(air.Length({92, 150}, {0, 150}), 92, 1e-9);  // from the margin
  const auto flight = air.FlightBetween({130, 150}, {130, 400});
  EXPECT_NEAR(flight->corners[1].x_m, 90, 1e-9);
  EXPECT_NEAR(flight->corners[1].y_m, 150, 1e-9);
}

/// The edge of another zone, led on, is 3 mm inside the edge: as near to it as passes for free.
TEST(Airspace, WhoIsInsideLeavesByAnEdgeAndNotByTheLineOfAnother) {
  const Airspace alone({Square(100, 100, 200, 200)}, 10, {});
  const Airspace both({Square(100, 100, 200, 200), Square(100.003, 700, 200, 800)}, 10, {});
  for (const Point to : {Point{0, 150}, Point{130, 400}, Point{300, 150}, Point{90, 240}}) {
    EXPECT_NEAR(both.Length({92, 150}, to), alone.Length({92, 150}, to), 1e-9);
  }
}

TEST(Airspace, OfEquallyLongFlightsTheOneFurtherSouthOrWestIsFlown) {
  const Airspace air({Square(100, 100, 200, 200)}, 10, {});
  const auto around = air.FlightBetween({0, 150}, {300, 150});
  ASSERT_EQ(around->corners.size(), 4u);
  for (std::size_t i = 1; i <= 2; ++i) EXPECT_LT(around->corners[i].y_m, 100) << "south of it";
  EXPECT_EQ(air.FlightBetween({300, 150}, {0, 150})->corners[1], around->corners[2]);
  const auto up = air.FlightBetween({150, 0}, {150, 300});
  EXPECT_LT(up->corners[1].x_m, 100) << "west of it";
  // From the middle all four sides are equally near; from the corner's diagonal two are.
  EXPECT_NEAR(air.FlightBetween({150, 150}, {0, 150})->corners[1].x_m, 90, 1e-9);
  const Point out = air.FlightBetween({190, 190}, {300, 300})->corners[1];
  EXPECT_NEAR(out.x_m, 190, 1e-9);
  EXPECT_NEAR(out.y_m, 210, 1e-9);
}

TEST(Airspace, TheNearestFreePlaceCanBeANotchBetweenZones) {
  // Two squares that overlap: the notch at (200, 100), 10 m out, is nearer than any edge.
  const Airspace air({Square(0, 0, 200, 200), Square(100, 100, 300, 300)}, 10, {});
  const auto flight = air.FlightBetween({199, 101}, {400, 0});
  EXPECT_NEAR(flight->corners[1].x_m, 210, 1e-9);
  EXPECT_NEAR(flight->corners[1].y_m, 90, 1e-9);
}

/// On the way out of a zone the rest is what is left: the nearest free place stays the nearest.
TEST(Airspace, OnTheWayOutOfDrawnZonesTheRestIsWhatIsLeft) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Random random(seed, Stream::kTest, 3);
    const std::vector<Zone> zones = DrawnZones(&random, 1500, 4);
    const Airspace air(zones, 40, {});
    const auto place = [&] { return Point{random.Uniform(0, 1500), random.Uniform(0, 1500)}; };
    for (int i = 0; i < 60; ++i) {
      const Point from = place(), to = place();
      if (air.IsFree(from) || std::isinf(air.Length(from, to))) continue;
      const Point out = air.FlightBetween(from, to)->corners[1];
      EXPECT_TRUE(air.IsFree(out));
      for (int k = 0; k < 20; ++k) {
        const Point other{from.x_m + random.Uniform(-300, 300),
                          from.y_m + random.Uniform(-300, 300)};
        if (!air.IsFree(other)) continue;
        EXPECT_LE(Distance(from, out), Distance(from, other) + 0.01);
      }
      const Point half = Lerp(from, out, 0.5);
      EXPECT_NEAR(air.Length(half, to) + Distance(from, half), air.Length(from, to), 0.02);
    }
  }
}

/// Agents that get a new command are asked for their way from where they are, in whole millimetres:
/// beside a zone that is a little inside of its margin.
TEST(Airspace, FromAPlaceOnTheWayTheRestIsWhatIsLeft) {
  int n_beside = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Random random(seed, Stream::kTest, 5);
    const Airspace air(DrawnZones(&random, 4000, 6), random.Uniform(5, 60), {4000, 4000});
    const auto place = [&] { return Point{random.Uniform(0, 4000), random.Uniform(0, 4000)}; };
    for (int i = 0; i < 40; ++i) {
      const Point from = place(), to = place();
      const auto flight = air.FlightBetween(from, to);
      if (flight == nullptr || !air.IsFree(from)) continue;
      for (std::size_t k = 1; k < flight->corners.size(); ++k) {
        for (const double share : {0.3, 0.9, 0.99, 0.999}) {
          const Point on = Lerp(flight->corners[k - 1], flight->corners[k], share);
          const Point rounded{std::round(on.x_m * 1000) / 1000, std::round(on.y_m * 1000) / 1000};
          const double gone_m = std::lerp(flight->reached_m[k - 1], flight->reached_m[k], share);
          EXPECT_NEAR(air.Length(rounded, to), flight->reached_m.back() - gone_m, 0.01);
          n_beside += k > 1 ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(n_beside, 1000);
}

TEST(Airspace, ANotchBesideACornerIsLeftStraightOn) {
  // The margins of both zones meet 5 cm beside a corner of the second's: a place 4 mm inside of
  // another piece is no way out.
  const Zone north{
      "north",
      {{{4459.815, 5265.674}, {3820.937, 5864.731}, {3182.059, 5265.674}, {3820.937, 4795.416}}}};
  const Zone south{"south",
                   {{{4887.848, 4325.016},
                     {4002.799, 4781.333},
                     {3165.094, 5319.649},
                     {2720.391, 4325.016},
                     {3165.094, 3330.383},
                     {4410.335, 3162.829}}}};
  double before_m = 0;
  for (const double margin_m : {73.0, 74.0, 75.0}) {
    const Airspace air({north, south}, margin_m, {18000, 9000});
    const double length_m = air.Length({3509, 4639}, {4000, 1900});
    if (before_m > 0) {
      EXPECT_NEAR(length_m, before_m, 5) << margin_m;
    }
    before_m = length_m;
  }
  EXPECT_NEAR(before_m, 4268, 1);
}

TEST(Airspace, FlightsStayInTheArea) {
  // Around the southern end is shorter, but outside.
  const Airspace air({Square(100, 0, 200, 200)}, 10, {300, 300});
  EXPECT_EQ(air.Length({0, 20}, {300, 20}), air.Length({300, 20}, {0, 20}));
  EXPECT_GT(air.FlightBetween({0, 20}, {300, 20})->corners[1].y_m, 200);
  EXPECT_EQ(Airspace({Square(100, 0, 200, 300)}, 10, {300, 300}).Length({0, 20}, {300, 20}),
            kNoWay);
}

TEST(Airspace, HolesAreFreeAndCourtyardsCannotBeEntered) {
  Zone ring = Square(0, 0, 1000, 1000);
  ring.rings.push_back(Square(300, 300, 700, 700).rings[0]);
  const Airspace air({ring}, 20, {});
  EXPECT_EQ(air.Length({350, 350}, {650, 650}), Distance({350, 350}, {650, 650}));
  EXPECT_EQ(air.Length({-100, 500}, {500, 500}), kNoWay);
  EXPECT_FALSE(air.IsFree({150, 500}));
  EXPECT_TRUE(air.IsFree({500, 500}));
}

TEST(Airspace, EntersWhereANewZoneBegins) {
  const Airspace before({}, 10, {}), now({Square(100, 100, 200, 200)}, 10, {});
  const auto flight = before.FlightBetween({0, 150}, {300, 150});
  EXPECT_NEAR(*now.EntersAt(*flight, 0), 90, 0.01);
  EXPECT_NEAR(*now.EntersAt(*flight, 50), 90, 0.01);
  EXPECT_NEAR(*now.EntersAt(*flight, 120), 120, 1e-9);  // within it already
  EXPECT_EQ(now.EntersAt(*flight, 220), std::nullopt);
  EXPECT_EQ(now.EntersAt(*now.FlightBetween({0, 150}, {300, 150}), 0), std::nullopt);
}

TEST(Airspace, DrawnZonesAreKeptOutOfByTheMargin) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Random random(seed, Stream::kTest);
    const double margin_m = random.Uniform(5, 60);
    const std::vector<Zone> zones = DrawnZones(&random, 4000, 1 + static_cast<int>(seed % 6));
    const Airspace air(zones, margin_m, {4000, 4000});
    const auto place = [&] { return Point{random.Uniform(0, 4000), random.Uniform(0, 4000)}; };
    for (int i = 0; i < 60; ++i) {
      const Point from = place(), to = place(), by = place();
      if (!air.IsFree(from)) continue;
      for (const Zone& zone : zones) EXPECT_GT(Away(zone, from), margin_m - 0.02);
      const double length_m = air.Length(from, to);
      EXPECT_GE(length_m, Distance(from, to));
      if (!air.IsFree(to) || std::isinf(length_m)) continue;
      EXPECT_NEAR(air.Length(to, from), length_m, 1e-6);
      EXPECT_LE(length_m, air.Length(from, by) + air.Length(by, to) + 1e-6);
      const auto flight = air.FlightBetween(from, to);
      double sum_m = 0;
      for (std::size_t k = 1; k < flight->corners.size(); ++k) {
        const Point a = flight->corners[k - 1], b = flight->corners[k];
        sum_m += Distance(a, b);
        EXPECT_NEAR(flight->reached_m[k], sum_m, 1e-6);
        for (const double share : {0.0, 0.2, 0.4, 0.6, 0.8}) {
          for (const Zone& zone : zones) {
            EXPECT_GT(Away(zone, Lerp(a, b, share)), margin_m - 0.02);
          }
        }
        // From a corner on, what is left is as long as it was to be.
        EXPECT_NEAR(air.Length(b, to), length_m - flight->reached_m[k], 1e-6);
      }
    }
  }
}

/// By the definition: from the first place to the second, by any of the others.
double ShortestByCorners(const Airspace& air, const std::vector<Point>& places) {
  std::vector<double> metres(places.size(), kNoWay);
  std::vector<bool> is_final(places.size());
  metres[0] = 0;
  for (;;) {
    std::size_t least = places.size();
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!is_final[i] && metres[i] < (least < places.size() ? metres[least] : kNoWay)) least = i;
    }
    if (least == places.size() || least == 1) return metres[1];
    is_final[least] = true;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double straight_m = Distance(places[least], places[i]);
      if (metres[least] + straight_m >= metres[i]) continue;
      if (air.Length(places[least], places[i]) == straight_m)
        metres[i] = metres[least] + straight_m;
    }
  }
}

/// The corners of the octagons around the corners of zones, those that are free.
std::vector<Point> FreeCorners(const std::vector<Zone>& zones, double margin_m, const Airspace& air,
                               const Airspace::Extent& extent) {
  const double t = margin_m * (std::sqrt(2.0) - 1);
  std::vector<Point> corners;
  for (const Zone& zone : zones) {
    for (const auto& ring : zone.rings) {
      for (const Point at : ring) {
        for (int k = 0; k < 8; ++k) {
          const double x = k % 4 < 2 ? margin_m : t, y = k % 4 < 2 ? t : margin_m;
          const Point corner{at.x_m + (k % 2 == 0 ? x : -x), at.y_m + (k < 4 ? y : -y)};
          if (extent.Contains(corner) && air.IsFree(corner)) corners.push_back(corner);
        }
      }
    }
  }
  return corners;
}

TEST(Airspace, NoWayByAnyCornerIsShorter) {
  constexpr double kMargin_m = 40;
  constexpr Airspace::Extent kArea{2000, 2000};
  int n_bent = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Random random(seed, Stream::kTest, 4);
    std::vector<Zone> zones = DrawnZones(&random, 2000, 3);
    // Squares beside each other, between which a flight along both margins just fits.
    if (seed % 2 == 0) {
      zones = {Square(400, 400, 800, 800), Square(880, 400, 1200, 800),
               Square(400, 880, 800, 1300)};
    }
    const Airspace air(zones, kMargin_m, kArea);
    const std::vector<Point> corners = FreeCorners(zones, kMargin_m, air, kArea);
    const auto free_place = [&] {
      for (;;) {
        const Point at{random.Uniform(0, 2000), random.Uniform(0, 2000)};
        if (air.IsFree(at)) return at;
      }
    };
    for (int i = 0; i < 12; ++i) {
      std::vector<Point> places{free_place(), free_place()};
      places.insert(places.end(), corners.begin(), corners.end());
      const double shortest_m = ShortestByCorners(air, places);
      const double length_m = air.Length(places[0], places[1]);
      n_bent += length_m > Distance(places[0], places[1]) ? 1 : 0;
      if (std::isinf(shortest_m)) {
        EXPECT_EQ(length_m, shortest_m);
      } else {
        EXPECT_NEAR(length_m, shortest_m, 1e-6);
      }
    }
  }
  EXPECT_GT(n_bent, 20);
}

/// What is kept, and how far somebody looked before, changes no bit of a length.
TEST(Airspace, LengthsDoNotDependOnWhatWasAskedBefore) {
  constexpr std::size_t kPlaces = 150;  // more than lengths are kept for at once
  constexpr Airspace::Extent kArea{20'000, 20'000};
  Random random(1, Stream::kTest, 5);
  const std::vector<Zone> zones = DrawnZones(&random, 20'000, 30);
  std::vector<Point> places;
  while (places.size() < kPlaces) {
    places.push_back({random.Uniform(0, 20'000), random.Uniform(0, 20'000)});
  }
  const Airspace one_by_one(zones, 40, kArea);
  std::vector<double> expected;  // [from * to]
  for (std::size_t i = kPlaces * kPlaces; i-- > 0;) {
    expected.push_back(one_by_one.Length(places[i / kPlaces], places[i % kPlaces]));
  }
  std::reverse(expected.begin(), expected.end());
  const auto n_bent = std::count_if(expected.begin(), expected.end(), [&](const double& length_m) {
    const auto i = static_cast<std::size_t>(&length_m - expected.data());
    return length_m > Distance(places[i / kPlaces], places[i % kPlaces]);
  });
  EXPECT_GT(n_bent, 1000);

  std::vector<double> lengths_m(expected.size());
  const Airspace at_once(zones, 40, kArea);
  at_once.Lengths(places, places, lengths_m);
  EXPECT_EQ(lengths_m, expected);

  // The nearest first, by two threads.
  const Airspace nearest_first(zones, 40, kArea);
  const Airspace::Goals goals(nearest_first, places);
  const auto ask = [&](std::vector<double>* into) {
    for (std::size_t i = 0; i < kPlaces; ++i) {
      std::vector<std::int32_t> which(kPlaces);
      std::iota(which.begin(), which.end(), 0);
      std::sort(which.begin(), which.end(), [&](std::int32_t a, std::int32_t b) {
        return Distance(places[i], places[At(a)]) < Distance(places[i], places[At(b)]);
      });
      std::vector<double> found_m(kPlaces);
      goals.LengthsFrom(places[i], which, found_m);
      for (std::size_t k = 0; k < kPlaces; ++k) (*into)[i * kPlaces + At(which[k])] = found_m[k];
    }
  };
  std::vector<double> others_m(expected.size());
  std::thread other([&] { ask(&others_m); });
  ask(&lengths_m);
  other.join();
  EXPECT_EQ(lengths_m, expected);
  EXPECT_EQ(others_m, expected);
}

TEST(AirWays, AreStraightWithoutZonesAndHaveRulesAllTheSame) {
  constexpr Airspace::Extent kArea{3000, 2000};
  const auto ways = [&](std::vector<Zone> zones) {
    return AirWays(DefaultWays(), std::make_shared<const LazyAirspace>(std::move(zones), 10, kArea),
                   kArea);
  };
  const AirWays empty = ways({}), closed = ways({Square(900, 900, 1300, 1300)});
  EXPECT_TRUE(empty.straight(kUav));
  EXPECT_TRUE(empty.ruled(kUav));
  EXPECT_FALSE(closed.straight(kUav));
  EXPECT_FALSE(empty.ruled(AgentKind::kWorker));
  EXPECT_FALSE(StraightWays().ruled(kUav));
  EXPECT_EQ(empty.StopNear(kUav, {140, 160}).at, (Point{100, 200}));
  EXPECT_EQ(empty.NumberedStop(kUav, 2 * 31 + 1), (Point{100, 200}));
  EXPECT_EQ(empty.StopBefore(kUav, {0, 0}, {1000, 0}, 0.55), (Point{500, 0}));
  // A straight way on which a zone is new.
  const auto share = empty.BarredAt(kUav, {0, 1000}, {1780, 1000}, 0, closed);
  ASSERT_TRUE(share);
  EXPECT_NEAR(*share, 0.5, 1e-4);
}

/// Wherever a move is wanted, no other free place of the grid is nearer: also where one of a nearer
/// ring is free, at its corner, in the notch of a zone.
TEST(AirWays, MovesToNoSiteEndOnTheNearestFreePlace) {
  const Airspace::Extent area{3000, 2000};
  const std::vector<Zone> zones = {
      {"notched",
       {{{750, 750}, {1500, 750}, {1500, 1170}, {1170, 1170}, {1170, 1500}, {750, 1500}}}}};
  const Airspace air(zones, 10, area);
  const AirWays ways(DefaultWays(), std::make_shared<const LazyAirspace>(zones, 10, area), area);
  EXPECT_EQ(ways.StopNear(kUav, {960, 1040}).at, (Point{700, 1000}));  // not {1200, 1200}
  for (double x_m = 720; x_m < 1530; x_m += 30) {
    for (double y_m = 720; y_m < 1530; y_m += 30) {
      double nearest_m = 3000;
      for (std::int32_t number = 0; number < 31 * 21; ++number) {
        const Point at = *ways.NumberedStop(kUav, number);
        if (air.IsFree(at)) nearest_m = std::min(nearest_m, Distance({x_m, y_m}, at));
      }
      const Point stop = ways.StopNear(kUav, {x_m, y_m}).at;
      EXPECT_NEAR(Distance({x_m, y_m}, stop), nearest_m, 1e-9) << x_m << " " << y_m;
    }
  }
}

TEST(AirWays, MovesToNoSiteEndOnAFreePlaceOfTheGrid) {
  const auto air = std::make_shared<const LazyAirspace>(
      std::vector<Zone>{Square(900, 900, 1300, 1300)}, 10, Airspace::Extent{3000, 2000});
  const AirWays ways(DefaultWays(), air, {3000, 2000});
  EXPECT_EQ(ways.StopNear(kUav, {140, 160}).at, (Point{100, 200}));
  EXPECT_EQ(ways.StopNear(kUav, {140, 160}).number, 2 * 31 + 1);
  EXPECT_EQ(ways.StopNear(kUav, {1090, 950}).at, (Point{1100, 800}));
  EXPECT_EQ(ways.StopNear(kUav, {9000, -50}).at, (Point{3000, 0}));
  EXPECT_EQ(ways.NumberedStop(kUav, 2 * 31 + 1), (Point{100, 200}));
  EXPECT_EQ(ways.NumberedStop(kUav, 31 * 21), std::nullopt);
  EXPECT_EQ(ways.NumberedStop(kUav, -1), std::nullopt);
  const Point half = ways.StopBefore(kUav, {0, 1000}, {2000, 1000}, 0.5);
  EXPECT_LE(ways.Length(kUav, {0, 1000}, half), ways.Length(kUav, {0, 1000}, {2000, 1000}) / 2);
  EXPECT_GT(ways.Length(kUav, {0, 1000}, half), 700);
  EXPECT_TRUE(ways.straight(AgentKind::kWorker));
  EXPECT_EQ(ways.Length(AgentKind::kWorker, {0, 1000}, {2000, 1000}), 2000);
}

TEST(AirOrders, AddAndLiftZonesAtTheirTick) {
  Scenario scenario;
  scenario.width_m = scenario.height_m = 3000;
  const auto take = [&](const char* json, TimeUs t, const char* id) -> std::string {
    try {
      Order order = ParseOrder(json, "order");
      order.id = id;
      TakeInto(&scenario, order, t);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  constexpr const char* kAdd =
      R"({"order": "zone_add", "area_km": [[1, 1], [2, 1], [2, 2], [1, 2]], "name": "field"})";
  EXPECT_EQ(take(kAdd, 0, "a"), "the scenario has no key air");
  UseAir({10, Separation(), {}, nullptr}, &scenario);
  const auto length = [&](TimeUs t) {
    return scenario.WaysAt(t).Length(kUav, {500, 1500}, {2500, 1500});
  };
  EXPECT_EQ(length(0), 2000);
  const TimeUs t = 20 * kMinuteUs;
  EXPECT_EQ(take(kAdd, t, "a"), "");
  EXPECT_EQ(scenario.closures[0].name, "field");
  EXPECT_EQ(length(t - 1), 2000);
  EXPECT_NEAR(length(t), 2 * std::hypot(500 - 4.142, 510) + 1008.284, 0.01);
  EXPECT_EQ(take(R"({"order": "zone_lift", "zone": "b"})", t, "c"),
            "there is no zone of an order b");
  EXPECT_EQ(take(R"({"order": "road_open", "closure": "a"})", t, "d"), "the scenario has no roads");
  EXPECT_EQ(take(R"({"order": "zone_lift", "zone": "a"})", t + kMinuteUs, "e"), "");
  EXPECT_EQ(length(t + kMinuteUs), 2000);
  EXPECT_NE(take(R"({"order": "zone_add", "circle_km": [1, 1, 0.2], "until_min": 10})", t, "f")
                .find("until_min"),
            std::string::npos);
  EXPECT_NE(take(R"({"order": "zone_lift", "zone": "a", "area_km": []})", t, "g").find("area_km"),
            std::string::npos);
}

/// A UAV that meets a new zone goes round from where it is; range falls by what it flew.
TEST(AirOrders, AUavUnderWayFliesAroundFromWhereItIs) {
  Scenario scenario;
  scenario.width_m = scenario.height_m = 3000;
  AgentSpec spec;
  spec.at = {500, 1500};
  spec.speed_m_s = 10;
  spec.range_full_m = spec.range_m = 5000;
  UseAir({10, Separation(), {}, nullptr}, &scenario);
  AgentState uav = StartOf(kUav, 0, spec, *scenario.ways);
  uav.to = {2500, 1500};
  uav.arrive_us = 200 * kSecondUs;
  uav.action = ActionKind::kUavToTask;
  uav.busy_until_us = uav.arrive_us;
  AgentState behind = uav;
  Order order =
      ParseOrder(R"({"order": "zone_add", "area_km": [[1, 1], [2, 1], [2, 2], [1, 2]]})", "order");
  const TimeUs t = 30 * kSecondUs;
  const TakenOrder taken = TakeInto(&scenario, order, t);
  FollowWays(&uav, {&taken, 1}, t, scenario);
  EXPECT_EQ(uav.from, (Point{800, 1500}));
  EXPECT_EQ(uav.range_at_departure_m, 4700);
  // By two corners of the octagon, as it is steep, and by one of the next.
  const double way_m =
      std::hypot(190, 504.142) + std::hypot(5.858, 5.858) + 1008.284 + std::hypot(500 - 4.142, 510);
  EXPECT_NEAR(static_cast<double>(uav.arrive_us - t) * 1e-5, way_m, 0.01);
  // One that has passed it goes on.
  behind.from = behind.to = {2500, 1500};
  behind.arrive_us = t;
  FollowWays(&behind, {&taken, 1}, t, scenario);
  EXPECT_EQ(behind.to, (Point{2500, 1500}));
}

TEST(Zone, IsReadAndWrittenAlike) {
  const Zone zone =
      Parsed(R"({"area_km": [[0, 0], [1, 0], [1, 0], [1, 1.0000004], [0, 1], [0, 0]], )"
             R"("holes_km": [[[0.2, 0.2], [0.4, 0.2], [0.3, 0.4]]]})");
  ASSERT_EQ(zone.rings.size(), 2U);
  EXPECT_EQ(zone.rings[0].size(), 4U);  // what is repeated counts once
  EXPECT_EQ(zone.rings[0][2], (Point{1000, 1000}));
  EXPECT_EQ(Parsed("{" + ZoneToJson(zone) + "}").rings, zone.rings);
  EXPECT_TRUE(IsInside(zone, {500, 500}));
  EXPECT_FALSE(IsInside(zone, {300, 250}));
}

TEST(Zone, ACircleIsWithinItsCorners) {
  const Zone zone = Parsed(R"({"circle_km": [2, 3, 0.5]})");
  ASSERT_EQ(zone.rings[0].size(), 16U);
  for (std::size_t i = 0; i < 16; ++i) {
    const Point a = zone.rings[0][i], b = zone.rings[0][(i + 1) % 16];
    EXPECT_NEAR(Distance(Lerp(a, b, 0.5), {2000, 3000}), 500, 0.002);
  }
}

TEST(Zone, WhatIsNoneIsRefusedByName) {
  const std::pair<const char*, const char*> cases[] = {
      {"{}", "area_km"},
      {R"({"area_km": [[0, 0], [1, 0], [1, 1]], "circle_km": [0, 0, 1]})", "exactly one"},
      {R"({"area_km": [[0, 0], [1, 0]]})", "3 to 1000 corners"},
      {R"({"area_km": [[0, 0], [1, 0], [1, 0]]})", "2 different corners"},
      {R"({"area_km": [[0, 0], [1, 0], [1]]})", "[x_km, y_km]"},
      {R"({"circle_km": [0, 0, 0]})", "a radius of at least a metre"},
      {R"({"circle_km": [0, 0, 1], "holes_km": []})", "nothing beside circle_km"},
      {R"({"area_km": "everywhere"})", "area_km"},
  };
  for (const auto& [json, expected] : cases) {
    SCOPED_TRACE(json);
    try {
      Parsed(json);
      ADD_FAILURE() << "was taken";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace muster
