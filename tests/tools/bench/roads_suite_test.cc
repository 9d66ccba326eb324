#include "tools/bench/roads_suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

#include "base/check.h"
#include "model/generator.h"
#include "model/made_up.h"
#include "tests/temporary_folder.h"
#include "tools/files/scenario_file.h"

namespace muster::tools {
namespace {

Scenario OnStreets(std::uint64_t seed) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.name = "streets";
  settings.width_km = settings.height_km = 10;
  settings.uavs = 5;
  settings.workers = 6;
  settings.vehicles = 4;
  settings.tasks = 20;
  settings.charging_points = 3;
  settings.rules.limit_us = 60 * kMinuteUs;
  Scenario scenario = Generate(settings, seed);
  ScenarioRoads roads;
  roads.file = "streets-" + std::to_string(seed) + ".roads.json";
  roads.text = RoadsToJson(StreetGrid(9, 1100, seed));
  roads.open_ground = {{}, {50, 1000}, {25, 1000}};
  UseRoads(std::move(roads), "streets", &scenario);
  return scenario;
}

/// The share of the roads' length, by the test's own sum in metres.
double PercentClosed(const Scenario& scenario, const std::vector<ClosedPlace>& places) {
  const Roads& roads = *scenario.roads->network;
  std::set<std::int32_t> closed;
  for (const ClosedPlace& place : places) {
    for (const std::int32_t road : RoadsIn(roads, {place.circle})) closed.insert(road);
  }
  double all_m = 0, closed_m = 0;
  for (std::size_t i = 0; i < roads.roads.size(); ++i) {
    double m = 0;
    const auto& points = roads.roads[i].points;
    for (std::size_t p = 1; p < points.size(); ++p) {
      const RoadPoint a = roads.points[static_cast<std::size_t>(points[p - 1])];
      const RoadPoint b = roads.points[static_cast<std::size_t>(points[p])];
      m += std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm) / 1000;
    }
    all_m += m;
    if (closed.contains(static_cast<std::int32_t>(i))) closed_m += m;
  }
  return 100 * closed_m / all_m;
}

TEST(RoadsSuite, ClosesAsMuchAsIsAskedAndNoPlaceMore) {
  const Scenario scenario = OnStreets(3);
  const auto some = DrawClosedPlaces(scenario, 5), many = DrawClosedPlaces(scenario, 20);
  for (const auto& [places, percent] : {std::pair(some, 5.0), std::pair(many, 20.0)}) {
    ASSERT_FALSE(places.empty());
    EXPECT_GE(PercentClosed(scenario, places), percent);
    EXPECT_LT(PercentClosed(scenario, {places.begin(), places.end() - 1}), percent);
    for (const ClosedPlace& place : places) {
      EXPECT_GE(place.from_us, 0);
      EXPECT_LT(place.from_us, 30 * kMinuteUs);
    }
  }
  ASSERT_LT(some.size(), many.size());
  for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(some[i].from_us, many[i].from_us);
  EXPECT_TRUE(DrawClosedPlaces(scenario, 0).empty());
}

TEST(RoadsSuite, KnownAndUnknownCloseTheSameRoads) {
  const Scenario scenario = OnStreets(3);
  const auto places = DrawClosedPlaces(scenario, 20);
  const ClosedMission known = WithClosedRoads(scenario, places, true);
  const ClosedMission unknown = WithClosedRoads(scenario, places, false);
  EXPECT_TRUE(known.hidden.empty());
  EXPECT_TRUE(unknown.scenario.roads->closures.empty());
  ASSERT_EQ(known.scenario.roads->closures.size(), places.size());
  ASSERT_EQ(unknown.hidden.size(), places.size());
  std::set<std::string> faults;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PlannedClosure& planned = known.scenario.roads->closures[i];
    const world::HiddenClosure& hidden = unknown.hidden[i];
    EXPECT_EQ(planned.from_us, hidden.from_us);
    EXPECT_EQ(planned.until_us, hidden.until_us);
    EXPECT_EQ(RoadAreaToJson(planned.area), RoadAreaToJson(std::get<RoadArea>(hidden.of)));
    faults.insert(hidden.fault);
  }
  EXPECT_EQ(faults.size(), places.size());
}

TEST(RoadsSuite, FliesEachMissionByRoadInStraightLinesAndWithClosedRoads) {
  const TemporaryFolder folder;
  BenchOptions options;
  options.methods = {"certified", "certified-without-roads"};
  options.closed_percent = {20};
  for (const std::uint64_t seed : {1, 2}) {
    options.scenarios.push_back(folder.File("streets-" + std::to_string(seed) + ".json"));
    WriteScenarioFile(OnStreets(seed), options.scenarios.back());
  }
  std::vector<RoadsRow> rows;
  RunRoads(options, [&](const RoadsRow& row) { rows.push_back(row); });
  ASSERT_EQ(rows.size(), 16u);
  std::map<std::string, int> done;
  std::set<std::tuple<std::uint64_t, std::string, std::string>> flown;
  for (const RoadsRow& row : rows) {
    EXPECT_EQ(row.places, "streets");
    EXPECT_EQ(row.tasks, 20);
    EXPECT_EQ(row.closed_percent, row.ways == "road" || row.ways == "straight" ? 0 : 20);
    flown.insert({row.seed, row.policy, row.ways});
    if (row.policy == "certified") done[row.ways] += row.done;
    const std::string line = ToCsv(row), header = RoadsCsvHeader();
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
  }
  EXPECT_EQ(flown.size(), 16u);
  EXPECT_GT(done["straight"], done["road"]);
  EXPECT_GT(done["road"], done["known"]);
  EXPECT_GT(done["unknown"], 0);
}

TEST(RoadsSuite, RefusesAScenarioWithoutRoadsBeforeTheFirstMission) {
  const TemporaryFolder folder;
  BenchOptions options;
  options.scenarios = {folder.File("streets.json"), folder.File("plain.json")};
  WriteScenarioFile(OnStreets(1), options.scenarios[0]);
  WriteScenarioFile(Generate(PresetByName("Random_1"), 1), options.scenarios[1]);
  try {
    RunRoads(options, [](const RoadsRow&) { ADD_FAILURE() << "flown"; });
    ADD_FAILURE() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("plain.json"), std::string::npos) << error.what();
  }
}

RoadsRow Row(std::uint64_t seed, const std::string& ways, const std::string& policy, int done) {
  return {"haiti", seed, ways, ways == "known" ? 20.0 : 0, policy, 10, done};
}

TEST(RoadsTables, HoldMeansByRoadAndPairedDifferencesToThem) {
  const std::string summary = SummaryOf({
      Row(1, "road", "horizon", 6),
      Row(1, "straight", "horizon", 8),
      Row(1, "known", "horizon", 5),
      Row(2, "road", "horizon", 8),
      Row(2, "straight", "horizon", 8),
      Row(2, "known", "horizon", 3),
      Row(1, "road", "horizon-without-roads", 4),
      Row(1, "known", "horizon-without-roads", 1),
      Row(2, "road", "horizon-without-roads", 2),
      Row(2, "known", "horizon-without-roads", 3),
  });
  EXPECT_NE(
      summary.find("| places | policy | by road, % | in straight lines | 20 % closed, known |"),
      std::string::npos)
      << summary;
  // Differences of 20 and 0, of -10 and -50.
  EXPECT_NE(summary.find("| haiti | `horizon` | 70.0 | +10.0 \u00b1 10.0 | -30.0 \u00b1 20.0 |\n"),
            std::string::npos)
      << summary;
  // Less horizon: -20 and -60; with closed roads -40 and 0.
  EXPECT_NE(summary.find("| haiti | `horizon` | -40.0 \u00b1 20.0 | -20.0 \u00b1 20.0 |\n"),
            std::string::npos)
      << summary;
}

}  // namespace
}  // namespace muster::tools
