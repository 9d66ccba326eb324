#include "tools/map/roads_option.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "base/spawn.h"
#include "model/scenario_json.h"
#include "tests/error_of.h"
#include "tests/temporary_folder.h"
#include "tools/map/map_file.h"
#include "tools/scenario/scenario_command.h"

namespace muster::tools {
namespace {

constexpr const char* kNoOgr = "no ogr2ogr (apt-get install gdal-bin)";

bool HasOgr() { return FindProgram("ogr2ogr").has_value(); }

void Write(const std::string& file, const std::string& text) { std::ofstream(file) << text; }

std::string Read(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string Shared(const std::string& path) {
  const char* root = std::getenv("MUSTER_SHARED");
  return (root != nullptr ? std::string(root) : std::string(MUSTER_SHARED_DEFAULT)) + "/" + path;
}

/// `muster scenario` with these arguments behind "--seed 1 -q".
void MakeScenario(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv = {"muster scenario", "-q"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  EXPECT_EQ(ScenarioCommand(static_cast<int>(argv.size()), argv.data()), 0);
}

/// What TakeRoads says of an area.
std::vector<std::string> Taken(const std::string& roads, Origin corner, double width_m,
                               double height_m, Scenario* scenario) {
  Options options("test", "");
  options.Out("FILE", "");
  AddRoadsOptions(&options);
  const char* argv[] = {"test", "--out", "t.json", "--roads", roads.c_str()};
  scenario->origin = corner;
  scenario->width_m = width_m;
  scenario->height_m = height_m;
  return TakeRoads(options.Parse(5, argv).value(), scenario);
}

/// A crossing of two streets at 10 N, 20 E, a footbridge over one of them, a street that is closed
/// by a bollard, and a river. 0.001 degrees are about 110 m.
constexpr const char* kOsm = R"(<?xml version="1.0"?>
<osm version="0.6">
 <node id="1" lat="10.000" lon="20.001" version="1"/>
 <node id="2" lat="10.001" lon="20.001" version="1"/>
 <node id="3" lat="10.002" lon="20.001" version="1"/>
 <node id="4" lat="10.001" lon="20.000" version="1"/>
 <node id="5" lat="10.001" lon="20.002" version="1"/>
 <node id="6" lat="10.001" lon="20.003" version="1">
  <tag k="barrier" v="bollard"/>
 </node>
 <node id="7" lat="10.001" lon="20.004" version="1"/>
 <way id="70" version="1">
  <nd ref="1"/><nd ref="2"/><nd ref="3"/>
  <tag k="highway" v="primary"/><tag k="maxspeed" v="40"/>
 </way>
 <way id="71" version="1">
  <nd ref="4"/><nd ref="2"/><nd ref="5"/>
  <tag k="highway" v="residential"/>
 </way>
 <way id="72" version="1">
  <nd ref="5"/><nd ref="6"/><nd ref="7"/>
  <tag k="highway" v="residential"/>
 </way>
 <way id="73" version="1">
  <nd ref="1"/><nd ref="5"/>
  <tag k="waterway" v="river"/>
 </way>
</osm>
)";

const std::vector<std::string> kHere = {"--origin", "10,20", "--area", "1x1"};

std::vector<std::string> Here(std::vector<std::string> more) {
  more.insert(more.begin(), kHere.begin(), kHere.end());
  return more;
}

TEST(RoadsOption, OpenStreetMap) {
  if (!HasOgr()) GTEST_SKIP() << kNoOgr;
  const TemporaryFolder folder;
  Write(folder.File("village.osm"), kOsm);
  MakeScenario(Here({"--roads", folder.File("village.osm"), "--out", folder.File("mine.json")}));
  const Scenario scenario = LoadScenario(folder.File("mine.json"));
  EXPECT_EQ(scenario.origin->longitude_deg, 20);
  ASSERT_TRUE(scenario.roads);
  EXPECT_EQ(scenario.roads->file, "mine.roads.json");
  const Roads& roads = *scenario.roads->network;
  EXPECT_EQ(roads.source, "village.osm; (c) OpenStreetMap contributors, ODbL 1.0");
  std::vector<std::string> shown;
  for (const Road& road : roads.roads) {
    const RoadClass& its = roads.classes[static_cast<std::size_t>(road.road_class)];
    shown.push_back(
        fmt::format("{} {} {}/{}", road.id, its.name, its.percent.workers, its.percent.vehicles));
  }
  // The bollard is between 71 and 72 on one side, and 72 on the other.
  EXPECT_EQ(shown,
            (std::vector<std::string>{"70 primary, 40 km/h 100/50", "70 primary, 40 km/h 100/50",
                                      "71 residential 100/38", "71 residential 100/38",
                                      "72 residential, barrier 100/0",
                                      "72 residential, cut off for vehicles 100/0"}));
  // The same input gives the same bytes.
  const std::string first = Read(folder.File("mine.roads.json"));
  MakeScenario(Here({"--roads", folder.File("village.osm"), "--out", folder.File("mine.json")}));
  EXPECT_EQ(Read(folder.File("mine.roads.json")), first);
  // A road file is taken as it is.
  MakeScenario(
      {"--roads", folder.File("mine.roads.json"), "--area", "1x1", "--out", folder.File("b.json")});
  EXPECT_EQ(Read(folder.File("b.roads.json")), first);
}

TEST(RoadsOption, SaysWhatCameOfIt) {
  if (!HasOgr()) GTEST_SKIP() << kNoOgr;
  const TemporaryFolder folder;
  Write(folder.File("village.osm"), kOsm);
  Scenario scenario;
  scenario.tasks = {{{100, 100}}, {{5000, 100}}};
  scenario.workers.resize(3);
  std::vector<std::string> said =
      Taken(folder.File("village.osm"), {10, 20}, 1000, 1000, &scenario);
  ASSERT_FALSE(said.empty());
  EXPECT_TRUE(said.back().starts_with("  prepared in ")) << said.back();
  said.pop_back();
  EXPECT_EQ(
      said,
      (std::vector<std::string>{
          "roads: village.osm: 3 lines, 3 of them roads, 3 in the area or within 1 km of it",
          "  barriers that stop vehicles: 1",
          "  0.7 km, 0.5 of them for vehicles, in 6 pieces; junctions: 1",
          "  workers: 1 of 2 tasks are within 1 km of a road, and 3 of 3 starts",
          "  vehicles: 0 of 0 charging points are within 1 km of a road, and 0 of 0 starts"}));
}

TEST(RoadsOption, ShapefileInMetresWithNamesInAnUnknownEncoding) {
  if (!HasOgr()) GTEST_SKIP() << kNoOgr;
  const TemporaryFolder folder;
  Write(folder.File("a.geojson"), R"({"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"fclass": "track", "oneway": "B", "name": "Rue XY"},
     "geometry":
     {"type": "LineString", "coordinates": [[20.001, 10.001], [20.0015, 10.001]]}}]})");
  const std::string make = fmt::format(
      "ogr2ogr -f 'ESRI Shapefile' -t_srs EPSG:3857 -lco ENCODING=UTF-8 {} {} 2>/dev/null",
      folder.File("a.shp"), folder.File("a.geojson"));
  ASSERT_EQ(std::system(make.c_str()), 0);
  std::string table = Read(folder.File("a.dbf"));
  table.replace(table.find("XY"), 2, "\xE9\xE8");
  Write(folder.File("a.dbf"), table);
  Scenario scenario;
  const auto said = Taken(folder.File("a.shp"), {10, 20}, 1000, 1000, &scenario);
  EXPECT_EQ(said[0], "roads: a.shp: 1 lines, 1 of them roads, 1 in the area or within 1 km of it");
  const Roads& roads = *scenario.roads->network;
  EXPECT_EQ(roads.source, "a.shp");
  ASSERT_EQ(roads.points.size(), 2U);
  EXPECT_NEAR(roads.points[0].x_mm, 109'640, 50);
  EXPECT_NEAR(roads.points[1].x_mm - roads.points[0].x_mm, 54'820, 50);
  // Without its .prj nobody knows that these are metres: as degrees they are too large.
  std::filesystem::remove(folder.File("a.prj"));
  const std::string error = ErrorOf([&] {
    Taken(folder.File("a.shp"), {10, 20}, 1000, 1000, &scenario);
  });
  EXPECT_NE(error.find("a.shp: feature 1: geometry.coordinates[0]: found [2226"), error.npos)
      << error;
}

TEST(RoadsOption, GeoJsonNeedsNoOtherProgram) {
  const TemporaryFolder folder;
  Write(folder.File("two.geojson"), R"({"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"highway": "track"}, "geometry":
     {"type": "LineString", "coordinates": [[20.001, 10.001], [20.002, 10.001]]}}]})");
  MakeScenario(Here({"--roads", folder.File("two.geojson"), "--roads-credit", "Town, CC0", "--out",
                     folder.File("mine.json")}));
  const Scenario scenario = LoadScenario(folder.File("mine.json"));
  EXPECT_EQ(scenario.roads->network->source, "two.geojson; Town, CC0");
  // 110.6 m and 109.6 m from the corner; one point in the middle, for steps of at most 100 m.
  const std::vector<RoadPoint>& points = scenario.roads->network->points;
  ASSERT_EQ(points.size(), 3U);
  EXPECT_NEAR(points[0].x_mm, 109'640, 30);
  EXPECT_NEAR(points[0].y_mm, 110'610, 30);
  EXPECT_NEAR(points[2].x_mm - points[0].x_mm, 109'640, 30);
}

TEST(RoadsOption, RefusesAndWritesNothing) {
  const TemporaryFolder folder;
  const std::string out = folder.File("mine.json");
  const auto error = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--out", out});
    std::string text = ErrorOf([&] { MakeScenario(arguments); });
    for (std::size_t at; (at = text.find(folder.path().string() + "/")) != text.npos;) {
      text.erase(at, folder.path().string().size() + 1);
    }
    return text;
  };
  const std::string line = R"({"type": "LineString", "coordinates": [[20, 10], [20.1, 10.1]]}})";
  Write(folder.File("river.geojson"),
        R"({"type": "Feature", "properties": {}, "geometry": )" + line);
  Write(folder.File("road.geojson"),
        R"({"type": "Feature", "properties": {"highway": "track"}, "geometry": )" + line);
  EXPECT_EQ(error(Here({"--roads", folder.File("river.geojson")})),
            "river.geojson: content: found 1 lines, none a road (1 without a highway tag), "
            "expected lines with a key highway (or fclass, or type) like residential");
  EXPECT_EQ(error({"--origin", "47,9", "--area", "10x10", "--roads", folder.File("road.geojson")}),
            "road.geojson: roads: found some between 10.00, 20.00 and 10.10, 20.10 only, expected "
            "some in the area, which is between 47.00, 9.00 and 47.09, 9.13");
  EXPECT_EQ(error({"--roads", folder.File("road.geojson")}),
            "command line: --origin: found none, expected LAT,LON of the area's south-west corner, "
            "to place the roads");
  EXPECT_EQ(error(Here({"--roads", folder.File("none.osm.pbf")})),
            "none.osm.pbf: cannot read roads from it: No such file or directory");
  EXPECT_EQ(error({"--roads-join", "1"}),
            "command line: --roads: found none, expected one with --roads-join");
  EXPECT_EQ(error({"--origin", "91,0"}),
            "command line: --origin: found '91,0', expected LAT,LON: degrees within 90 and 180, "
            "like 18.41,-72.47");
  EXPECT_EQ(error({"--roads", "x.roads.json", "--roads-join", "1"}),
            "command line: --roads-join: found it with a road file, expected it with a map");
  Write(folder.File("big.osm.pbf"), "");
  std::filesystem::resize_file(folder.File("big.osm.pbf"), kMostMapBytes + 1);
  EXPECT_EQ(error(Here({"--roads", folder.File("big.osm.pbf")})),
            "big.osm.pbf: cannot read roads from it: found 2000000001 bytes, expected at most "
            "2000000000: cut out the area first, as with osmium extract or ogr2ogr -spat");
  EXPECT_EQ(ErrorOf([&] {
              MakeScenario(Here({"--roads", folder.File("road.geojson")}));
            }),
            "command line: --out: found none, expected a file: a road file is written beside it");
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_FALSE(std::filesystem::exists(folder.File("mine.roads.json")));
}

TEST(RoadsOption, RefusesWhatOgrCannotRead) {
  if (!HasOgr()) GTEST_SKIP() << kNoOgr;
  const TemporaryFolder folder;
  const auto error = [&](const std::string& name, const std::string& text) {
    Write(folder.File(name), text);
    return ErrorOf([&] {
      MakeScenario(Here({"--roads", folder.File(name), "--out", folder.File("mine.json")}));
    });
  };
  const std::string osm = kOsm;
  for (const std::string& found :
       {error("cut.osm", osm.substr(0, osm.find("</osm>"))), error("words.osm", "words"),
        error("words.osm.pbf", "words"), error("map.shp", "words")}) {
    EXPECT_NE(found.find(": content: found what ogr2ogr cannot read ("), std::string::npos)
        << found;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.File("mine.json")));
}

TEST(RoadsOption, WithoutOgrItSaysWhatToInstall) {
  const TemporaryFolder folder;
  Write(folder.File("village.osm"), kOsm);
  const std::string path = std::getenv("PATH") == nullptr ? "" : std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  const std::string error = ErrorOf([&] {
    MakeScenario(Here({"--roads", folder.File("village.osm"), "--out", folder.File("mine.json")}));
  });
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(error, folder.File("village.osm") +
                       ": found no program ogr2ogr to read it, expected that of GDAL (apt-get "
                       "install gdal-bin)");
}

TEST(RoadsOption, PortAuPrince) {
  const std::string file = Shared("data/haiti2010_ushahidi/PortAuPrince_Roads.shp");
  if (!std::ifstream(file)) GTEST_SKIP() << "no " << file;
  if (!HasOgr()) GTEST_SKIP() << kNoOgr;
  Scenario scenario;
  const auto said = Taken(file, {18.4, -72.8}, 90'000, 40'000, &scenario);
  ASSERT_GE(said.size(), 4U);
  EXPECT_EQ(said[0],
            "roads: PortAuPrince_Roads.shp: 1583 lines, 1510 of them roads, 1510 in the area or "
            "within 1 km of it");
  EXPECT_EQ(said[1], "  not roads: 73 without a highway tag");
  // All 1510 have 1220.4 km.
  EXPECT_EQ(said[2], "  left out: 73 of 1510 roads are reachable from nowhere (in all 76.5 km)");
  EXPECT_TRUE(said[3].starts_with("  1144.0 km, ")) << said[3];
}

TEST(RoadsOption, Liechtenstein) {
  const std::string file = Shared("data/roads/liechtenstein-2013-08-03.osm.pbf");
  if (!std::ifstream(file)) GTEST_SKIP() << "no " << file;
  if (!HasOgr()) GTEST_SKIP() << kNoOgr;
  Scenario scenario;
  const auto said = Taken(file, {47.05, 9.47}, 20'000, 25'000, &scenario);
  ASSERT_GE(said.size(), 4U);
  EXPECT_EQ(said[0],
            "roads: liechtenstein-2013-08-03.osm.pbf: 2751 lines, 2740 of them roads, 2740 in the "
            "area or within 1 km of it");
  EXPECT_EQ(said[1], "  not roads: 8 closed to all, 3 construction");
  EXPECT_EQ(said[2], "  barriers that stop vehicles: 31");
}

}  // namespace
}  // namespace muster::tools
