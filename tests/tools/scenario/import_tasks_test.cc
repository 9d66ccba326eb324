// Tasks of imported rows: when they are reported, how much they matter, what they are called.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <tuple>

#include "base/check.h"
#include "model/scenario_json.h"
#include "tests/temporary_folder.h"
#include "tools/scenario/import.h"
#include "tools/scenario/import_command.h"

namespace muster::tools {
namespace {

/// A row at so many km from 10 N 20 E.
std::string RowAt(double x_km, double y_km, const std::string& rest) {
  return fmt::format("{:.7f},{:.7f},{}\n", 10 + y_km / 110.61, 20 + x_km / 109.64, rest);
}

constexpr const char* kHead = "lat,lon,when,urgency,what,ref\n";

ImportRequest ReportsRequest() {
  ImportRequest request;
  request.settings.width_km = 5;
  request.settings.height_km = 4;
  request.settings.uavs = request.settings.workers = request.settings.vehicles = 2;
  request.settings.tasks = 10;
  request.settings.charging_points = 1;
  request.window = ImportWindow{{10, 20}, 5, 4};
  request.time = "when";
  request.start = TimeOfDay("10:00");
  request.are_reports = true;
  return request;
}

std::string ErrorOfImport(const std::string& csv, const ImportRequest& request) {
  try {
    Import(ParseCsv(csv, "t.csv"), request);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Priorities, AreNumbersOrWords) {
  EXPECT_EQ(PriorityOf("0"), Priority::kLow);
  EXPECT_EQ(PriorityOf(" 3 "), Priority::kEmergency);
  EXPECT_EQ(PriorityOf("2.0"), Priority::kHigh);
  EXPECT_EQ(PriorityOf("Normal"), Priority::kNormal);
  EXPECT_EQ(PriorityOf("EMERGENCY"), Priority::kEmergency);
  for (const char* bad : {"", "4", "-1", "1.5", "urgent", "1 high"}) {
    EXPECT_EQ(PriorityOf(bad), std::nullopt) << bad;
  }
}

TEST(ImportTasks, RowsBecomeReportsInTheOrderOfTheirTimes) {
  const std::string csv = kHead + RowAt(0.2, 0.5, "2020-05-02T11:30:00Z,high,School,A-2") +
                          RowAt(1.2, 0.5, "2020-05-01 10:00,0,,A-1") +
                          RowAt(1.4, 0.6, "1588336200,,Bridge,") +  // 1 May 2020, 12:30 UTC
                          RowAt(2.5, 0.5, "13:00,3,too late,") + RowAt(3.5, 0.5, "NA,3,no time,");
  ImportRequest request = ReportsRequest();
  request.priority = "urgency";
  request.task_name = "what";
  request.external_id = "ref";
  request.task_note = "what";
  request.settings.due_min = {Always(60), Always(40), Always(20), Always(10)};
  const ImportResult result = Import(ParseCsv(csv, "t.csv"), request);
  const std::vector<Task>& tasks = result.scenario.tasks;
  ASSERT_EQ(tasks.size(), 3u);
  EXPECT_EQ(tasks[0].at, (Point{1500, 500}));
  EXPECT_EQ(tasks[0].reported_us, 0);
  EXPECT_EQ(tasks[0].priority, Priority::kLow);
  EXPECT_EQ(tasks[0].name, "");
  EXPECT_EQ(tasks[0].external_id, "A-1");
  EXPECT_EQ(tasks[0].due_us, 60 * kMinuteUs);
  EXPECT_EQ(tasks[1].at, (Point{500, 500}));
  EXPECT_EQ(tasks[1].reported_us, 90 * kMinuteUs);
  EXPECT_EQ(tasks[1].priority, Priority::kHigh);
  EXPECT_EQ(tasks[1].name, "School");
  EXPECT_EQ(tasks[1].note, "School");
  EXPECT_EQ(tasks[1].due_us, 110 * kMinuteUs);
  EXPECT_EQ(tasks[2].at, (Point{1500, 500}));  // as tasks[0]: each row is one
  EXPECT_EQ(tasks[2].reported_us, 150 * kMinuteUs);
  EXPECT_EQ(tasks[2].priority, Priority::kNormal);
  const std::string summary = fmt::format("{}", fmt::join(result.summary, "\n"));
  for (const char* part : {"times of tasks: when, time of day; the mission is 10:00-13:00 (as "
                           "given): 3 of 5 rows, 1 without a time",
                           "tasks: 3 of 10 wanted, each one of 3 rows, reported at its time; in 2 "
                           "cells"}) {
    EXPECT_NE(summary.find(part), std::string::npos) << summary;
  }
  EXPECT_EQ(ScenarioToJson(ParseScenario(ScenarioToJson(result.scenario), "again")),
            ScenarioToJson(result.scenario));
  request.settings.placement = Placement::kContinuous;
  const Point at = Import(ParseCsv(csv, "t.csv"), request).scenario.tasks[1].at;
  EXPECT_NEAR(at.x_m, 200, 2);
  EXPECT_NEAR(at.y_m, 500, 2);
}

TEST(ImportTasks, MoreTasksAreTheSameAndOthers) {
  std::string csv = kHead;
  for (int i = 0; i < 200; ++i) {
    csv += RowAt(0.01 + 0.024 * i, 0.5, fmt::format("10:{:02}:{:02},1,,{}", i / 4, i % 4, i));
  }
  ImportRequest request = ReportsRequest();
  request.external_id = "ref";
  std::set<std::string> before;
  for (const int tasks : {10, 40, 200}) {
    request.settings.tasks = tasks;
    std::set<std::string> ids;
    for (const Task& task : Import(ParseCsv(csv, "t.csv"), request).scenario.tasks) {
      ids.insert(task.external_id);
    }
    EXPECT_EQ(ids.size(), static_cast<std::size_t>(tasks));
    EXPECT_TRUE(std::includes(ids.begin(), ids.end(), before.begin(), before.end()));
    before = ids;
  }
}

TEST(ImportTasks, TheirBusiestPeriodIsTheMissions) {
  std::string csv = kHead + RowAt(0.5, 0.5, "20:00,1,task,") + RowAt(1.5, 0.5, "20:30,1,task,");
  for (int i = 0; i < 9; ++i) csv += RowAt(2.5, 0.5, "8:00,1,agent,");
  csv += RowAt(2.5, 1.5, "20:10,1,agent,");
  ImportRequest request = ReportsRequest();
  request.start.reset();
  request.tasks.where = {ParseFilter("--tasks-where", "what=task")};
  request.agents.where = {ParseFilter("--agents-where", "what=agent")};
  const Scenario s = Import(ParseCsv(csv, "t.csv"), request).scenario;
  ASSERT_EQ(s.tasks.size(), 2u);
  EXPECT_EQ(s.tasks[1].reported_us - s.tasks[0].reported_us, 30 * kMinuteUs);
  for (const AgentSpec& worker : s.workers) EXPECT_EQ(worker.at, (Point{2500, 1500}));
}

TEST(ImportTasks, ACellsTaskIsItsMostUrgentRow) {
  const std::string csv = kHead + RowAt(0.5, 0.5, "10:00,,first,") +
                          RowAt(0.5, 0.5, "10:00,high,second,") +
                          RowAt(0.5, 0.5, "10:00,high,third,") + RowAt(1.5, 0.5, "10:00,,fourth,");
  ImportRequest request = ReportsRequest();
  request.are_reports = false;
  request.priority = "urgency";
  request.task_name = "what";
  request.settings.priority_shares = {1, 0, 0, 0};
  const std::vector<Task> tasks = Import(ParseCsv(csv, "t.csv"), request).scenario.tasks;
  ASSERT_EQ(tasks.size(), 2u);
  EXPECT_EQ(tasks[0].priority, Priority::kHigh);
  EXPECT_EQ(tasks[0].name, "second");
  EXPECT_EQ(tasks[0].reported_us, 0);
  EXPECT_EQ(tasks[1].priority, Priority::kLow);  // drawn
  EXPECT_EQ(tasks[1].name, "fourth");
}

TEST(ImportTasks, SaysWhatIsWrong) {
  const std::string csv = kHead + RowAt(0.5, 0.5, "10:00,1,,") + RowAt(0.5, 0.5, "10:00,soon,,");
  ImportRequest request = ReportsRequest();
  request.priority = "urgency";
  const std::string message =
      "t.csv: record 3, column urgency: found 'soon', expected a priority: 0 to 3, or low, normal, "
      "high or emergency";
  EXPECT_EQ(ErrorOfImport(csv, request), message);
  request.settings.tasks = 1;  // also when the row would not be drawn
  EXPECT_EQ(ErrorOfImport(csv, request), message);
  request.are_reports = false;
  EXPECT_EQ(ErrorOfImport(csv, request), message);
  request.priority = "prio";
  EXPECT_EQ(ErrorOfImport(csv, request).find("t.csv: columns: found no column 'prio'"), 0u);
  request = ReportsRequest();
  request.time = "";
  EXPECT_NE(ErrorOfImport(csv, request).find("expected a time that can be read, for the reports"),
            std::string::npos);
  request.time.reset();
  request.start = TimeOfDay("15:00");
  request.time = "when";
  EXPECT_EQ(ErrorOfImport(csv, request),
            "t.csv: rows: found none in the window and the mission's period of the day for the "
            "tasks, expected at least one");
}

TEST(ImportTasks, TheCommandTakesThemFromGeoJson) {
  const TemporaryFolder folder;
  std::ofstream(folder.File("points.geojson")) << R"({"type": "FeatureCollection", "features": [
    {"type": "Feature", "geometry": {"type": "Point", "coordinates": [20.001, 10.001]},
     "properties": {"time": 1263333190123, "p": 3, "title": "Hospital", "id": "q1"}}]})";
  const auto run = [&](const char* priority) {
    const std::string points = folder.File("points.geojson"), out = folder.File("s.json");
    const char* const argv[] = {"muster import", points.c_str(), "--window",     "10,20,3,2",
                                "--arrivals",    "rows",         "--start",      "21:00",
                                "--priority",    priority,       "--task-name",  "title",
                                "--external-id", "id",           "--quiet",      "--out",
                                out.c_str(),     "--due",        "none,none,9,5"};
    ImportCommand(static_cast<int>(std::size(argv)), argv);
    return LoadScenario(out);
  };
  const Task task = run("p").tasks.at(0);
  EXPECT_EQ(task.reported_us, 53 * kMinuteUs + 9'600'000);  // in hundredths of a minute
  EXPECT_EQ(task.due_us, task.reported_us + 5 * kMinuteUs);
  EXPECT_EQ(task.priority, Priority::kEmergency);
  EXPECT_EQ(task.name, "Hospital");
  EXPECT_EQ(task.external_id, "q1");
  try {
    run("title");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("point 1, column title: found 'Hospital'"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace muster::tools
