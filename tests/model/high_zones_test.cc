// Zones that UAVs fly below: hand-made flights, and many samples of drawn ones.
#include "model/high_zones.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "model/generator.h"
#include "model/scenario_json.h"

namespace muster {
namespace {

/// From 1 to 2 km, with a hole in its middle, and from 60 m above the ground.
PlannedZone Square() {
  PlannedZone planned;
  planned.zone.rings = {{{1000, 1000}, {2000, 1000}, {2000, 2000}, {1000, 2000}},
                        {{1400, 1400}, {1600, 1400}, {1600, 1600}, {1400, 1600}}};
  planned.lower_m = 60;
  return planned;
}

HighZone OnlyZone(const PlannedZone& planned) {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  ScenarioAir air;
  air.zones = {planned};
  UseAir(std::move(air), &scenario);
  return HighZonesOf(scenario).at(0);
}

/// At 10 m/s, from one altitude to another at the rate of a UAV.
Trajectory Flight(Point from, Point to, double from_m, double to_m) {
  const double seconds = Distance(from, to) / 10;
  const double change_s = to_m > from_m ? (to_m - from_m) / 2.5 : (from_m - to_m) / 1.5;
  Trajectory path;
  path.knots.push_back({0, from, from_m});
  if (change_s > 0 && change_s < seconds) {
    path.knots.push_back({change_s, Lerp(from, to, change_s / seconds), to_m});
  }
  path.knots.push_back({seconds, to, to_m});
  return path;
}

TEST(HighZones, BeginHighEnoughForTheLowestAltitudeBelow) {
  ScenarioAir air;
  PlannedZone zone = Square();
  for (const auto& [lower_m, is_high] : {std::pair(0.0, false), {39.9, false}, {40.0, true}}) {
    zone.lower_m = lower_m;
    EXPECT_EQ(IsHigh(zone, air), is_high) << lower_m;
  }
  air.separation->lowest_m = 50;
  EXPECT_FALSE(IsHigh(zone, air));
  air.separation.reset();
  zone.lower_m = 1000;
  EXPECT_FALSE(IsHigh(zone, air)) << "nobody knows how high they fly";
}

TEST(HighZones, AreFlownBelow) {
  const HighZone zone = OnlyZone(Square());
  EXPECT_EQ(zone.highest_m, 50);
  const auto is_too_high = [&](const Trajectory& path) {
    return IsTooHigh(path, path.knots.back().up_m, zone);
  };
  EXPECT_FALSE(is_too_high(Flight({0, 1200}, {3000, 1200}, 50, 50)));
  EXPECT_TRUE(is_too_high(Flight({0, 1200}, {3000, 1200}, 60, 60)));
  // The margin is 30 m.
  EXPECT_FALSE(is_too_high(Flight({0, 2031}, {3000, 2031}, 60, 60)));
  EXPECT_TRUE(is_too_high(Flight({0, 2029}, {3000, 2029}, 60, 60)));
  // From 110 m down to 50 m takes 40 s, in which it flies 400 m.
  EXPECT_FALSE(is_too_high(Flight({500, 1200}, {1500, 1200}, 110, 50)));
  EXPECT_TRUE(is_too_high(Flight({600, 1200}, {1500, 1200}, 110, 50)));
  // It climbs when it has left the zone, but might be stopped before.
  EXPECT_TRUE(is_too_high(Flight({1200, 1200}, {4000, 1200}, 30, 110)));
  EXPECT_FALSE(is_too_high(Flight({2040, 1200}, {4000, 1200}, 30, 110)));
  EXPECT_TRUE(is_too_high(Flight({1200, 1200}, {1200, 1200}, 60, 60)));
  EXPECT_FALSE(is_too_high(Flight({1500, 1450}, {1500, 1550}, 60, 60))) << "in the hole";
  Trajectory stands = Flight({1200, 1200}, {1200, 1200}, 0, 0);
  EXPECT_FALSE(IsTooHigh(stands, 90, zone)) << "it is on the ground";
}

TEST(HighZones, NoSampleOfAFlightIsTooHighWhereItIsSaidNotToBe) {
  Random random(1, Stream::kTest, 71);
  int high = 0, low = 0;
  for (int i = 0; i < 4000; ++i) {
    PlannedZone planned = Square();
    planned.zone.rings.resize(1 + random.Below(2));
    for (Point& corner : planned.zone.rings[0]) {
      corner = {corner.x_m + random.Below(600) - 300, corner.y_m + random.Below(600) - 300};
    }
    const HighZone zone = OnlyZone(planned);
    const auto place = [&] { return Point{random.Below(3000) * 1.0, random.Below(3000) * 1.0}; };
    const auto altitude = [&] { return 30.0 + 10 * random.Below(10); };
    const Trajectory path = Flight(place(), place(), altitude(), altitude());
    const double to_m = path.knots.back().up_m;
    bool is_found = false;
    for (std::size_t k = 0; k + 1 < path.knots.size(); ++k) {
      for (int part = 0; part <= 200; ++part) {
        const Trajectory::Knot &a = path.knots[k], &b = path.knots[k + 1];
        const Point at = Lerp(a.at, b.at, part / 200.0);
        const double up_m = a.up_m + (b.up_m - a.up_m) * part / 200;
        is_found |= up_m > zone.highest_m && IsInside(zone.zone, at);
      }
    }
    const bool is_said = IsTooHigh(path, to_m, zone);
    EXPECT_TRUE(is_said || !is_found) << "flight " << i;
    (is_said ? high : low) += 1;
  }
  EXPECT_GT(high, 500);
  EXPECT_GT(low, 500);
}

TEST(HighZones, AreKeysOfTheScenario) {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  ScenarioAir air;
  air.zones = {Square()};
  UseAir(std::move(air), &scenario);
  const std::string text = ScenarioToJson(scenario);
  EXPECT_NE(text.find("\"lower_m\": 60"), std::string::npos);
  const Scenario again = ParseScenario(text, "again");
  EXPECT_EQ(again.air->zones.at(0).lower_m, 60);
  EXPECT_EQ(ScenarioToJson(again), text);
  EXPECT_TRUE(again.ways->straight(AgentKind::kUav));
}

}  // namespace
}  // namespace muster
