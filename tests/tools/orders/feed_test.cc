#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/program.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "tests/temporary_folder.h"
#include "tools/orders/feed_command.h"

namespace muster::tools {
namespace {

class FeedTest : public ::testing::Test {
 protected:
  /// Minutes of the mission at which the rows' tasks are reported.
  std::vector<double> Reported(const std::string& start, const std::vector<std::string>& times,
                               const std::vector<std::string>& flags) {
    Scenario scenario = Generate(PresetByName("Random_1"), 1);
    scenario.origin = Origin{18.4, -72.5};
    if (!start.empty()) scenario.start = ParseMoment(start);
    std::ofstream(folder_.File("s.json")) << ScenarioToJson(scenario);
    std::ofstream rows(folder_.File("rows.csv"));
    rows << "lat,lon,called\n";
    for (const std::string& time : times) rows << "18.5,-72.4," << time << "\n";
    rows.close();
    std::vector<std::string> words = {
        "muster feed", folder_.File("s.json"),      folder_.File("rows.csv"), "--time", "called",
        "--out",       folder_.File("orders.jsonl")};
    words.insert(words.end(), flags.begin(), flags.end());
    std::vector<const char*> argv;
    for (const std::string& word : words) argv.push_back(word.c_str());
    EXPECT_EQ(FeedCommand(static_cast<int>(argv.size()), argv.data()), kExitOk);
    std::ifstream orders(folder_.File("orders.jsonl"));
    std::vector<double> reported;
    for (std::string line; std::getline(orders, line);) {
      reported.push_back(nlohmann::json::parse(line)["task"].value("reported_min", 0.0));
    }
    return reported;
  }

  const TemporaryFolder folder_;
};

TEST_F(FeedTest, TimesCountFromTheScenariosStart) {
  // 9:00 at UTC-05:00 is 14:00 UTC; 1263654000 is 15:00:00 UTC of that day.
  const std::vector<std::string> times = {"09:30", "2010-01-16T14:45:00Z", "1263654000",
                                          "2010-01-16 11:00"};
  const std::string start = "2010-01-16T09:00:00-05:00";
  EXPECT_EQ(Reported(start, times, {}), (std::vector<double>{30, 45, 60, 120}));
  EXPECT_EQ(Reported(start, {"09:30"}, {"--start", "9:10"}), (std::vector<double>{20}));
  // As written, as in a scenario without a start.
  EXPECT_EQ(Reported(start, {"2010-01-16T14:45:00Z"}, {"--start", "14:00"}),
            (std::vector<double>{45}));
  EXPECT_EQ(Reported("2010-01-16T23:50:00+05:30", {"00:05"}, {}), (std::vector<double>{15}));
}

TEST_F(FeedTest, WithoutAStartTimesNeedOne) {
  try {
    Reported("", {"09:30"}, {});
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "command line: --time: found alone, expected --start HH:MM, the mission's "
                 "beginning, as its scenario has no start");
  }
}

}  // namespace
}  // namespace muster::tools
