#include "tools/map/zones_option.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "base/check.h"
#include "model/air_ways.h"
#include "tests/temporary_folder.h"
#include "tools/map/zone_file.h"

namespace muster::tools {
namespace {

/// At 10 N, 20 E; 0.01 degrees are about 1.1 km.
constexpr Origin kCorner{10, 20};

std::string Square(double west, double south, double degrees = 0.01) {
  const double east = west + degrees, north = south + degrees;
  return fmt::format(R"({{"type": "Polygon", "coordinates": [[[{0}, {1}], [{2}, {1}], [{2}, {3}], )"
                     R"([{0}, {3}], [{0}, {1}]]]}})",
                     west, south, east, north);
}

std::string Ed269(const std::string& restriction, const std::string& lower,
                  const std::string& applicability = R"([{"permanent": "YES"}])") {
  return fmt::format(
      R"({{"UASZoneList": [{{"identifier": "A1", "name": "Field", "restriction": "{}", )"
      R"("applicability": {}, "geometry": [{{"uomDimensions": "FT", "lowerLimit": {}, )"
      R"("lowerVerticalReference": "AGL", "upperLimit": null, "horizontalProjection": {}}}]}}]}})",
      restriction, applicability, lower, Square(20.02, 10.02));
}

class ZonesOption : public ::testing::Test {
 protected:
  ZonesOption() {
    scenario_.origin = kCorner;
    scenario_.width_m = scenario_.height_m = 10'000;
  }

  std::vector<std::string> Take(const std::string& text, std::vector<std::string> more = {},
                                const std::string& name = "z.json") {
    std::ofstream(folder_.File(name)) << text;
    Options options("test", "");
    AddZonesOptions(&options);
    more.insert(more.begin(), {"test", "--zones", folder_.File(name)});
    std::vector<const char*> argv;
    for (const std::string& argument : more) argv.push_back(argument.c_str());
    return TakeZones(options.Parse(static_cast<int>(argv.size()), argv.data()).value(), &scenario_);
  }

  TemporaryFolder folder_;
  Scenario scenario_;
};

TEST_F(ZonesOption, KeepApartMakesAnAirspaceWithoutZones) {
  const auto take = [](std::vector<const char*> argv) {
    Options options("test", "");
    AddZonesOptions(&options);
    Scenario scenario;
    scenario.width_m = scenario.height_m = 10'000;
    TakeZones(options.Parse(static_cast<int>(argv.size()), argv.data()).value(), &scenario);
    return scenario;
  };
  EXPECT_EQ(take({"test"}).air, nullptr);
  const Scenario apart = take({"test", "--keep-apart"});
  ASSERT_NE(apart.air, nullptr);
  EXPECT_TRUE(apart.air->zones.empty());
  ASSERT_NE(apart.separation(), nullptr);
  EXPECT_EQ(*apart.separation(), Separation());
}

TEST_F(ZonesOption, TakesPolygonsOfGeoJsonInTheAreaWithTheirNames) {
  const auto said = Take(fmt::format(
      R"({{"type": "FeatureCollection", "features": [
        {{"type": "Feature", "properties": {{"name": "airfield"}}, "geometry": {}}},
        {{"type": "Feature", "properties": null, "geometry": {}}},
        {{"type": "Feature", "properties": null, "geometry": {}}}]}})",
      Square(20.02, 10.02), Square(25, 10), Square(20.03, 10.03, 0)));
  ASSERT_EQ(scenario_.air->zones.size(), 1U);
  EXPECT_EQ(said[0], "zones: z.json: 3, of which 1 are kept out of");
  EXPECT_EQ(said[1], "  left out: 1 elsewhere");
  EXPECT_EQ(said[2], "  left out: 1 without an area");
  const Zone& zone = scenario_.air->zones[0].zone;
  EXPECT_EQ(zone.name, "airfield");
  ASSERT_EQ(zone.rings.size(), 1U);
  EXPECT_EQ(zone.rings[0].size(), 4U);  // the first is not repeated
  EXPECT_NEAR(zone.rings[0][0].x_m, 2193, 5);
  EXPECT_NEAR(zone.rings[0][0].y_m, 2212, 5);
  EXPECT_EQ(scenario_.air->margin_m, 30);
}

TEST_F(ZonesOption, WhatIsRestrictedFromTheGroundIsKeptOutOf) {
  const std::pair<std::string, std::size_t> cases[] = {
      {Ed269("PROHIBITED", "0"), 1},           {Ed269("REQ_AUTHORISATION", R"("0")"), 1},
      {Ed269("REQ_AUTHORISATION", "null"), 1}, {Ed269("CONDITIONAL", "0"), 0},
      {Ed269("NO_RESTRICTION", "0"), 0},       {Ed269("PROHIBITED", "390"), 1},  // feet: 118.9 m
      {Ed269("PROHIBITED", R"("400")"), 0},
  };
  for (const auto& [json, zones] : cases) {
    SCOPED_TRACE(json);
    Take(json);
    EXPECT_EQ(scenario_.air->zones.size(), zones);
  }
  const auto said = Take(Ed269("PROHIBITED", "0"), {"--authorised", "A1,B2"});
  EXPECT_TRUE(scenario_.air->zones.empty());
  EXPECT_EQ(said.back(), "  --authorised B2: there is no such zone");
}

TEST_F(ZonesOption, AZoneThatBeginsHighAboveTheGroundIsFlownBelow) {
  const auto said = Take(Ed269("PROHIBITED", "200"));  // feet
  ASSERT_EQ(scenario_.air->zones.size(), 1U);
  EXPECT_DOUBLE_EQ(scenario_.air->zones[0].lower_m, 60.96);
  EXPECT_EQ(said.back(), "  1 begin above the ground: UAVs fly below them");
  EXPECT_EQ(Take(Ed269("PROHIBITED", "100")).size(), 1U) << "30 m are too low for that";
  EXPECT_DOUBLE_EQ(scenario_.air->zones[0].lower_m, 30.48);
}

TEST_F(ZonesOption, TimesCountFromTheStartOfTheMission) {
  const auto json = Ed269("PROHIBITED", "0",
                          R"([{"permanent": "NO", "startDateTime": "2026-05-01T10:30:00Z", )"
                          R"("endDateTime": "2026-05-01T12:00:00+00:00"}])");
  const auto said = Take(json);
  EXPECT_EQ(scenario_.air->zones[0].until_us, kNever);
  EXPECT_EQ(said[1], "  1 have a time: without --start they hold all the time");
  scenario_.start = ParseMoment("2026-05-01T12:00:00+02:00");
  Take(json);
  EXPECT_EQ(scenario_.air->zones[0].from_us, 30 * kMinuteUs);
  EXPECT_EQ(scenario_.air->zones[0].until_us, 120 * kMinuteUs);
  scenario_.start = ParseMoment("2026-05-02T12:00:00+02:00");
  EXPECT_EQ(Take(json)[1], "  left out: 1 at another time");
}

TEST_F(ZonesOption, CirclesOfBothFormats) {
  Take(R"({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {
    "identifier": "C", "type": "PROHIBITED", "name": [{"text": "Feld", "lang": "de-CH"},
    {"text": "Field", "lang": "en-GB"}]}, "geometry": {"type": "Point", "coordinates": [20.03, 10.03],
    "extent": {"subType": "Circle", "radius": 500}, "layer": {"lower": 0, "lowerReference": "AGL", "uom": "m"}}}]})");
  ASSERT_EQ(scenario_.air->zones.size(), 1U);
  EXPECT_EQ(scenario_.air->zones[0].zone.name, "Field");
  EXPECT_EQ(scenario_.air->zones[0].zone.rings[0].size(), 16U);
}

TEST_F(ZonesOption, TooManyCornersMakeTheZoneLargerNeverSmaller) {
  std::string corners;
  for (int i = 0; i < 1200; ++i) {  // a saw along the south, up to a roof
    corners += fmt::format("[{}, {}], ", 20.02 + i * 0.00002, 10.02 + (i % 2) * 0.001);
  }
  const auto said = Take(R"({"type": "FeatureCollection", "features": [{"type": "Feature",
    "geometry": {"type": "Polygon", "coordinates": [[)" +
                         corners + "[20.05, 10.05], [20.02, 10.05]]]}}]}");
  EXPECT_EQ(said[1], "  1 made larger, to have at most 500 corners");
  const Zone& zone = scenario_.air->zones[0].zone;
  EXPECT_EQ(zone.rings[0].size(), 500U);
  EXPECT_TRUE(IsInside(zone, {3000, 3000}));
}

TEST_F(ZonesOption, SamplesOfBothFormatsAreRead) {
  const char* root = std::getenv("MUSTER_SHARED");
  const std::string folder = (root ? std::string(root) : MUSTER_SHARED_DEFAULT) + "/data/zones";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  for (const auto& [name, n] :
       {std::pair("sample_ed269.json", 1), std::pair("sample_ed318.json", 3)}) {
    std::ifstream in(folder + "/" + name);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const std::vector<MapZone> zones = ParseZones(text, name);
    ASSERT_EQ(zones.size(), static_cast<std::size_t>(n));
    EXPECT_EQ(zones[0].rule, MapZone::Rule::kAuthorisation);
    EXPECT_FALSE(zones[0].recurs);
    EXPECT_GE(zones[0].rings[0].size(), 5U);
  }
}

std::string Placemark(const std::string& name, const std::string& shape) {
  return "<Placemark><name>" + name + "</name>" + shape + "</Placemark>";
}

std::string KmlTriangle(double west, double south) {
  return fmt::format(
      "<Polygon><outerBoundaryIs><LinearRing><coordinates>{0},{1},90 {2},{1},90 {2},{3},90 "
      "{0},{1},90</coordinates></LinearRing></outerBoundaryIs></Polygon>",
      west, south, west + 0.01, south + 0.01);
}

std::string Kml(const std::string& content) {
  return R"(<?xml version="1.0" encoding="UTF-8"?><kml xmlns="http://www.opengis.net/kml/2.2">)"
         "<Document>" +
         content + "</Document></kml>";
}

TEST_F(ZonesOption, PolygonsOfKmlAreKeptOutOf) {
  scenario_.start = ParseMoment("2026-11-28T10:00:00Z");
  scenario_.rules.limit_us = 60 * kMinuteUs;
  const std::string line =
      "<LineString><coordinates>20.01,10.01 20.02,10.02</coordinates></LineString>";
  const auto said = Take(Kml("<Folder>" + Placemark("Field &amp; hill", KmlTriangle(20.02, 10.02)) +
                             Placemark("A path", line) + "</Folder><Folder>" +
                             Placemark("Crowd",
                                       "<TimeSpan><begin>2026-11-28T10:20:00Z</begin>"
                                       "<end>2026-11-28T10:50:00Z</end></TimeSpan><MultiGeometry>" +
                                           KmlTriangle(20.04, 10.02) + line +
                                           KmlTriangle(20.06, 10.02) + "</MultiGeometry>") +
                             Placemark("Ours", KmlTriangle(20.02, 10.05)) + "</Folder>"),
                         {"--authorised", "Ours"}, "Zones.KML");
  EXPECT_EQ(said, (std::vector<std::string>{"zones: Zones.KML: 4, of which 3 are kept out of",
                                            "  left out: 1 authorised",
                                            "  left out: 1 without an area"}));
  const auto& zones = scenario_.air->zones;
  ASSERT_EQ(zones.size(), 3U);
  EXPECT_EQ(zones[0].zone.name, "Field & hill");
  EXPECT_EQ(zones[0].from_us, 0);
  EXPECT_TRUE(IsInside(zones[0].zone, {2900, 2500}));
  EXPECT_EQ(zones[2].zone.name, "Crowd");
  EXPECT_EQ(zones[2].from_us, 20 * kMinuteUs);
  EXPECT_EQ(zones[2].until_us, 50 * kMinuteUs);
  EXPECT_TRUE(IsInside(zones[2].zone, {7300, 2500}));
}

TEST_F(ZonesOption, KmlWithoutAreasOrOfAnotherKindIsRefused) {
  const std::string point = "<Point><coordinates>20.01,10.01</coordinates></Point>";
  const std::pair<std::string, const char*> cases[] = {
      {Kml(Placemark("P", point)), "1 placemarks without an area, expected KML"},
      {Kml(""), "0 placemarks"},
      {"zones", "what ogr2ogr cannot read"},
      {Kml(Placemark("P", KmlTriangle(220, 10))), "longitude and latitude"},
  };
  for (const auto& [text, expected] : cases) {
    SCOPED_TRACE(text);
    try {
      Take(text, {}, "z.kml");
      ADD_FAILURE() << "was taken";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("z.kml"), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(ReadZones(folder_.File("none.kml")), InputError);
}

TEST_F(ZonesOption, ALineOfOgrThatIsNoFeatureLeavesNoZoneOut) {
  const std::string program = folder_.File("ogr2ogr");
  std::ofstream(program) << "#!/bin/sh\necho '{\"type\": \"Feature\", \"geometry\": "
                         << Square(20.02, 10.02) << "}'\necho nonsense\n";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const std::string before = std::getenv("PATH");
  setenv("PATH", (std::filesystem::path(program).parent_path().string() + ":" + before).c_str(), 1);
  try {
    Take(Kml(Placemark("P", KmlTriangle(20.02, 10.02))), {}, "z.kml");
    ADD_FAILURE() << "was taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("line 2 of ogr2ogr"), std::string::npos)
        << error.what();
  }
  setenv("PATH", before.c_str(), 1);
}

TEST_F(ZonesOption, WhatIsNoZoneIsRefusedByFileAndKey) {
  const std::pair<std::string, const char*> cases[] = {
      {"{", "z.json"},
      {"[]", "no zones"},
      {R"({"type": "FeatureCollection"})", "no zones"},
      {R"({"features": [{"type": "Feature", "geometry": {"type": "LineString"}}]})",
       "geometry.type"},
      {R"({"features": [{"type": "Feature", "geometry": null}]})", "features[0].geometry.type"},
      {R"({"features": [{"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [[[200, 10], [1, 1], [2, 2]]]}}]})",
       "longitude and latitude"},
      {R"({"features": [{"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [[]]}}]})",
       "at least 3 corners"},
      {R"({"features": [7]})", "an object"},
      {Ed269("PROHIBITED", R"("high")"), "lower limit"},
      {Ed269("PROHIBITED", "0", R"([{"startDateTime": "today"}])"), "ISO 8601"},
  };
  for (const auto& [json, expected] : cases) {
    SCOPED_TRACE(json);
    try {
      Take(json);
      ADD_FAILURE() << "was taken";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
  }
  scenario_.origin.reset();
  EXPECT_THROW(Take(Ed269("PROHIBITED", "0")), InputError);
}

}  // namespace
}  // namespace muster::tools
