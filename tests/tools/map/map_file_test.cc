#include "tools/map/map_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/error_of.h"

namespace muster::tools {
namespace {

std::vector<MapFeature> Parsed(const std::string& text) {
  std::vector<MapFeature> features;
  ParseGeoJsonMap(text, "t.geojson", [&](const MapFeature& f) { features.push_back(f); });
  return features;
}

std::string Collection(const std::string& features) {
  return R"({"type": "FeatureCollection", "features": [)" + features + "]}";
}

std::string LineFeature(const std::string& coordinates) {
  return R"({"type": "Feature", "properties": {"highway": "track"}, "geometry": )"
         R"({"type": "LineString", "coordinates": )" +
         coordinates + "}}";
}

TEST(GeoJsonMap, ReadsLinesPointsAndTags) {
  const std::vector<MapFeature> features = Parsed("\xEF\xBB\xBF" + Collection(R"(
    {"type": "Feature", "id": "way/7",
     "properties": {"Highway": "Track", "oneway": true, "maxspeed": 30, "name": null,
                    "other_tags": "\"access\"=>\"no\",\"a\"=>\"b \\\"c\\\"\""},
     "geometry": {"type": "LineString", "coordinates": [[9.5, 47.1], [9.123456789, -47.2, 450]]}},
    {"type": "Feature", "properties": {"osm_id": "12", "barrier": "gate"},
     "geometry": {"type": "Point", "coordinates": [1, 2]}},
    {"type": "Feature", "properties": {"tags": "\"highway\"=\"primary\",\"bri"},
     "geometry": {"type": "MultiLineString", "coordinates": [[[1, 2], [3, 4]], [[5, 6], [7, 8]]]}},
    {"type": "Feature", "properties": null, "geometry": null},
    {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [[[1, 2]]]}})"));
  ASSERT_EQ(features.size(), 5U);
  EXPECT_EQ(features[0].id, 7);
  EXPECT_EQ(features[0].tags, (MapTags{{"highway", "track"},
                                       {"oneway", "true"},
                                       {"maxspeed", "30"},
                                       {"access", "no"},
                                       {"a", "b \"c\""}}));
  ASSERT_EQ(features[0].lines.size(), 1U);
  EXPECT_EQ(features[0].lines[0][1].latitude_deg, -47.2);
  EXPECT_EQ(features[0].lines[0][1].longitude_deg, 9.1234568);  // 1e-7 degrees
  EXPECT_EQ(features[1].id, 12);
  EXPECT_EQ(features[1].point->latitude_deg, 2);
  EXPECT_TRUE(features[1].lines.empty());
  EXPECT_EQ(features[2].id, 3);
  EXPECT_EQ(features[2].tags, (MapTags{{"highway", "primary"}}));
  ASSERT_EQ(features[2].lines.size(), 2U);
  EXPECT_EQ(features[2].lines[1][0].longitude_deg, 5);
  EXPECT_TRUE(features[3].lines.empty() && features[4].lines.empty());

  EXPECT_EQ(Parsed(LineFeature("[[1, 2], [3, 4]]")).size(), 1U);
}

TEST(GeoJsonMap, RefusesWhatItCannotUse) {
  const auto error = [](const std::string& text) { return ErrorOf([&] { Parsed(text); }); };
  const std::string collection = "GeoJSON: a FeatureCollection of lines";
  EXPECT_EQ(error("{\"type\": \"Topology\"}"),
            "t.geojson: content: found {\"type\":\"Topology\"}, expected " + collection);
  EXPECT_EQ(error("[1]"), "t.geojson: content: found [1], expected " + collection);
  EXPECT_EQ(error(Collection("")), "t.geojson: content: found no feature, expected " + collection);
  EXPECT_EQ(error("{\"type\":\n \"Feat"),
            "t.geojson: content: found its end in the middle, expected " + collection);
  EXPECT_EQ(error("{\"type\":\n  nothing}"),
            "t.geojson: line 2, column 4: found what is no JSON, expected " + collection);
  const std::string degrees = "degrees, [longitude, latitude] within 180 and 90 (WGS84)";
  EXPECT_EQ(error(Collection(LineFeature("[[1, 2], [500123.5, 2000000]]"))),
            "t.geojson: feature 1: geometry.coordinates[1]: found [500123.5,2000000], expected " +
                degrees);
  EXPECT_EQ(error(Collection(LineFeature("[[1, 2], [3, 4]]") + "," + LineFeature("[[1, 90.1]]"))),
            "t.geojson: feature 2: geometry.coordinates[0]: found [1,90.1], expected " + degrees);
  EXPECT_EQ(error(Collection(LineFeature("[[1, 2], [3]]"))),
            "t.geojson: feature 1: geometry.coordinates[1]: found [3], expected " + degrees);
  EXPECT_EQ(error(Collection(LineFeature("7"))),
            "t.geojson: feature 1: geometry.coordinates: found 7, expected an array");
}

TEST(GeoJsonMap, WhatIsCutOffAnywhereIsAnInputError) {
  const std::string text = Collection(LineFeature("[[1, 2], [3, 4]]"));
  for (std::size_t size = 0; size < text.size(); ++size) {
    EXPECT_NE(ErrorOf([&] { Parsed(text.substr(0, size)); }), "") << size;
  }
}

TEST(GeoJsonMap, ValuesInValuesWithoutEndDoNotExhaustTheStack) {
  const std::string deep = std::string(1'000'000, '[') + std::string(1'000'000, ']');
  EXPECT_THROW(Parsed(R"({"type": "FeatureCollection", "features": [{"type": "Feature", "x": )" +
                      deep + "}]}"),
               InputError);
}

TEST(MapFile, TagsInOneText) {
  const auto tags = [](std::string_view text) {
    MapTags read;
    AddTags(text, &read);
    return read;
  };
  EXPECT_EQ(tags(R"("oneway"=>"yes","lanes"=>"2")"), (MapTags{{"oneway", "yes"}, {"lanes", "2"}}));
  EXPECT_EQ(tags(R"("A"="B" , "c"="d")"), (MapTags{{"a", "b"}, {"c", "d"}}));
  EXPECT_EQ(tags(R"("a"=>"b","c"=>"d)"), (MapTags{{"a", "b"}}));
  EXPECT_EQ(tags("words"), MapTags());
  EXPECT_EQ(tags(""), MapTags());
}

TEST(MapFile, FormatsByName) {
  EXPECT_EQ(MapFormatOf("a/b.OSM.PBF"), MapFormat::kOsm);
  EXPECT_EQ(MapFormatOf("b.osm"), MapFormat::kOsm);
  EXPECT_EQ(MapFormatOf("b.json"), MapFormat::kGeoJson);
  EXPECT_EQ(MapFormatOf("b.geojson"), MapFormat::kGeoJson);
  EXPECT_EQ(MapFormatOf("b.shp"), MapFormat::kShapefile);
  EXPECT_EQ(ErrorOf([] { MapFormatOf("b.csv"); }),
            "command line: --roads: found 'b.csv', expected a file .osm.pbf, .osm, .geojson, "
            ".json or .shp, or a road file *.roads.json");
}

}  // namespace
}  // namespace muster::tools
