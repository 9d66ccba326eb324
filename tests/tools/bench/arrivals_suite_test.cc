#include "tools/bench/arrivals_suite.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "base/check.h"
#include "model/scenario_json.h"
#include "tests/temporary_folder.h"
#include "tools/scenario/import_command.h"

namespace muster::tools {
namespace {

std::size_t CountOf(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(ArrivalsSuite, EveryPolicyServesTheSameReports) {
  BenchOptions options;
  options.methods = {"mpq", "horizon"};
  options.instances = ArrivalsInstances(false);
  options.loads = {0.25, 0.5};
  options.seeds = 1;
  options.first_seed = 3;
  std::vector<ArrivalsRow> rows;
  RunArrivals(options, [&](const ArrivalsRow& row) { rows.push_back(row); });
  ASSERT_EQ(rows.size(), 8u);
  for (std::size_t i = 0; i < rows.size(); i += 2) {
    const ArrivalsRow &mpq = rows[i], &horizon = rows[i + 1];
    EXPECT_EQ(mpq.policy, "mpq");
    EXPECT_EQ(horizon.policy, "horizon");
    EXPECT_EQ(mpq.service.reported(), horizon.service.reported());
    EXPECT_EQ(mpq.service.worth_all, horizon.service.worth_all);
    EXPECT_GT(horizon.service.reported(), mpq.load * 100);  // of 120 times the load
    EXPECT_GT(mpq.service.worth_done, 0);
    EXPECT_LE(horizon.service.worth_done, horizon.service.worth_all);
    const std::string line = ToCsv(mpq), header = ArrivalsCsvHeader();
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
  }
}

/// A mission that did so many of ten tasks on time, of normal priority, in 10 min.
ArrivalsRow Row(const std::string& arrivals, double load, std::uint64_t seed,
                const std::string& policy, int done) {
  ArrivalsRow row{arrivals, load, seed, policy, {}};
  row.service.by_priority[1] = {10, done, done};
  row.service.worth_all = 10;
  row.service.worth_done = done;
  row.service.response_s.assign(static_cast<std::size_t>(done), 600);
  return row;
}

TEST(ArrivalsTables, HoldMeansAndPairedDifferencesToTheDefaultPolicy) {
  const std::vector<ArrivalsRow> rows = {
      Row("steady", 1, 1, "mpq", 4), Row("steady", 1, 1, "rollout-steps", 6),
      Row("steady", 1, 2, "mpq", 2), Row("steady", 1, 2, "rollout-steps", 8),
      Row("bursts", 1, 1, "mpq", 0), Row("bursts", 1, 1, "rollout-steps", 5),
  };
  const std::string summary = SummaryOf(rows);
  EXPECT_NE(summary.find("| arrivals | load | `mpq` | `rollout-steps` |"), std::string::npos);
  // Differences of -20 and -60: their mean, and 40 / sqrt(2) / sqrt(2).
  EXPECT_EQ(CountOf(summary, "| steady | 1 | 30.0 (-40.0 \u00b1 20.0) | 70.0 |\n"), 2u) << summary;
  EXPECT_EQ(CountOf(summary, "| bursts | 1 | 0.0 (-50.0) | 50.0 |\n"), 2u) << "one seed";
  EXPECT_EQ(CountOf(summary, "| steady | 1 | , 30, ,  | , 70, ,  |\n"), 1u) << summary;
  EXPECT_EQ(CountOf(summary, "| bursts | 1 |  | 10.0 |\n"), 1u) << "nothing done, no response";

  const std::string plot = ArrivalsPlot(rows, "a.svg");
  EXPECT_NE(plot.find("set output 'a.svg'"), std::string::npos);
  EXPECT_NE(plot.find("$of_0_1 << EOD\n1 0.7000\nEOD\n"), std::string::npos) << plot;
}

TEST(ArrivalsTables, WithoutTheDefaultPolicyTheFirstIsComparedWith) {
  const std::vector<ArrivalsRow> rows = {Row("steady", 1, 1, "mpq", 4),
                                         Row("steady", 1, 1, "kwta", 6)};
  EXPECT_NE(SummaryOf(rows).find("| steady | 1 | 40.0 | 60.0 (+20.0) |"), std::string::npos);
}

/// A folder of data with a hundred rows in each table, one every minute from 8:00 on.
class ArrivalsOfRows : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto table = [&](const std::string& file, const std::string& columns, auto row) {
      std::filesystem::create_directories((folder_ / file).parent_path());
      std::ofstream out(folder_ / file);
      out << columns << "\n";
      for (int i = 0; i < 100; ++i) {
        out << row(48 + i % 10 * 0.02, 11 + i / 10 * 0.02,
                   fmt::format("{}:{:02}", 8 + i / 60, i % 60), i)
            << "\n";
      }
    };
    table(kHaiti, "latitude,longitude,incident_date,category",
          [](double north, double east, const std::string& at, int i) {
            return fmt::format("{},{},01/02/2010 {},{}", north, east, at, i % 4 == 3 ? "7a" : "1a");
          });
    for (const char* file :
         {"nyc_citibike_202409/citibike.csv", "shenzhen_taxi_orders/taxi-price.csv"}) {
      table(file, "lat,lon,time,ELat,ELng",
            [](double north, double east, const std::string& at, int) {
              return fmt::format("{0},{1},{2},{0},{1}", north, east, at);
            });
    }
    options_.data = (folder_ / "").string();
    options_.methods = {"horizon"};
    options_.instances = {"haiti"};
    options_.loads = {0.25, 0.5};
    options_.seeds = 1;
  }

  static constexpr const char* kHaiti = "haiti2010_ushahidi/haiti_reports.csv";
  TemporaryFolder folder_;
  BenchOptions options_;
};

TEST_F(ArrivalsOfRows, AreTheScenariosOfImport) {
  EXPECT_EQ(ArrivalsInstances(true).size(), 2 + ImportedSettings::Names().size());
  const std::string file = folder_.File("haiti.json"), table = folder_.File(kHaiti);
  const std::vector<const char*> arguments = {"muster import",
                                              table.c_str(),
                                              "--shape",
                                              "Random_1",
                                              "--tasks-where",
                                              "category=1*,2*,3*",
                                              "--charging-where",
                                              "category=7*,2d",
                                              "--arrivals",
                                              "rows",
                                              "--tasks",
                                              "60",
                                              "--priorities",
                                              "3,4,2,1",
                                              "--due",
                                              "60,40,25,15",
                                              "--expires",
                                              "120,80,50,30",
                                              "--name",
                                              "haiti",
                                              "--seed",
                                              "4",
                                              "--out",
                                              file.c_str(),
                                              "--quiet"};
  ASSERT_EQ(ImportCommand(static_cast<int>(arguments.size()), arguments.data()), 0);
  std::ifstream in(file);
  const std::string made(std::istreambuf_iterator<char>(in), {});
  ImportedSettings imported(options_.data);
  EXPECT_EQ(ScenarioToJson(ArrivalsScenario(&imported, "haiti", 0.5, 4)), made);
}

TEST_F(ArrivalsOfRows, AreFlownWithAsManyRowsAsTheLoadSays) {
  std::vector<ArrivalsRow> rows;
  RunArrivals(options_, [&](const ArrivalsRow& row) { rows.push_back(row); });
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].arrivals, "haiti");
  EXPECT_EQ(rows[0].service.reported(), 30);
  EXPECT_EQ(rows[1].service.reported(), 60);
  EXPECT_GT(rows[1].service.done(), 0);
}

TEST_F(ArrivalsOfRows, ALoadBeyondTheRowsIsRefusedBeforeTheFirstMission) {
  options_.loads = {0.25, 1};  // 75 rows are of tasks
  int flown = 0;
  try {
    RunArrivals(options_, [&](const ArrivalsRow&) { ++flown; });
    FAIL() << "flown";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("75 rows"), std::string::npos) << error.what();
  }
  EXPECT_EQ(flown, 0);
}

TEST_F(ArrivalsOfRows, AFolderThatLacksATableIsRefused) {
  std::filesystem::remove(folder_ / kHaiti);
  EXPECT_THROW(RunArrivals(options_, [](const ArrivalsRow&) {}), InputError);
}

}  // namespace
}  // namespace muster::tools
