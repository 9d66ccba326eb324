#include "model/road_ways.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/random.h"
#include "model/made_up.h"

namespace muster {
namespace {

constexpr AgentKind kWorker = AgentKind::kWorker, kVehicle = AgentKind::kVehicle;
constexpr double kNoRoad = std::numeric_limits<double>::infinity();
constexpr PerKind<OpenGround> kFields = {{}, {50, 400}, {25, 300}};

/// A street of two pieces east, a one-way street back round the north, a path to the south:
///
///   3 (0, 300) <- 2 (400, 300)
///   |             ^
///   0 (0, 0) ---- 1 (400, 0) ---- 4 (600, 0)
///   .
///   5 (0, -200)
Roads Village() {
  Roads roads;
  roads.classes = {{"street", {0, 100, 100}, false},
                   {"one-way street", {0, 100, 50}, true},
                   {"path", {0, 80, 0}, false}};
  roads.points = {{0, 0},       {400'000, 0}, {400'000, 300'000},
                  {0, 300'000}, {600'000, 0}, {0, -200'000}};
  roads.roads = {{10, 0, {0, 1}}, {11, 0, {1, 4}}, {12, 1, {1, 2, 3, 0}}, {13, 2, {5, 0}}};
  return roads;
}

TEST(RoadWays, LengthsOfAVillageByHand) {
  const RoadWays ways(std::make_shared<const Roads>(Village()), kFields, {});
  EXPECT_EQ(ways.Length(AgentKind::kUav, {0, 0}, {300, 400}), 500);
  EXPECT_EQ(ways.Length(kVehicle, {0, 0}, {600, 0}), 600);
  // From the one-way street, at half speed: 100 m of it to the corner, 400 and 300 m more.
  EXPECT_EQ(ways.Length(kVehicle, {400, 200}, {0, 0}), 2 * 800);
  // Into it the vehicle has to come from its beginning; people walk it both ways.
  EXPECT_EQ(ways.Length(kVehicle, {0, 0}, {0, 100}), 400 + 2 * (300 + 400 + 200));
  EXPECT_EQ(ways.Length(kWorker, {0, 0}, {0, 100}), 100);
  // The path is not for vehicles, and too far from the street for one that crosses open ground.
  EXPECT_EQ(ways.Length(kWorker, {0, -200}, {0, 0}), 250);
  EXPECT_EQ(ways.Length(kVehicle, {0, -200}, {0, 0}), 800);
  EXPECT_EQ(ways.Length(kVehicle, {0, -400}, {0, 0}), kNoRoad);
  // 40 m to the street at half and quarter speed, 100 m along it, 20 m from it.
  EXPECT_EQ(ways.Length(kWorker, {100, -40}, {200, 20}), 80 + 100 + 40);
  EXPECT_EQ(ways.Length(kVehicle, {100, -40}, {200, 20}), 160 + 100 + 80);
  EXPECT_EQ(ways.GroundLength(kVehicle, {100, -40}, {200, 20}), 160);
  EXPECT_EQ(ways.GroundLength(kVehicle, {400, 200}, {0, 0}), 800);
  // Beside one and the same place of the road it goes straight.
  EXPECT_EQ(ways.Length(kWorker, {100, -40}, {100, 20}), 120);
  EXPECT_EQ(ways.Length(kWorker, {100, -40}, {100, -40}), 0);
  EXPECT_EQ(ways.ToRoad(kWorker, {100, -40}), 40);
  EXPECT_EQ(ways.ToRoad(kWorker, {400, -401}), std::nullopt);
}

TEST(RoadWays, TheEndsOfTwoRoadsAtOneJunctionAreOnePlace) {
  // Both places are nearest to the junction. By rounding one is nearer to the first road's end, the
  // other to the second's beginning.
  Roads roads;
  roads.classes = {{"street", {0, 100, 100}, false}};
  roads.points = {{1'541'432, 9'937'964}, {4'055'761, 10'227'253}, {4'279'182, 14'053'740}};
  roads.roads = {{10, 0, {0, 1}}, {11, 0, {1, 2}}};
  constexpr PerKind<OpenGround> kOpen = {{}, {50, 5000}, {50, 5000}};
  const RoadWays ways(std::make_shared<const Roads>(roads), kOpen, {});
  const Point from{6249, 8237}, to{5019.004, 7657.31};
  const double straight_m = std::sqrt(1229.996 * 1229.996 + 579.69 * 579.69);
  EXPECT_NEAR(ways.Length(kVehicle, from, to), 2 * straight_m, 0.01);
  EXPECT_TRUE(ways.Corners(kVehicle, from, to).empty());
}

TEST(RoadWays, OfTwoEqualWaysItLeavesItsRoadByTheLastPoint) {
  // Round a block, from the middle of one side to the middle of the side across.
  Roads roads;
  roads.classes = {{"street", {0, 100, 100}, false}};
  roads.points = {{0, 0}, {200'000, 0}, {200'000, 100'000}, {0, 100'000}};
  roads.roads = {{1, 0, {0, 1}}, {2, 0, {1, 2}}, {3, 0, {2, 3}}, {4, 0, {3, 0}}};
  const RoadWays ways(std::make_shared<const Roads>(roads), kFields, {});
  EXPECT_EQ(ways.Length(kVehicle, {100, 0}, {100, 100}), 300);
  const auto corners = ways.Corners(kVehicle, {100, 0}, {100, 100});
  ASSERT_EQ(corners.size(), 2U);
  EXPECT_EQ(corners[0].at, (Point{200, 0}));
  EXPECT_EQ(corners[1].at, (Point{200, 100}));
}

TEST(RoadWays, AWayThatCostsMoreThanCanBeCountedIsNone) {
  // Three pieces of 10 km at a hundredth of the speed.
  Roads roads;
  roads.classes = {{"bog", {0, 1, 1}, false}};
  roads.points = {{0, 0}, {10'000'000, 0}, {20'000'000, 0}, {30'000'000, 0}};
  roads.roads = {{1, 0, {0, 1}}, {2, 0, {1, 2}}, {3, 0, {2, 3}}};
  const RoadWays ways(std::make_shared<const Roads>(roads), kFields, {});
  EXPECT_EQ(ways.Length(kVehicle, {0, 0}, {20'000, 0}), 2e6);
  EXPECT_EQ(ways.Length(kVehicle, {0, 0}, {21'474, 0}), 2'147'400);
  EXPECT_EQ(ways.Corners(kVehicle, {0, 0}, {21'474, 0}).size(), 2U);
  EXPECT_EQ(ways.Length(kVehicle, {0, 0}, {21'475, 0}), kNoRoad);
  EXPECT_TRUE(ways.Corners(kVehicle, {0, 0}, {21'475, 0}).empty());
}

TEST(RoadWays, PlacesAndCornersOfAVillageByHand) {
  const RoadWays ways(std::make_shared<const Roads>(Village()), kFields, {});
  EXPECT_EQ(ways.Corners(kVehicle, {400, 200}, {0, 0}),
            (std::vector<Ways::Corner>{{{400, 300}, 0.125}, {{0, 300}, 0.625}}));
  EXPECT_EQ(ways.PlaceAfter(kVehicle, {400, 200}, {0, 0}, 0.5), (Point{100, 300}));
  EXPECT_EQ(ways.Corners(kWorker, {100, -40}, {200, 20}),
            (std::vector<Ways::Corner>{{{100, 0}, 80.0 / 220}, {{200, 0}, 180.0 / 220}}));
  const auto at = [&](double metres) {
    return ways.PlaceAfter(kWorker, {100, -40}, {200, 20}, metres / 220);
  };
  EXPECT_EQ(at(0), (Point{100, -40}));
  EXPECT_NEAR(at(20).y_m, -30, 1e-9);  // open ground, at half speed
  EXPECT_NEAR(at(130).x_m, 150, 1e-9);
  EXPECT_NEAR(at(200).y_m, 10, 1e-9);
  EXPECT_EQ(at(220), (Point{200, 20}));
}

TEST(RoadWays, MovesEndAtStops) {
  const RoadWays ways(std::make_shared<const Roads>(Village()), kFields, {{150, -30}, {0, -900}});
  const Ways::Stop site = ways.StopNear(kWorker, {140, -20});
  EXPECT_EQ(site.at, (Point{150, -30}));
  EXPECT_EQ(site.number, 0);
  const Ways::Stop end = ways.StopNear(kWorker, {0, -950});  // the site beyond has no road near it
  EXPECT_EQ(end.at, (Point{0, -200}));
  EXPECT_EQ(end.number, 2 + 5);
  EXPECT_EQ(ways.StopNear(kVehicle, {0, -950}).at, (Point{150, -30}));  // nor is that for vehicles
  EXPECT_EQ(ways.NumberedStop(kWorker, 7), (Point{0, -200}));
  EXPECT_EQ(ways.NumberedStop(kVehicle, 7), std::nullopt);
  EXPECT_EQ(ways.NumberedStop(kWorker, 1), std::nullopt);
  EXPECT_EQ(ways.NumberedStop(kWorker, -1), std::nullopt);
  EXPECT_EQ(ways.NumberedStop(AgentKind::kUav, 2), std::nullopt);
  // Half of the way lies 100 m beyond the corner; a hundredth lies before the first.
  EXPECT_EQ(ways.StopBefore(kVehicle, {400, 200}, {0, 0}, 0.5), (Point{400, 300}));
  EXPECT_EQ(ways.StopBefore(kVehicle, {400, 200}, {0, 0}, 0.01), (Point{400, 200}));
}

/// All lengths between all road points by the definition alone, for people or vehicles.
std::vector<std::vector<double>> AllLengths(const Roads& roads, AgentKind kind) {
  const std::size_t n = roads.points.size();
  std::vector<std::vector<double>> mm(n, std::vector<double>(n, kNoRoad));
  for (std::size_t i = 0; i < n; ++i) mm[i][i] = 0;
  for (const Road& road : roads.roads) {
    const RoadClass& its = roads.classes[static_cast<std::size_t>(road.road_class)];
    if (its.percent[kind] == 0) continue;
    for (std::size_t i = 1; i < road.points.size(); ++i) {
      const auto a = static_cast<std::size_t>(road.points[i - 1]);
      const auto b = static_cast<std::size_t>(road.points[i]);
      const double plain =
          std::ceil(std::hypot(double(roads.points[a].x_mm) - roads.points[b].x_mm,
                               double(roads.points[a].y_mm) - roads.points[b].y_mm));
      const double cost = std::ceil(plain * 100 / its.percent[kind]);
      mm[a][b] = std::min(mm[a][b], cost);
      if (kind == kWorker || !its.one_way) mm[b][a] = std::min(mm[b][a], cost);
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) mm[i][j] = std::min(mm[i][j], mm[i][k] + mm[k][j]);
    }
  }
  return mm;
}

TEST(RoadWays, OfTwoStopsThatAreEquallyNearTheLowerNumberCounts) {
  for (const bool swapped : {false, true}) {
    std::vector<Point> sites{{152, -30}, {148, -30}};
    if (swapped) std::swap(sites[0], sites[1]);
    const RoadWays ways(std::make_shared<const Roads>(Village()), kFields, sites);
    EXPECT_EQ(ways.StopNear(kWorker, {150, -30}).number, 0);
    EXPECT_EQ(ways.StopNear(kWorker, {150, -30}).at, sites[0]);
  }
}

TEST(RoadWays, OnStreetGridsLengthsAreThoseOfThePlainDefinition) {
  std::size_t ways_found = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Roads roads = StreetGrid(4, 300, seed);
    const RoadWays ways(std::make_shared<const Roads>(roads), kFields, {});
    for (const AgentKind kind : {kWorker, kVehicle}) {
      const auto mm = AllLengths(roads, kind);
      for (std::size_t i = 0; i < mm.size(); ++i) {
        for (std::size_t j = 0; j < mm.size(); ++j) {
          const Point from{roads.points[i].x_mm / 1000.0, roads.points[i].y_mm / 1000.0};
          const Point to{roads.points[j].x_mm / 1000.0, roads.points[j].y_mm / 1000.0};
          if (ways.StopNear(kind, from).at != from || ways.StopNear(kind, to).at != to) continue;
          ASSERT_DOUBLE_EQ(ways.Length(kind, from, to), mm[i][j] / 1000) << i << " to " << j;
          ways_found += i != j && mm[i][j] < kNoRoad;
        }
      }
    }
  }
  EXPECT_GT(ways_found, 5000u);
}

/// What callers of Ways may rely on, for any places.
TEST(RoadWays, OnStreetGridsWaysAreSound) {
  std::size_t ways_found = 0, none = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto roads = std::make_shared<const Roads>(StreetGrid(6, 300, seed));
    const RoadWays ways(roads, kFields, {}), asked_otherwise(roads, kFields, {});
    Random random(seed, Stream::kTest, 1);
    std::vector<Point> places;
    for (int i = 0; i < 12; ++i) {
      places.push_back({random.Uniform(-300, 2100), random.Uniform(-300, 2100)});
    }
    // On the way, too: whoever is sent elsewhere half way goes on from there.
    places.push_back(ways.PlaceAfter(kWorker, places[0], places[1], 0.37));
    places.push_back(ways.PlaceAfter(kVehicle, places[2], places[3], 0.61));
    for (const AgentKind kind : {kWorker, kVehicle}) {
      for (const Point a : places) {
        for (const Point b : places) {
          const double ab = ways.Length(kind, a, b);
          EXPECT_GE(ab, Distance(a, b));
          none += ab == kNoRoad;
          if (ab == kNoRoad) continue;
          ++ways_found;
          EXPECT_GE(ab + 1e-3, ways.GroundLength(kind, a, b));
          for (const Point c : places) {
            // Each place on a road is rounded to a whole millimetre of it.
            EXPECT_LE(ways.Length(kind, a, c), ab + ways.Length(kind, b, c) + 0.02);
          }
          // As far as it has gone, it has that much less to go.
          for (const double share : {0.0, 0.2, 0.5, 0.9, 1.0}) {
            const Point on = ways.PlaceAfter(kind, a, b, share);
            EXPECT_NEAR(ways.Length(kind, on, b), (1 - share) * ab, 0.02);
          }
          double corner_to_corner = 0;
          Point last = a;
          for (const Ways::Corner& corner : ways.Corners(kind, a, b)) {
            corner_to_corner += Distance(last, corner.at);
            EXPECT_LE(Distance(ways.PlaceAfter(kind, a, b, corner.share), corner.at), 1e-6);
            last = corner.at;
          }
          corner_to_corner += Distance(last, b);
          EXPECT_NEAR(corner_to_corner, ways.GroundLength(kind, a, b), 0.05);
        }
      }
    }
    // The order in which it is asked, and by how many threads, changes nothing.
    std::vector<double> once, again(places.size() * places.size());
    for (const Point a : places) {
      for (const Point b : places) once.push_back(ways.Length(kWorker, a, b));
    }
    const auto ask = [&](std::size_t first) {
      for (std::size_t i = first; i < again.size(); i += 2) {
        const std::size_t k = again.size() - 1 - i;
        again[k] =
            asked_otherwise.Length(kWorker, places[k / places.size()], places[k % places.size()]);
      }
    };
    std::thread other(ask, 1);
    ask(0);
    other.join();
    EXPECT_EQ(again, once);
  }
  EXPECT_GT(ways_found, 5000u);
  EXPECT_GT(none, 100u);
}

TEST(RoadWays, PeopleWalkAsFarBackAsForth) {
  const auto roads = std::make_shared<const Roads>(StreetGrid(6, 300, 3));
  const RoadWays ways(roads, kFields, {});
  Random random(3, Stream::kTest, 2);
  for (int i = 0; i < 200; ++i) {
    const Point a{random.Uniform(0, 1800), random.Uniform(0, 1800)};
    const Point b{random.Uniform(0, 1800), random.Uniform(0, 1800)};
    EXPECT_EQ(ways.Length(kWorker, a, b), ways.Length(kWorker, b, a));
  }
}

TEST(Roads, WhatIsWrittenIsRead) {
  for (const Roads& roads : {Village(), StreetGrid(5, 200, 1)}) {
    const std::string text = RoadsToJson(roads);
    EXPECT_EQ(RoadsToJson(ParseRoads(text, "a.json")), text);
  }
}

TEST(Roads, LengthsAreRoundedUp) {
  EXPECT_EQ(LengthMm({0, 0}, {3, 4}), 5);
  EXPECT_EQ(LengthMm({0, 0}, {1, 1}), 2);
  EXPECT_EQ(LengthMm({-1'000'000'000, -1'000'000'000}, {1'000'000'000, 1'000'000'000}),
            2'828'427'125);
  EXPECT_EQ(LengthMm({7, 7}, {7, 7}), 0);
}

TEST(Roads, WhatCannotBeIsNamed) {
  const std::string good = RoadsToJson(Village());
  const auto error = [&](const std::string& before, const std::string& after) {
    std::string text = good;
    const std::size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    text.replace(at, before.size(), after);
    try {
      ParseRoads(text, "v.json");
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(error("\"version\": 1", "\"version\": 2").substr(0, 15), "v.json: version");
  EXPECT_NE(error("\"points\": [0,1]", "\"points\": [0]").find("roads[0].points"),
            std::string::npos);
  EXPECT_NE(error("\"points\": [0,1]", "\"points\": [0,6]").find("in [0, 5]"), std::string::npos);
  EXPECT_NE(
      error("\"points\": [0,1]", "\"points\": [2,1]").find("point 2 of roads[2] and of roads[0]"),
      std::string::npos);
  EXPECT_NE(error("\"points\": [0,1]", "\"points\": [0,0]").find("one place"), std::string::npos);
  EXPECT_NE(error("\"class\": 2", "\"class\": 3").find("roads[3].class"), std::string::npos);
  EXPECT_NE(error("\"workers_percent\": 80", "\"workers_percent\": 101").find("in [0, 100]"),
            std::string::npos);
  EXPECT_NE(error("\"y_mm\": [0,", "\"y_mm\": [0,0,").find("as many as x_mm"), std::string::npos);
  EXPECT_NE(error("\"id\": 10", "\"idea\": 10").find("idea"), std::string::npos);
}

}  // namespace
}  // namespace muster
