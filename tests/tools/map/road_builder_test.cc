#include "tools/map/road_builder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "model/road_ways.h"
#include "tests/error_of.h"

namespace muster::tools {
namespace {

const RoadClass kStreet{"street", {0, 100, 100}, false};
const RoadClass kOneWay{"one-way", {0, 100, 50}, true};
const RoadClass kPath{"path", {0, 100, 0}, false};
const RoadClass kMotorway{"motorway", {0, 0, 100}, true};

struct Line {
  std::int64_t id;
  RoadClass road_class;
  std::vector<Point> places;
};

/// In an area of 1 x 1 km, which roads leave by 1 km.
BuiltRoads Built(const std::vector<Line>& lines, double join_m = 0,
                 const std::vector<Point>& barriers = {}) {
  RoadBuilder builder(1000, 1000, join_m);
  for (const Line& line : lines) builder.AddLine(line.id, line.road_class, line.places);
  for (const Point& barrier : barriers) builder.AddBarrier(barrier);
  BuiltRoads built = builder.Build("made up", "t.osm");
  // What is built keeps the rules of a road file.
  EXPECT_EQ(RoadsToJson(ParseRoads(RoadsToJson(built.roads), "t.roads.json")),
            RoadsToJson(built.roads));
  return built;
}

/// "7 street: 0,0 100,0", in metres, a line for each road.
std::vector<std::string> RoadTexts(const BuiltRoads& built) {
  std::vector<std::string> shown;
  for (const Road& road : built.roads.roads) {
    std::string text = fmt::format(
        "{} {}:", road.id, built.roads.classes[static_cast<std::size_t>(road.road_class)].name);
    for (const std::int32_t point : road.points) {
      const RoadPoint at = built.roads.points[static_cast<std::size_t>(point)];
      text += fmt::format(" {},{}", at.x_mm / 1000.0, at.y_mm / 1000.0);
    }
    shown.push_back(text);
  }
  return shown;
}

using Texts = std::vector<std::string>;

TEST(RoadBuilder, LinesAreDividedWhereTheySharePoints) {
  const BuiltRoads built = Built({{1, kStreet, {{0, 0}, {20, 0}, {50, 0}, {90, 0}}},
                                  {2, kStreet, {{50, 40}, {50, 0}, {50, -40}}}});
  EXPECT_EQ(RoadTexts(built), (Texts{"1 street: 0,0 20,0 50,0", "1 street: 50,0 90,0",
                                     "2 street: 50,40 50,0", "2 street: 50,0 50,-40"}));
  EXPECT_EQ(built.junctions, 1U);
  EXPECT_EQ(built.length_mm, 170'000);
  // Points are numbered in the order of their first use.
  EXPECT_EQ(built.roads.roads[1].points, (std::vector<std::int32_t>{2, 3}));
}

TEST(RoadBuilder, AnEndOnTheMiddleOfAnotherLineIsAJunction) {
  const BuiltRoads built =
      Built({{1, kStreet, {{50, 40}, {50, 0}}}, {2, kStreet, {{0, 0}, {50, 0}, {90, 0}}}});
  EXPECT_EQ(RoadTexts(built),
            (Texts{"1 street: 50,40 50,0", "2 street: 0,0 50,0", "2 street: 50,0 90,0"}));
  EXPECT_EQ(built.junctions, 1U);
}

TEST(RoadBuilder, WhatCrossesWithoutASharedPointDoesNotMeet) {
  const BuiltRoads built = Built({{1, kStreet, {{0, 0}, {90, 0}}},
                                  {2, kPath, {{50, -40}, {50, 40}}},
                                  {3, kPath, {{90, 0}, {50, 40}}}});
  EXPECT_EQ(RoadTexts(built), (Texts{"1 street: 0,0 90,0", "2 path: 50,-40 50,40 90,0"}));
}

TEST(RoadBuilder, ALineThatMeetsItselfIsDividedThere) {
  const BuiltRoads built =
      Built({{1, kStreet, {{0, 0}, {50, 0}, {90, 0}, {90, 50}, {50, 0}, {50, -50}}}});
  EXPECT_EQ(RoadTexts(built), (Texts{"1 street: 0,0 50,0", "1 street: 50,0 90,0 90,50 50,0",
                                     "1 street: 50,0 50,-50"}));
  EXPECT_EQ(built.junctions, 1U);
}

TEST(RoadBuilder, RoadsOfOneClassThatOnlyMeetEachOtherBecomeOne) {
  // The first gives its direction and its id. The last is of another class.
  const BuiltRoads built = Built({{5, kStreet, {{10, 0}, {20, 5}, {30, 0}}},
                                  {6, kStreet, {{40, 0}, {30, 0}}},
                                  {7, kStreet, {{0, 0}, {10, 0}}},
                                  {8, kPath, {{40, 0}, {50, 0}}}});
  EXPECT_EQ(RoadTexts(built), (Texts{"5 street: 0,0 10,0 20,5 30,0 40,0", "8 path: 40,0 50,0"}));
}

TEST(RoadBuilder, AOneWayRingBecomesOneRoad) {
  const BuiltRoads built =
      Built({{1, kOneWay, {{0, 0}, {50, 0}, {50, 50}}}, {2, kOneWay, {{50, 50}, {0, 50}, {0, 0}}}});
  EXPECT_EQ(RoadTexts(built), (Texts{"1 one-way: 0,0 50,0 50,50 0,50 0,0"}));
}

TEST(RoadBuilder, OneWayRoadsThatLeadToADeadEndAreNotForVehicles) {
  // Both of the one-way roads end at 50,50: vehicles would not come back.
  const BuiltRoads built = Built({{1, kStreet, {{0, 0}, {90, 0}}},
                                  {2, kOneWay, {{0, 0}, {50, 50}}},
                                  {3, kOneWay, {{90, 0}, {50, 50}}}});
  EXPECT_EQ(RoadTexts(built),
            (Texts{"1 street: 0,0 90,0", "2 one-way, cut off for vehicles: 0,0 50,50 90,0"}));
  EXPECT_EQ(built.roads.classes[1].percent.vehicles, 0);
  EXPECT_EQ(built.roads.classes[1].percent.workers, 100);
  // One that leads on is for both.
  const BuiltRoads through = Built({{1, kStreet, {{0, 0}, {90, 0}}},
                                    {2, kOneWay, {{0, 0}, {50, 50}}},
                                    {3, kOneWay, {{50, 50}, {90, 0}}}});
  EXPECT_EQ(RoadTexts(through), (Texts{"1 street: 0,0 90,0", "2 one-way: 0,0 50,50 90,0"}));
}

TEST(RoadBuilder, TheLargestPartOfEachClassIsKept) {
  // A path joins two streets: people reach both, vehicles only the longer one. Nobody reaches the
  // third, and from the motorway no way leads back.
  const BuiltRoads built = Built({{1, kStreet, {{0, 0}, {20, 0}}},
                                  {2, kPath, {{20, 0}, {40, 0}}},
                                  {3, kStreet, {{40, 0}, {90, 0}}},
                                  {4, kStreet, {{0, 500}, {15, 500}}},
                                  {5, kMotorway, {{90, 0}, {90, 90}}}});
  EXPECT_EQ(RoadTexts(built), (Texts{"1 street, cut off for vehicles: 0,0 20,0",
                                     "2 path: 20,0 40,0", "3 street: 40,0 90,0"}));
  EXPECT_EQ(built.lines, 5U);
  EXPECT_EQ(built.cut_off, 2U);
  EXPECT_EQ(built.cut_off_mm, 105'000);
  EXPECT_EQ(built.length_mm, 90'000);
  EXPECT_EQ(built.driven_mm, 50'000);
  // Of two that are equally long, the first.
  EXPECT_EQ(RoadTexts(Built({{1, kStreet, {{0, 0}, {20, 0}}}, {2, kStreet, {{40, 0}, {60, 0}}}})),
            (Texts{"1 street: 0,0 20,0"}));
}

TEST(RoadBuilder, DoublesAndPiecesWithoutLengthAreDropped) {
  const BuiltRoads built = Built({{1, kStreet, {{0, 0}, {0, 0}, {50, 0}, {50.0004, 0}}},
                                  {2, kStreet, {{50, 0}, {0, 0}}},
                                  {3, kStreet, {{50, 0}, {50, 0}}},
                                  {4, kPath, {{0, 0}, {50, 0}}}});
  EXPECT_EQ(RoadTexts(built), (Texts{"1 street: 0,0 50,0", "4 path: 0,0 50,0"}));
  EXPECT_EQ(built.lines, 3U);
  EXPECT_EQ(built.cut_off, 0U);
  // One-way roads there and back are two.
  EXPECT_EQ(Built({{1, kOneWay, {{0, 0}, {50, 0}}},
                   {2, kOneWay, {{50, 0}, {0, 0}}},
                   {3, kPath, {{50, 0}, {60, 0}}},
                   {4, kPath, {{0, 0}, {-9, 0}}}})
                .roads.roads.size(),
            4U);
}

TEST(RoadBuilder, NeighbouringPointsAreAtMost100MetresApart) {
  EXPECT_EQ(RoadTexts(Built({{1, kStreet, {{0, 0}, {250, 0}, {350, 0}}}})),
            (Texts{"1 street: 0,0 83.333,0 166.667,0 250,0 350,0"}));
}

TEST(RoadBuilder, LinesAreCutAtTheBorderOfTheMargin) {
  const BuiltRoads built = Built({{1, kStreet, {{-2000, 500}, {3000, 500}}},
                                  {2, kStreet, {{0, 2001}, {900, 2001}}},
                                  {3, kStreet, {{900, 500}, {900, 2000}}}});
  // 2 is outside. Points that the steps of 100 m put in between are not counted here.
  ASSERT_EQ(built.roads.roads.size(), 1U);
  const std::string shown = RoadTexts(built)[0];
  EXPECT_TRUE(shown.starts_with("1 street: -1000,500 -900,500 ")) << shown;
  EXPECT_TRUE(shown.ends_with(" 1900,500 2000,500")) << shown;
  EXPECT_EQ(built.lines, 2U);
  EXPECT_EQ(built.cut_off_mm, 1'500'000);
}

TEST(RoadBuilder, ALineThatLeavesAndComesBackIsInTwoPieces) {
  const BuiltRoads built = Built({{1, kPath, {{500, 1950}, {500, 2500}, {600, 2500}, {600, 1950}}},
                                  {2, kStreet, {{500, 1950}, {600, 1950}}}});
  EXPECT_EQ(RoadTexts(built), (Texts{"1 path: 500,1950 500,2000", "1 path: 600,2000 600,1950",
                                     "2 street: 500,1950 600,1950"}));
}

TEST(RoadBuilder, CutEndsDoNotMeet) {
  // Both cross the border at (-1000, 500); they meet at (-950, 525).
  const BuiltRoads built = Built({{1, kStreet, {{-1050, 500}, {-950, 500}, {-950, 525}}},
                                  {2, kStreet, {{-1050, 475}, {-950, 525}}}});
  ASSERT_EQ(RoadTexts(built), (Texts{"1 street: -1000,500 -950,500 -950,525 -1000,500"}));
  EXPECT_NE(built.roads.roads[0].points.front(), built.roads.roads[0].points.back());
}

TEST(RoadBuilder, APointAtTheBorderIsNoCut) {
  // The first point inside is in the same millimetre as the cut, and the other line meets it.
  for (const bool is_last : {false, true}) {
    Line line{1, kStreet, {{-1100, 500}, {-999.9998, 500}, {-990, 500}}};
    if (is_last) std::reverse(line.places.begin(), line.places.end());
    const BuiltRoads built = Built({line, {2, kPath, {{-999.9998, 500}, {-999.9998, 510}}}});
    EXPECT_EQ(RoadTexts(built),
              (Texts{is_last ? "1 street: -990,500 -1000,500" : "1 street: -1000,500 -990,500",
                     "2 path: -1000,500 -1000,510"}));
  }
}

TEST(RoadBuilder, PlacesOnOtherContinentsAreInNoArea) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  RoadBuilder builder(1000, 1000, 0);
  builder.AddLine(1, kStreet, {{kNan, kNan}, {kNan, kNan}});
  builder.AddLine(2, kStreet, {{5e5, 0}, {5e5, 900}});
  builder.AddLine(3, kStreet, {});
  builder.AddLine(4, kStreet, {{5, 5}});
  EXPECT_TRUE(builder.empty());
  EXPECT_EQ(RoadTexts(Built({{1, kStreet, {{kNan, kNan}, {0, 0}, {9, 0}, {kNan, kNan}}}})),
            (Texts{"1 street: 0,0 9,0"}));
}

TEST(RoadBuilder, JoinsPointsThatAreNear) {
  const std::vector<Line> lines = {{1, kStreet, {{0, 0}, {50, 0}}},
                                   {2, kStreet, {{50.3, 0.4}, {80, 0}}}};
  const BuiltRoads apart = Built(lines);
  EXPECT_EQ(apart.cut_off, 1U);
  EXPECT_EQ(apart.joined, 0U);
  EXPECT_EQ(Built(lines, 0.499).joined, 0U);
  const BuiltRoads joined = Built(lines, 0.5);  // a triangle of 3, 4, 5
  EXPECT_EQ(RoadTexts(joined), (Texts{"1 street: 0,0 50,0 80,0"}));
  EXPECT_EQ(joined.joined, 1U);
  // A barrier goes with its point.
  EXPECT_EQ(RoadTexts(Built(lines, 0.5, {{50.3, 0.4}})),
            (Texts{"1 street: 0,0 49,0", "1 street, barrier: 49,0 50,0 51,0",
                   "2 street, cut off for vehicles: 51,0 80,0"}));
}

TEST(RoadBuilder, ABarrierClosesAMetreOnEachSideToVehicles) {
  const std::vector<Line> lines = {{1, kStreet, {{0, 0}, {60, 0}, {80, 0}}},
                                   {2, kPath, {{0, 0}, {0, 60}, {0, 80}}}};
  const BuiltRoads built = Built(lines, 0, {{60, 0}, {0, 60}, {7, 7}});
  EXPECT_EQ(RoadTexts(built),
            (Texts{"1 street: 0,0 59,0", "1 street, barrier: 59,0 60,0 61,0",
                   "1 street, cut off for vehicles: 61,0 80,0", "2 path: 0,0 0,60 0,80"}));
  EXPECT_EQ(built.barriers, 2U);  // 7,7 is on no road
  // Too short to be divided.
  EXPECT_EQ(RoadTexts(Built({{1, kStreet, {{0, 0}, {50, 0}, {53, 0}}}}, 0, {{53, 0}})),
            (Texts{"1 street: 0,0 50,0", "1 street, barrier: 50,0 53,0"}));
}

TEST(RoadBuilder, RefusesRoadsThatNobodyComesBackBy) {
  EXPECT_EQ(ErrorOf([] {
              Built({{1, kMotorway, {{0, 0}, {90, 0}}}});
            }),
            "t.osm: roads: found one-way roads alone, from which no way leads back, expected a "
            "network");
}

/// Lines between points of a grid that were moved a little. No two go the same way: of those a
/// place would be on the one that comes first.
std::vector<Line> DrawnLines(std::uint64_t seed) {
  Random random(seed, Stream::kTest);
  constexpr int kSide = 8;
  std::vector<Point> points;
  for (int i = 0; i < kSide * kSide; ++i) {
    points.push_back({(i % kSide) * 300 - 700 + random.Uniform(0, 100),
                      (i / kSide) * 300 - 700 + random.Uniform(0, 100)});
  }
  std::set<std::pair<int, int>> used;
  std::vector<Line> lines;
  for (std::int64_t id = 0; id < 80; ++id) {
    const RoadClass& road_class = id % 5 == 0 ? kOneWay : id % 7 == 0 ? kPath : kStreet;
    Line line{id, road_class, {}};
    int x = static_cast<int>(random.Below(kSide)), y = static_cast<int>(random.Below(kSide));
    line.places.push_back(points[static_cast<std::size_t>(y * kSide + x)]);
    for (int k = 0; k < 6; ++k) {
      const int to_x = std::clamp(x + static_cast<int>(random.Below(3)) - 1, 0, kSide - 1);
      const int to_y = to_x != x ? y : std::clamp(y + (k % 2 == 0 ? 1 : -1), 0, kSide - 1);
      const int from = y * kSide + x, to = to_y * kSide + to_x;
      if (from == to || !used.emplace(std::minmax(from, to)).second) continue;
      line.places.push_back(points[static_cast<std::size_t>(to)]);
      x = to_x;
      y = to_y;
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

TEST(RoadBuilder, WaysDoNotDependOnTheOrderOfTheLines) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::vector<Line> lines = DrawnLines(seed);
    const BuiltRoads built = Built(lines);
    EXPECT_EQ(RoadsToJson(built.roads), RoadsToJson(Built(lines).roads)) << "seed " << seed;
    Random random(seed, Stream::kTest, 1);
    random.Shuffle(lines);
    for (Line& line : lines) {
      if (!line.road_class.one_way && random.Below(2) == 0) {
        std::reverse(line.places.begin(), line.places.end());
      }
    }
    const BuiltRoads other = Built(lines);
    EXPECT_EQ(built.length_mm, other.length_mm) << "seed " << seed;
    EXPECT_GT(built.junctions, 10U) << "seed " << seed;
    EXPECT_EQ(built.junctions, other.junctions) << "seed " << seed;
    const PerKind<OpenGround> ground = {{}, {50, 1000}, {25, 1000}};
    const RoadWays ways(std::make_shared<const Roads>(built.roads), ground, {});
    const RoadWays other_ways(std::make_shared<const Roads>(other.roads), ground, {});
    for (int i = 0; i < 50; ++i) {
      const Point from{random.Uniform(0, 1000), random.Uniform(0, 1000)};
      const Point to{random.Uniform(0, 1000), random.Uniform(0, 1000)};
      for (const AgentKind kind : {AgentKind::kWorker, AgentKind::kVehicle}) {
        // Places on a road are rounded to a millimetre of its cost, from its first point.
        EXPECT_NEAR(ways.Length(kind, from, to), other_ways.Length(kind, from, to), 0.02)
            << "seed " << seed;
      }
    }
  }
}

}  // namespace
}  // namespace muster::tools
