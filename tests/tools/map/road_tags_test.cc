#include "tools/map/road_tags.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

namespace muster::tools {
namespace {

/// "name: workers/vehicles", with "->" or "<-" behind it on a one-way road.
std::string RoadOf(const MapTags& tags) {
  RoadTags reader;
  const auto use = reader.Read(tags);
  if (!use) return "left out: " + reader.left_out().begin()->first;
  const RoadClass& road = use->road_class;
  return fmt::format("{}: {}/{}{}", road.name, road.percent.workers, road.percent.vehicles,
                     use->backward  ? " <-"
                     : road.one_way ? " ->"
                                    : "");
}

TEST(RoadTags, ClassesHaveTheirUsualSpeeds) {
  EXPECT_EQ(RoadOf({{"highway", "motorway"}}), "motorway, one-way: 0/100 ->");
  EXPECT_EQ(RoadOf({{"highway", "trunk"}}), "trunk: 100/100");
  EXPECT_EQ(RoadOf({{"highway", "primary"}}), "primary: 100/75");
  EXPECT_EQ(RoadOf({{"highway", "secondary"}}), "secondary: 100/69");
  EXPECT_EQ(RoadOf({{"highway", "tertiary"}}), "tertiary: 100/56");
  EXPECT_EQ(RoadOf({{"highway", "residential"}}), "residential: 100/38");
  EXPECT_EQ(RoadOf({{"highway", "service"}}), "service: 100/19");
  EXPECT_EQ(RoadOf({{"highway", "track"}}), "track: 90/19");
  EXPECT_EQ(RoadOf({{"highway", "steps"}}), "steps: 50/0");
  EXPECT_EQ(RoadOf({{"highway", "footway"}}), "footway: 100/0");
  // What Geofabrik's shapefiles call it.
  EXPECT_EQ(RoadOf({{"fclass", "tertiary"}}), "tertiary: 100/56");
  EXPECT_EQ(RoadOf({{"type", "track"}}), "track: 90/19");
  EXPECT_EQ(RoadOf({{"highway", "track"}, {"type", "primary"}}), "track: 90/19");
}

/// A row of the guide names one or more classes: | `primary`, `road` | 100 | 60 | 75 |
TEST(RoadTags, TheGuideHasTheTable) {
  std::ifstream guide(MUSTER_SOURCE_DIR "/docs/guide/roads.md");
  ASSERT_TRUE(guide.is_open());
  std::vector<std::string> rows;
  for (std::string line; std::getline(guide, line);) rows.push_back(line);
  for (const UsualRoad& usual : UsualRoads()) {
    const std::string tail =
        fmt::format(" | {} | {} | {} |", usual.workers_percent,
                    usual.vehicles_km_h == 0 ? "" : fmt::format("{}", usual.vehicles_km_h),
                    std::min(100L, std::lround(100 * usual.vehicles_km_h / kFullRoadSpeed_km_h)));
    EXPECT_TRUE(std::any_of(rows.begin(), rows.end(),
                            [&](const std::string& row) {
                              return row.find(fmt::format("`{}`", usual.name)) != row.npos &&
                                     row.ends_with(tail);
                            }))
        << usual.name << tail;
  }
}

TEST(RoadTags, WhatIsNoRoadIsCounted) {
  RoadTags reader;
  for (const char* value : {"construction", "proposed", "raceway", "construction"}) {
    EXPECT_FALSE(reader.Read({{"highway", value}}));
  }
  EXPECT_FALSE(reader.Read({{"waterway", "river"}}));
  EXPECT_FALSE(reader.Read({{"highway", "pedestrian"}, {"area", "yes"}}));
  EXPECT_EQ(reader.left_out(), (std::map<std::string, std::size_t>{{"construction", 2},
                                                                   {"proposed", 1},
                                                                   {"raceway", 1},
                                                                   {"areas", 1},
                                                                   {"without a highway tag", 1}}));
}

TEST(RoadTags, OneWay) {
  const auto shown = [](const char* oneway) {
    return RoadOf({{"highway", "residential"}, {"oneway", oneway}});
  };
  for (const char* said : {"yes", "true", "1", "f"}) {
    EXPECT_EQ(shown(said), "residential, one-way: 100/38 ->") << said;
  }
  for (const char* said : {"-1", "reverse", "t"}) {
    EXPECT_EQ(shown(said), "residential, one-way: 100/38 <-") << said;
  }
  for (const char* said : {"no", "0", "b", "alternating"}) {
    EXPECT_EQ(shown(said), "residential: 100/38") << said;
  }
  EXPECT_EQ(RoadOf({{"highway", "tertiary"}, {"junction", "roundabout"}}),
            "tertiary, one-way: 100/56 ->");
  EXPECT_EQ(RoadOf({{"highway", "motorway"}, {"oneway", "no"}}), "motorway: 0/100");
  // People go both ways: on a path it says nothing.
  EXPECT_EQ(RoadOf({{"highway", "footway"}, {"oneway", "yes"}}), "footway: 100/0");
}

TEST(RoadTags, SpeedLimits) {
  EXPECT_EQ(SpeedLimit("50"), 50);
  EXPECT_EQ(SpeedLimit("50 km/h"), 50);
  EXPECT_EQ(SpeedLimit("50kmh"), 50);
  EXPECT_DOUBLE_EQ(SpeedLimit("30 mph").value(), 48.28032);
  EXPECT_EQ(SpeedLimit("walk"), 5);
  EXPECT_EQ(SpeedLimit("none"), 80);
  for (const char* junk : {"", "fast", "50;30", "-5", "0", "nan", "1e400", "mph", "5 knots"}) {
    EXPECT_FALSE(SpeedLimit(junk)) << junk;
  }
  const auto shown = [](const char* maxspeed) {
    return RoadOf({{"highway", "tertiary"}, {"maxspeed", maxspeed}});
  };
  EXPECT_EQ(shown("40"), "tertiary, 40 km/h: 100/50");
  EXPECT_EQ(shown("120"), "tertiary, 120 km/h: 100/100");
  EXPECT_EQ(shown("0.1"), "tertiary, 0 km/h: 100/1");
  EXPECT_EQ(RoadOf({{"highway", "path"}, {"maxspeed", "40"}}), "path: 100/0");
}

TEST(RoadTags, SpeedLimitsThatAreNoneAreCounted) {
  RoadTags reader;
  for (const char* told : {"0", "signals", "40", "ro:urban"}) {
    const auto use = reader.Read({{"highway", "tertiary"}, {"maxspeed", told}});
    EXPECT_EQ(use->road_class.percent.vehicles, std::string(told) == "40" ? 50 : 56) << told;
  }
  EXPECT_EQ(reader.unknown_speeds(), 2U);  // 0 is how a column says that nothing is known
  EXPECT_EQ(reader.unknown_speed(), "signals");
}

TEST(RoadTags, Access) {
  const auto shown = [](MapTags tags) {
    tags["highway"] = "track";
    return RoadOf(tags);
  };
  EXPECT_EQ(shown({{"access", "no"}}), "left out: closed to all");
  EXPECT_EQ(shown({{"access", "private"}}), "left out: closed to all");
  EXPECT_EQ(shown({{"access", "private"}, {"foot", "yes"}}), "track, no vehicles: 90/0");
  EXPECT_EQ(shown({{"access", "no"}, {"vehicle", "yes"}}), "track, not on foot: 0/19");
  EXPECT_EQ(shown({{"vehicle", "no"}}), "track, no vehicles: 90/0");
  EXPECT_EQ(shown({{"vehicle", "no"}, {"motor_vehicle", "yes"}}), "track: 90/19");
  EXPECT_EQ(shown({{"motor_vehicle", "private"}}), "track, no vehicles: 90/0");
  EXPECT_EQ(shown({{"motorcar", "no"}}), "track, no vehicles: 90/0");
  EXPECT_EQ(shown({{"foot", "no"}}), "track, not on foot: 0/19");
  EXPECT_EQ(shown({{"access", "destination"}}), "track: 90/19");
  // It takes, and never gives.
  EXPECT_EQ(RoadOf({{"highway", "motorway"}, {"foot", "yes"}}), "motorway, one-way: 0/100 ->");
  EXPECT_EQ(RoadOf({{"highway", "path"}, {"motor_vehicle", "yes"}}), "path: 100/0");
}

TEST(RoadTags, Barriers) {
  EXPECT_TRUE(StopsVehicles({{"barrier", "bollard"}}));
  EXPECT_TRUE(StopsVehicles({{"barrier", "block"}}));
  EXPECT_TRUE(StopsVehicles({{"barrier", "gate"}, {"locked", "yes"}}));
  EXPECT_TRUE(StopsVehicles({{"barrier", "gate"}, {"access", "private"}}));
  EXPECT_TRUE(StopsVehicles({{"barrier", "lift_gate"}, {"motor_vehicle", "no"}}));
  EXPECT_FALSE(StopsVehicles({{"barrier", "gate"}}));
  EXPECT_FALSE(StopsVehicles({{"barrier", "entrance"}}));
  EXPECT_FALSE(StopsVehicles({}));
}

}  // namespace
}  // namespace muster::tools
