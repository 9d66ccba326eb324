#include "tools/scenario/import.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <GeographicLib/Geodesic.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numeric>
#include <set>

#include "base/random.h"
#include "model/scenario_json.h"
#include "tests/error_of.h"
#include "tools/scenario/window.h"

namespace muster::tools {
namespace {

TEST(CsvTable, ReadsQuotesCommentsOfTheirOwnLinesAndBlanks) {
  const Table table = ParseCsv(
      "\xEF\xBB\xBFname,lat,lon\r\n"
      "\"a, \"\"b\"\"\nc\",1.5,2\r\n"
      "\r\n"
      "d,,NA\r\n"
      "e\r\n",
      "t.csv");
  EXPECT_EQ(table.columns, (std::vector<std::string>{"name", "lat", "lon"}));
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"a, \"b\"\nc", "1.5", "2"}));
  EXPECT_EQ(table.rows[1], (std::vector<std::string>{"d", "", "NA"}));
  EXPECT_EQ(table.rows[2], (std::vector<std::string>{"e", "", ""}));
}

TEST(CsvTable, FindsSemicolonsAndTabs) {
  EXPECT_EQ(ParseCsv("a;b\n1;2\n", "t").rows[0], (std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(ParseCsv("a\tb\n1\t2\n", "t").rows[0], (std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(ParseCsv("a,b\n1;2,3", "t").rows[0], (std::vector<std::string>{"1;2", "3"}));
}

TEST(CsvTable, RefusesWhatIsNoTable) {
  EXPECT_EQ(ErrorOf([] { ParseCsv("", "t.csv"); }),
            "t.csv: content: found nothing, expected a line of column names");
  EXPECT_NE(ErrorOf([] { ParseCsv("a,b\n\"1,2\n3,4\n", "t.csv"); }).find("t.csv: record 2: found"),
            std::string::npos);
  EXPECT_NE(ErrorOf([] { ParseCsv("a,b\n1,2\n5\" pipe,2\n", "t.csv"); }).find("t.csv: record 3: "),
            std::string::npos);
  EXPECT_EQ(ErrorOf([] { ParseCsv("a,b\n1,2\n1,2,3\n", "t.csv"); }),
            "t.csv: record 3: found 3 fields, expected 2 as in the first line");
  EXPECT_EQ(ErrorOf([] { ParseCsv("a,b\n", "t.csv").Column("c"); }),
            "t.csv: columns: found no column 'c', expected one of a, b");
}

TEST(CsvTable, GarbageEndsInAnInputErrorOrATable) {
  constexpr std::uint64_t kSeed = 3;
  const std::string text = "a,b\n\"x, \"\"y\",2\n3;4,\"5\"\n";
  for (std::uint32_t round = 0; round < 5000; ++round) {
    Random random(kSeed, Stream::kTest, round);
    std::string changed = text.substr(0, random.Below(static_cast<std::uint32_t>(text.size()) + 1));
    for (std::uint32_t i = random.Below(4); i > 0 && !changed.empty(); --i) {
      changed[random.Below(static_cast<std::uint32_t>(changed.size()))] =
          static_cast<char>(random.Below(256));
    }
    try {
      const Table table = ParseCsv(changed, "t");
      for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.columns.size()) << round;
    } catch (const InputError&) {
    }
  }
}

TEST(GeoJsonTable, PointsAreRowsAndPropertiesColumns) {
  const Table table = ParseGeoJson(R"({"type": "FeatureCollection", "features": [
      {"type": "Feature", "geometry": {"type": "Point", "coordinates": [7.25, 50.5, 12]},
       "properties": {"kind": "shelter", "beds": 40, "open": true, "more": {"a": 1}}},
      {"type": "Feature", "geometry": {"type": "LineString", "coordinates": [[7, 50], [8, 51]]},
       "properties": {"kind": "road"}},
      {"type": "Feature", "geometry": null, "properties": null},
      {"type": "Feature", "geometry": {"type": "Point", "coordinates": [-7, -50.25]},
       "properties": {"time": "2020-01-01T10:00:00Z", "latitude": 3}}]})",
                                   "t.geojson");
  EXPECT_EQ(table.columns, (std::vector<std::string>{"latitude", "longitude", "kind", "beds",
                                                     "open", "more", "time"}));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.not_points, 2u);
  EXPECT_EQ(table.rows[0],
            (std::vector<std::string>{"50.5", "7.25", "shelter", "40", "true", "", ""}));
  EXPECT_EQ(table.rows[1],
            (std::vector<std::string>{"-50.25", "-7", "", "", "", "", "2020-01-01T10:00:00Z"}));
}

TEST(GeoJsonTable, RefusesOtherJson) {
  EXPECT_NE(ErrorOf([] { ParseGeoJson("[1]", "t.json"); }).find("expected GeoJSON"),
            std::string::npos);
  EXPECT_NE(ErrorOf([] {
              ParseGeoJson(R"({"type": "Topology"})", "t.json");
            }).find("t.json: top level: found an object, expected GeoJSON"),
            std::string::npos);
  EXPECT_NE(ErrorOf([] { ParseGeoJson("{", "t.json"); }).find("t.json: line 1, column "),
            std::string::npos);
}

TEST(Window, ProjectionKeepsDistancesAndHidesOtherContinents) {
  const Origin corner = {18.4, -72.5};
  const Origin place = {18.6, -72.3};
  const std::vector<Point> points =
      Project({corner, place, {50.2, 5.7}, {22.3, 114.2}, {-18.4, 107.5}}, corner);
  EXPECT_NEAR(Distance(points[0], {0, 0}), 0, 1e-6);
  double geodesic_m = 0;
  GeographicLib::Geodesic::WGS84().Inverse(corner.latitude_deg, corner.longitude_deg,
                                           place.latitude_deg, place.longitude_deg, geodesic_m);
  EXPECT_NEAR(Distance(points[0], points[1]), geodesic_m, 0.5);  // of 30 km
  EXPECT_GT(points[1].x_m, 0);
  EXPECT_GT(points[1].y_m, 0);
  for (std::size_t i = 2; i < 5; ++i) EXPECT_FALSE(InWindow(points[i], 1e9, 1e9)) << i;
}

TEST(Window, DensestFindsTheClusterWhateverTheOutliers) {
  constexpr std::uint64_t kSeed = 8;
  Random random(kSeed, Stream::kTest);
  std::vector<Origin> places;
  for (int i = 0; i < 300; ++i) {  // 9 km by 9 km at most
    places.push_back({47 + random.Uniform(0, 0.08), 8 + random.Uniform(0, 0.115)});
  }
  for (int i = 0; i < 250; ++i) places.push_back({-33 + random.Uniform(0, 5), 151});
  for (int i = 0; i < 40; ++i) places.push_back({47 + random.Uniform(-2, 2), 8.5});
  const Window window = DensestWindow(places, 10'000, 10'000);
  EXPECT_GE(window.count, 300u);
  std::size_t inside = 0;
  for (const Point& p : Project(places, window.corner)) inside += InWindow(p, 10'000, 10'000);
  EXPECT_EQ(inside, window.count);
  std::reverse(places.begin(), places.end());
  const Window again = DensestWindow(places, 10'000, 10'000);
  EXPECT_EQ(again.corner.latitude_deg, window.corner.latitude_deg);
  EXPECT_EQ(again.corner.longitude_deg, window.corner.longitude_deg);
}

TEST(Window, DensestIsNotBeatenByAnyWindowOnAGrid) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed, Stream::kTest);
    std::vector<Origin> places;
    for (int i = 0; i < 200; ++i) {
      places.push_back({random.Uniform(10, 10.3), random.Uniform(20, 20.3)});
    }
    const Window best = DensestWindow(places, 7000, 4000);
    const std::vector<Point> points = Project(places, best.corner);
    for (int dx = -40; dx <= 40; ++dx) {
      for (int dy = -40; dy <= 40; ++dy) {
        std::size_t count = 0;
        for (const Point& p : points) {
          count += InWindow({p.x_m - dx * 800.0, p.y_m - dy * 800.0}, 7000, 4000);
        }
        // 100 m squares: a place may be cut off at an edge.
        EXPECT_LE(count, best.count + 1) << "seed " << seed << " at " << dx << ", " << dy;
      }
    }
  }
}

TEST(Window, OfEquallyDenseOnesTheSouthernThenTheWestern) {
  // Pairs of places, each pair in a window of its own, and one place alone in the south-west.
  std::vector<Origin> places = {{10.01, 20.01}};
  for (const auto& [north, east] : {std::pair{10.5, 20.2}, {10.2, 20.7}, {10.2, 20.4}}) {
    places.push_back({north, east});
    places.push_back({north + 0.01, east + 0.01});
  }
  const Window window = DensestWindow(places, 5000, 4000);
  EXPECT_EQ(window.count, 2u);
  EXPECT_NEAR(window.corner.latitude_deg, 10.2, 0.002);
  EXPECT_NEAR(window.corner.longitude_deg, 20.4, 0.002);
}

/// A table of places given in km from 10 N 20 E.
std::string CsvOf(const std::vector<std::pair<double, double>>& km, const std::string& rest = "") {
  std::string text = "lat,lon,kind,when\n";
  for (const auto& [x, y] : km) {
    text += fmt::format("{:.7f},{:.7f}{}\n", 10 + y / 110.61, 20 + x / 109.64,
                        rest.empty() ? ",a," : rest);
  }
  return text;
}

ImportRequest SmallRequest() {
  ImportRequest request;
  request.settings.width_km = 5;
  request.settings.height_km = 4;
  request.settings.uavs = request.settings.workers = request.settings.vehicles = 4;
  request.settings.tasks = 2;
  request.settings.charging_points = 2;
  request.window = ImportWindow{{10, 20}, 5, 4};
  return request;
}

TEST(Import, TasksAreTheFullestCellsAndChargingPointsTheNext) {
  // Cells (column, row): (1, 2) has 3 rows, (4, 0) 2, (0, 3) and (2, 3) one each, one outside.
  const std::string csv = CsvOf({{1.2, 2.5},
                                 {1.5, 2.6},
                                 {1.9, 2.2},
                                 {4.5, 0.5},
                                 {4.4, 0.7},
                                 {2.5, 3.5},
                                 {0.5, 3.5},
                                 {5.5, 1.0}});
  const ImportResult result = Import(ParseCsv(csv, "t.csv"), SmallRequest());
  const Scenario& s = result.scenario;
  ASSERT_EQ(s.tasks.size(), 2u);
  EXPECT_EQ(s.tasks[0].at, (Point{1500, 2500}));
  EXPECT_EQ(s.tasks[1].at, (Point{4500, 500}));
  EXPECT_EQ(s.tasks[0].cost_m, 3000);
  ASSERT_EQ(s.charging_points.size(), 2u);
  EXPECT_EQ(s.charging_points[0].at, (Point{500, 3500}));  // tie: the western first
  EXPECT_EQ(s.charging_points[1].at, (Point{2500, 3500}));
  EXPECT_EQ(s.origin->latitude_deg, 10);
  EXPECT_EQ(s.origin->longitude_deg, 20);
  EXPECT_EQ(s.width_m, 5000);
  EXPECT_EQ(s.height_m, 4000);
  const std::set<std::pair<double, double>> cells = {
      {1500, 2500}, {4500, 500}, {500, 3500}, {2500, 3500}};
  for (const AgentKind kind : kAgentKinds) {
    EXPECT_EQ(s.agents(kind).size(), 4u);
    for (const AgentSpec& agent : s.agents(kind)) {
      EXPECT_TRUE(cells.contains({agent.at.x_m, agent.at.y_m}));
    }
  }
  EXPECT_EQ(ScenarioToJson(s),
            ScenarioToJson(Import(ParseCsv(csv, "t.csv"), SmallRequest()).scenario));
}

std::string Joined(const std::vector<std::string>& lines) {
  return fmt::format("{}\n", fmt::join(lines, "\n"));
}

TEST(Import, CountsAndReportsWhatItLeavesOut) {
  std::string csv = CsvOf({{0.5, 0.5}, {1.5, 0.5}, {2.5, 0.5}, {3.5, 0.5}});
  csv += "NA,20.01,a,\n,20.01,a,\n10.01,nil,a,\n95,20,a,\n10.01,20.01,b,\n";
  ImportRequest request = SmallRequest();
  request.where = {ParseFilter("--where", "kind=a")};
  const std::string summary = Joined(Import(ParseCsv(csv, "t.csv"), request).summary);
  for (const char* part :
       {"t.csv: 9 rows; place: lat, lon\n", "  1 rows not with kind=a\n",
        "  2 rows left out: no place (NA or blank)\n",
        "  2 rows left out: a place that is no degrees\n", "(as given): 4 of 4 places\n",
        "tasks: 2 of 2 wanted, cells with 1 to 1 rows; 4 rows are in 4 cells\n",
        "times: none; uptimes are drawn\n"}) {
    EXPECT_NE(summary.find(part), std::string::npos) << part << "\nin\n" << summary;
  }
}

TEST(Import, RolesHaveTheirOwnRowsAndColumns) {
  std::string csv = "lat,lon,kind,to_lat,to_lon\n";
  const auto row = [&](double x, double y, const char* kind, double to_x, double to_y) {
    csv += fmt::format("{:.7f},{:.7f},{},{:.7f},{:.7f}\n", 10 + y / 110.61, 20 + x / 109.64, kind,
                       10 + to_y / 110.61, 20 + to_x / 109.64);
  };
  row(0.5, 0.5, "hurt", 4.5, 3.5);
  row(1.5, 0.5, "hurt;fire", 4.5, 3.5);
  row(2.5, 0.5, "shelter", 4.5, 2.5);
  ImportRequest request = SmallRequest();
  request.tasks.where = {ParseFilter("--tasks-where", "kind=hurt")};
  request.charging.where = {ParseFilter("--charging-where", "kind=shel*")};
  request.agents.at = {"to_lat", "to_lon"};
  request.settings.workers = 50;
  const ImportResult result = Import(ParseCsv(csv, "t.csv"), request);
  const Scenario& s = result.scenario;
  ASSERT_EQ(s.tasks.size(), 2u);
  EXPECT_EQ(s.tasks[0].at, (Point{500, 500}));
  EXPECT_EQ(s.tasks[1].at, (Point{1500, 500}));
  ASSERT_EQ(s.charging_points.size(), 1u);  // 2 wanted, 1 cell
  EXPECT_EQ(s.charging_points[0].at, (Point{2500, 500}));
  EXPECT_NE(Joined(result.summary).find("charging points: 1 of 2 wanted"), std::string::npos);
  std::set<double> rows;
  for (const AgentSpec& worker : s.workers) {
    EXPECT_EQ(worker.at.x_m, 4500);
    rows.insert(worker.at.y_m);
  }
  EXPECT_EQ(rows, (std::set<double>{2500, 3500}));
}

TEST(Import, ChargingPointsShareCellsWithTasksOnlyWhenTheyMust) {
  const std::string csv = CsvOf({{0.5, 0.5}, {0.5, 0.5}, {1.5, 0.5}, {2.5, 0.5}});
  ImportRequest request = SmallRequest();
  const ImportResult result = Import(ParseCsv(csv, "t.csv"), request);
  ASSERT_EQ(result.scenario.charging_points.size(), 2u);
  EXPECT_EQ(result.scenario.charging_points[0].at, (Point{2500, 500}));
  EXPECT_EQ(result.scenario.charging_points[1].at, (Point{500, 500}));
  EXPECT_NE(Joined(result.summary).find("charging points: 2 of 2 wanted, 1 in cells of tasks"),
            std::string::npos);
}

TEST(Import, AgentsComeOnlineAtTheirRowsPartOfThePeriod) {
  // Mission 10:00-13:00 as given; rows at its start, its middle, outside it and without a time.
  std::string csv = CsvOf({{0.5, 0.5}}, ",a,2020-01-01 10:00") +
                    CsvOf({{1.5, 0.5}}, ",a,02/01/2020 11:30").substr(18) +
                    CsvOf({{2.5, 0.5}}, ",a,2020-01-01 13:00").substr(18) +
                    CsvOf({{3.5, 0.5}}, ",a,NA").substr(18);
  ImportRequest request = SmallRequest();
  request.time = "when";
  request.start = TimeOfDay("10:00");
  request.settings.workers = 40;
  ImportResult result = Import(ParseCsv(csv, "t.csv"), request);
  EXPECT_NE(
      Joined(result.summary)
          .find("times: when, time of day; the mission is 10:00-13:00 (as given): 2 of 4 rows, "
                "1 without a time"),
      std::string::npos)
      << Joined(result.summary);
  std::set<std::pair<double, TimeUs>> seen;
  for (const AgentSpec& worker : result.scenario.workers) {
    seen.insert({worker.at.x_m, worker.online_from_us});
    EXPECT_EQ(worker.online_until_us - worker.online_from_us, 60 * kMinuteUs);
  }
  EXPECT_EQ(seen, (std::set<std::pair<double, TimeUs>>{{500, 0}, {1500, 60 * kMinuteUs}}));

  request.settings.uptime = Uptime::kAnyTime;
  result = Import(ParseCsv(csv, "t.csv"), request);
  for (const AgentSpec& worker : result.scenario.workers) {
    EXPECT_EQ(worker.online_from_us, worker.at.x_m == 500 ? 0 : 90 * kMinuteUs);
  }
}

TEST(Import, TheBusiestPeriodMayPassMidnight) {
  std::string csv = CsvOf({{0.5, 0.5}}, ",a,23:30") + CsvOf({{1.5, 0.5}}, ",a,00:30").substr(18) +
                    CsvOf({{2.5, 0.5}}, ",a,01:25").substr(18) +
                    CsvOf({{3.5, 0.5}}, ",a,12:00").substr(18);
  ImportRequest request = SmallRequest();
  request.time = "when";
  const ImportResult result = Import(ParseCsv(csv, "t.csv"), request);
  EXPECT_NE(Joined(result.summary).find("the mission is 22:30-01:30 (the busiest): 3 of 4 rows"),
            std::string::npos)
      << Joined(result.summary);
}

std::string CsvOfTimes(const std::vector<std::string>& times) {
  std::string csv = "lat,lon,kind,when\n";
  for (std::size_t i = 0; i < times.size(); ++i) {
    csv += CsvOf({{static_cast<double>(i % 4) + 0.5, 0.5}}, ",a," + times[i]).substr(18);
  }
  return csv;
}

TEST(Import, TheScenariosStartIsThatOfTheDayWithMostRows) {
  const auto start = [](const std::vector<std::string>& times, auto&& change) {
    ImportRequest request = SmallRequest();
    request.time = "when";
    change(&request);
    const ImportResult result = Import(ParseCsv(CsvOfTimes(times), "t.csv"), request);
    const auto& moment = result.scenario.start;
    const std::string text = moment ? moment->text : "none";
    EXPECT_EQ(Joined(result.summary).find("start: " + text) != std::string::npos,
              moment.has_value() && !request.start_moment);
    return text;
  };
  const auto as_it_is = [](ImportRequest*) {};
  const auto at_10 = [](ImportRequest* r) { r->start = TimeOfDay("10:00"); };
  const auto at_22 = [](ImportRequest* r) { r->start = TimeOfDay("22:00"); };
  const auto in_haiti = [](ImportRequest* r) { r->offset_min = -300; };
  EXPECT_EQ(
      start({"2010-01-16T10:30:00-05:00", "2010-01-17T10:30:00-05:00", "2010-01-17T11:30:00-05:00"},
            at_10),
      "2010-01-17T10:00:00-05:00");
  // The first of two such days.
  EXPECT_EQ(start({"2010-01-17T10:30:00Z", "2010-01-16T10:30:00Z"}, at_10),
            "2010-01-16T10:00:00+00:00");
  // What is after midnight belongs to the mission of the day before.
  EXPECT_EQ(start({"2010-01-16T23:00:00Z", "2010-01-17T00:30:00Z", "2010-01-18T00:10:00Z"}, at_22),
            "2010-01-16T22:00:00+00:00");
  EXPECT_EQ(start({"2010-01-16 10:00", "2010-01-16 12:55"}, as_it_is), "none");
  EXPECT_EQ(start({"2010-01-16 10:00", "2010-01-16 12:55"}, in_haiti), "2010-01-16T10:00:00-05:00");
  EXPECT_EQ(start({"05/07/2010 10:00", "28/07/2010 12:55", "05/07/2010 10:00"}, in_haiti),
            "2010-07-05T10:00:00-05:00");
  EXPECT_EQ(start({"05/07/2010 10:00", "05/07/2010 12:55"}, in_haiti), "none");
  // 1263654000 is 15:00 UTC of 2010-01-16, 10:00 in Haiti; the other is 2 h 59 min later.
  EXPECT_EQ(start({"1263654000", "1263664740"}, as_it_is), "2010-01-16T15:00:00+00:00");
  EXPECT_EQ(start({"1263654000", "1263664740"}, in_haiti), "2010-01-16T10:00:00-05:00");
  EXPECT_EQ(start({"2020-02-02 09:30", "2020-02-02 10:30"},
                  [](ImportRequest* r) {
                    r->start_moment = ParseMoment("2010-01-16T09:00:00-05:00");
                    r->start = TimeOfDay("9:00");
                    r->offset_min = -300;
                  }),
            "2010-01-16T09:00:00-05:00");
}

TEST(Import, TurnsAShapeThatFitsBetterTheOtherWay) {
  std::vector<std::pair<double, double>> north;
  for (int i = 0; i < 20; ++i) north.emplace_back(0.5, i);  // 20 km long, to the north
  ImportRequest request = SmallRequest();
  request.window.reset();
  request.settings.width_km = 22;
  request.settings.height_km = 6;
  EXPECT_EQ(Import(ParseCsv(CsvOf(north), "t"), request).scenario.width_m, 22'000);
  request.may_turn = true;
  const Scenario s = Import(ParseCsv(CsvOf(north), "t"), request).scenario;
  EXPECT_EQ(s.width_m, 6000);
  EXPECT_EQ(s.height_m, 22'000);
}

TEST(Import, SaysWhatIsMissing) {
  const auto error = [](const std::string& csv, const auto& change) {
    return ErrorOf([&] {
      ImportRequest request = SmallRequest();
      change(request);
      Import(ParseCsv(csv, "t.csv"), request);
    });
  };
  const std::string good = CsvOf({{0.5, 0.5}});
  EXPECT_EQ(error(good, [](ImportRequest&) {}), "");
  EXPECT_EQ(error("a,b\n1,2\n", [](ImportRequest&) {}),
            "t.csv: columns: found a, b, expected a latitude (name its column with --lat)");
  EXPECT_EQ(error(good, [](ImportRequest& r) { r.longitude = "lng"; }),
            "t.csv: columns: found no column 'lng', expected one of lat, lon, kind, when");
  EXPECT_EQ(error(good,
                  [](ImportRequest& r) {
                    r.where = {{"sort", {"a"}}};
                  }),
            "t.csv: columns: found no column 'sort', expected one of lat, lon, kind, when");
  EXPECT_EQ(error(good,
                  [](ImportRequest& r) {
                    r.where = {{"kind", {"b"}}};
                  }),
            "t.csv: rows: found no usable place with kind=b, expected at least one");
  EXPECT_EQ(
      error(good,
            [](ImportRequest& r) {
              r.tasks.where = {{"kind", {"b"}}};
            }),
      "t.csv: rows: found none in the window for the tasks with kind=b, expected at least one");
  EXPECT_EQ(error(good, [](ImportRequest& r) { r.time = "when"; }),
            "t.csv: when: found no time of day in any row, expected clock times "
            "(H:MM, H:MM:SS.fff), ISO 8601, Unix seconds or ms");
  EXPECT_EQ(
      error(good,
            [](ImportRequest& r) {
              r.agents.where = {{"kind", {"b"}}};
            }),
      "t.csv: rows: found none in the window for the agents with kind=b, expected at least one");
  EXPECT_EQ(error("lat,lon\n", [](ImportRequest&) {}),
            "t.csv: rows: found no usable place, expected at least one");
}

std::string Shared(const std::string& path) {
  const char* root = std::getenv("MUSTER_SHARED");
  return (root != nullptr ? std::string(root) : std::string(MUSTER_SHARED_DEFAULT)) + "/" + path;
}

struct RealCase {
  const char* file;
  const char* shape;
  std::size_t least_in_window;  ///< of the window that the data's README names
  double width_km, height_km;
};

class RealData : public ::testing::TestWithParam<RealCase> {};

TEST_P(RealData, GivesAFullScenario) {
  const RealCase& real = GetParam();
  const std::string file = Shared(std::string("data/") + real.file);
  if (!std::ifstream(file)) GTEST_SKIP() << "no " << file;
  ImportRequest request;
  request.settings = PresetByName(real.shape);
  request.may_turn = true;
  const Table table = ReadTable(file);
  const ImportResult result = Import(table, request);
  const Scenario& s = result.scenario;
  EXPECT_EQ(s.width_m, KmToM(real.width_km));
  EXPECT_EQ(s.height_m, KmToM(real.height_km));
  EXPECT_EQ(s.tasks.size(), static_cast<std::size_t>(request.settings.tasks));
  EXPECT_EQ(s.charging_points.size(), static_cast<std::size_t>(request.settings.charging_points));
  EXPECT_EQ(s.uavs.size(), static_cast<std::size_t>(request.settings.uavs));
  std::vector<Origin> places;
  const std::size_t lat = table.Column(*table.FirstOf({"latitude", "lat", "start_lat"}));
  const std::size_t lon = table.Column(*table.FirstOf({"longitude", "lng", "start_lng"}));
  for (const auto& row : table.rows) places.push_back({std::stod(row[lat]), std::stod(row[lon])});
  std::size_t inside = 0;
  for (const Point& p : Project(places, *s.origin)) inside += InWindow(p, s.width_m, s.height_m);
  EXPECT_GE(inside, real.least_in_window);
  EXPECT_EQ(ScenarioToJson(ParseScenario(ScenarioToJson(s), "again")), ScenarioToJson(s));
}

INSTANTIATE_TEST_SUITE_P(
    All, RealData,
    ::testing::Values(RealCase{"haiti2010_ushahidi/haiti_reports.csv", "Random_1", 2568, 30, 30},
                      RealCase{"nyc_citibike_202409/citibike.csv", "BicycleOrder", 9968, 16, 25},
                      RealCase{"shenzhen_taxi_orders/taxi-price.csv", "DidiOrders", 4572, 10, 9},
                      RealCase{"shenzhen_taxi_orders/taxi-price.csv", "TaxiTrajectories", 9657, 30,
                               30}),
    [](const auto& real) { return fmt::format("{}_{}", real.param.shape, real.index); });

}  // namespace
}  // namespace muster::tools
