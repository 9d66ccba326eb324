#include "tools/scenario/scenario_command.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/program.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "scheduler/policies/registry.h"
#include "tests/temporary_folder.h"
#include "tools/scenario/import_command.h"
#include "tools/scenario/policies_command.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

class ScenarioCommandTest : public ::testing::Test {
 protected:
  std::string File(const std::string& name) const { return folder_.File(name); }

  static std::vector<std::string> Words(const std::string& text) {
    std::istringstream in(text);
    return {std::istream_iterator<std::string>(in), {}};
  }

  Scenario Made(std::vector<std::string> flags) {
    flags.insert(flags.end(), {"--out", File("s.json")});
    EXPECT_EQ(Run(ScenarioCommand, flags), kExitOk);
    return LoadScenario(File("s.json"));
  }

  static int Run(int (*command)(int, const char* const*), const std::vector<std::string>& flags) {
    std::vector<const char*> argv = {"muster test"};
    for (const std::string& flag : flags) argv.push_back(flag.c_str());
    return command(static_cast<int>(argv.size()), argv.data());
  }

  static std::string ErrorOf(int (*command)(int, const char* const*),
                             const std::vector<std::string>& flags) {
    try {
      Run(command, flags);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  const TemporaryFolder folder_;
};

TEST_F(ScenarioCommandTest, PoliciesComeInThreeGroupsAndHelpNamesTwoOfThem) {
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(Run(PoliciesCommand, {"--json"}), kExitOk);
  const auto list = nlohmann::json::parse(::testing::internal::GetCapturedStdout());
  EXPECT_EQ(list["version"], 1);
  EXPECT_EQ(list["default"], scheduler::kDefaultPolicy);
  EXPECT_EQ(list["policies"].size(), scheduler::Policies().size());
  Options options("test", "");
  scheduler::AddPolicyOption(&options);
  ::testing::internal::CaptureStdout();
  const char* const help[] = {"test", "--help"};
  options.Parse(2, help);
  const std::vector<std::string> words = Words(::testing::internal::GetCapturedStdout());
  std::map<std::string, int> groups;
  for (const auto& policy : list["policies"]) {
    const std::string name = policy["name"], group = policy["group"];
    ++groups[group];
    EXPECT_EQ(std::count(words.begin(), words.end(), name) > 0, group != "ablation") << name;
  }
  EXPECT_EQ(groups.size(), 3u);
  EXPECT_GT(groups["ours"] * groups["paper"] * groups["ablation"], 0);
}

TEST_F(ScenarioCommandTest, ACheckNamesWhatAnOutsideSchedulerDoesWrong) {
  std::ofstream(File("program"))
      << "read -r line\necho '{\"type\":\"hello\",\"version\":1}'\nread -r line\n"
         "echo '{\"type\":\"decision\",\"id\":1,\"actions\":[]}'\nread -r line\n"
         "echo '{\"type\":\"decision\",\"id\":2,\"actions\":[{\"kind\":\"Ui\",\"uav\":999}]}'\n";
  const auto check = [&](const std::string& decisions) {
    const std::string command = "sh " + File("program");
    const char* const argv[] = {"policies", "check", command.c_str(), "--decisions",
                                decisions.c_str()};
    ::testing::internal::CaptureStdout();
    const int code = PoliciesCommand(5, argv);
    return std::pair(code, ::testing::internal::GetCapturedStdout());
  };
  const auto [good, all_well] = check("1");
  EXPECT_EQ(good, kExitOk);
  EXPECT_NE(all_well.find("0 of 1 answers refused"), std::string::npos) << all_well;
  const auto [bad, text] = check("2");
  EXPECT_EQ(bad, kExitCheckFailed);
  EXPECT_NE(text.find("REFUSED  decision 1: action 0 (Ui uav:999): unknown agent"),
            std::string::npos)
      << text;
}

TEST_F(ScenarioCommandTest, WritesThePresetOfTheSeed) {
  const Scenario s = Made({"--preset", "Random_20", "--seed", "18446744073709551615"});
  EXPECT_EQ(ScenarioToJson(s),
            ScenarioToJson(Generate(PresetByName("Random_20"), 18446744073709551615u)));
  EXPECT_FALSE(fs::exists(File("s.json.part")));
}

TEST_F(ScenarioCommandTest, EveryNumberCanBeSet) {
  const Scenario s =
      Made(Words("--area 12x8.5 --uavs 3 --workers 4 --vehicles 5 --tasks 6 "
                 "--charging-points 7 --online-min 45 --task-cost-km 2.5 "
                 "--charge-km-per-min 6:8 --uav-speed-km-per-min 1.2 "
                 "--worker-speed-km-per-min 0.3 --vehicle-speed-km-per-min 0.6 "
                 "--full-range-km 20 --start-fraction 0.5 --capacity 2 --interval 5 "
                 "--limit 120 --tick 15 --availability overrun --ceil-to-minutes "
                 "--mean-over-all --start-on-meeting --wind 0.1:0.4 --communication-km 0.1:0.5 "
                 "--agent-failure 0.01:0.05 --match-failure 0.05 --name mine"));
  EXPECT_EQ(s.name, "mine");
  EXPECT_EQ(s.width_m, 12'000);
  EXPECT_EQ(s.height_m, 8500);
  EXPECT_EQ(s.uavs.size(), 3u);
  EXPECT_EQ(s.workers.size(), 4u);
  EXPECT_EQ(s.vehicles.size(), 5u);
  EXPECT_EQ(s.tasks.size(), 6u);
  EXPECT_EQ(s.charging_points.size(), 7u);
  EXPECT_EQ(s.uavs[0].online_until_us - s.uavs[0].online_from_us, 45 * kMinuteUs);
  EXPECT_LE(s.uavs[0].online_until_us, 120 * kMinuteUs);
  EXPECT_EQ(s.tasks[0].cost_m, 2500);
  EXPECT_GE(s.vehicles[0].charge_rate_m_s, 99.99);
  EXPECT_LE(s.vehicles[0].charge_rate_m_s, 133.34);
  EXPECT_EQ(s.uavs[0].speed_m_s, 20);
  EXPECT_EQ(s.workers[0].speed_m_s, 5);
  EXPECT_EQ(s.vehicles[0].speed_m_s, 10);
  EXPECT_EQ(s.uavs[0].range_full_m, 20'000);
  EXPECT_EQ(s.uavs[0].range_m, 10'000);
  EXPECT_EQ(s.charging_points[6].capacity, 2);
  Rules rules;
  rules.interval_us = 5 * kMinuteUs;
  rules.limit_us = 120 * kMinuteUs;
  rules.tick_us = 15 * kSecondUs;
  rules.availability = Availability::kOverrun;
  rules.ceil_to_minutes = rules.mean_over_all = rules.start_on_meeting = true;
  EXPECT_EQ(s.rules, rules);
  EXPECT_EQ(s.disturbances.wind, (Disturbances::Interval{0.1, 0.4}));
  EXPECT_EQ(s.disturbances.communication_m, (Disturbances::Interval{100, 500}));
  EXPECT_EQ(s.disturbances.agent_failure, (Disturbances::Interval{0.01, 0.05}));
  EXPECT_EQ(s.disturbances.match_failure, (Disturbances::Interval{0.05, 0.05}));
  EXPECT_EQ(Made({"--capacity", "none"}).charging_points[0].capacity, std::nullopt);
}

TEST_F(ScenarioCommandTest, SwitchesOfTheUnpublishedSettings) {
  const Scenario s = Made({"--placement", "continuous", "--uptime", "any", "--online-min", "100:"});
  bool off_centre = false;
  TimeUs last = 0;
  for (const AgentSpec& worker : s.workers) {
    off_centre = off_centre || worker.at.x_m != std::floor(worker.at.x_m / 1000) * 1000 + 500;
    last = std::max(last, worker.online_until_us);
    EXPECT_GE(worker.online_until_us - worker.online_from_us, 100 * kMinuteUs);
  }
  EXPECT_TRUE(off_centre);
  EXPECT_GT(last, 180 * kMinuteUs);
}

TEST_F(ScenarioCommandTest, TasksHaveTimesAndPriorities) {
  const std::vector<std::string> flags = {"--arrivals", "bursts:2:0.5", "--priorities",
                                          "1,6,2,1",    "--due",        "none,60,30:40,10",
                                          "--expires",  "120"};
  GeneratorSettings settings = PresetByName("Random_1");
  settings.arrivals = {.share = 0.5, .bursts = 2};
  settings.priority_shares = {1, 6, 2, 1};
  settings.due_min = {std::nullopt, Always(60), DrawRange{30, 40}, Always(10)};
  settings.expires_min.fill(Always(120));
  EXPECT_EQ(ScenarioToJson(Made(flags)), ScenarioToJson(Generate(settings, 1)));
  settings = PresetByName("Random_1");
  settings.arrivals = {.share = 1};
  EXPECT_EQ(ScenarioToJson(Made({"--arrivals", "steady"})), ScenarioToJson(Generate(settings, 1)));
}

TEST_F(ScenarioCommandTest, ScaleKeepsDensityAndNumbersThatAreGiven) {
  const Scenario s = Made({"--scale", "4", "--tasks", "17"});
  EXPECT_EQ(s.name, "Random_1_x4");
  EXPECT_EQ(s.width_m, 60'000);
  EXPECT_EQ(s.workers.size(), 200u);
  EXPECT_EQ(s.tasks.size(), 17u);
}

TEST_F(ScenarioCommandTest, AnyPresetCanHaveAStart) {
  Scenario s = Made({"--preset", "Random_2", "--start", "2010-01-16T09:00:00-05:00"});
  ASSERT_TRUE(s.start);
  EXPECT_EQ(s.start->text, "2010-01-16T09:00:00-05:00");
  s.start.reset();
  EXPECT_EQ(ScenarioToJson(s), ScenarioToJson(Made({"--preset", "Random_2"})));
  EXPECT_EQ(ErrorOf(ScenarioCommand, {"--start", "9:00"}),
            "command line: --start: found '9:00', expected ISO 8601 with seconds and an offset or "
            "Z, of the years 1900 to 2199, like 2010-01-16T09:00:00-05:00");
}

TEST_F(ScenarioCommandTest, BadFlagsNameThemselves) {
  const auto starts = [](const std::vector<std::string>& flags, const std::string& message) {
    const std::string error = ErrorOf(ScenarioCommand, flags);
    EXPECT_EQ(error.find(message), 0u) << error;
  };
  starts({"--area", "30"}, "command line: --area: found '30', expected WxH");
  starts({"--area", "30x-1"}, "command line: --area: found '30x-1', expected WxH");
  starts({"--area", "nanx1"}, "command line: --area: found 'nanx1', expected WxH");
  starts({"--uavs", "0"}, "command line: --uavs: found '0', expected an integer in [1,");
  starts({"--uavs", "3.5"}, "command line: --uavs: found '3.5', expected an integer in [1,");
  starts({"--tasks", "99999999999"}, "command line: --tasks: found '99999999999', expected");
  starts({"--seed", "-1"}, "command line: --seed: found '-1', expected an integer in [0,");
  starts({"--task-cost-km", "4:2"},
         "command line: --task-cost-km: found '4:2', expected A, A:B with");
  starts({"--task-cost-km", "4:"},
         "command line: --task-cost-km: found '4:', expected A, A:B with");
  starts({"--online-min", "1:2:3"},
         "command line: --online-min: found '1:2:3', expected A, A:B or A:");
  starts({"--wind", "x"}, "command line: --wind: found 'x', expected A, A:B");
  starts({"--agent-failure", "0:1.5"}, "command line: --agent-failure: found '0:1.5', expected");
  starts({"--interval", "0"}, "command line: --interval: found '0', expected a number above 0");
  starts({"--interval", "200"}, "generator settings: interval_min: found 200, expected");
  starts({"--tick", "7"}, "generator settings: rules.tick_s: found 7, expected");
  starts({"--uptime", "late"}, "command line: --uptime: found 'late', expected within or any");
  starts({"--capacity", "0"}, "command line: --capacity: found '0', expected none or an int");
  starts({"--scale", "0"}, "command line: --scale: found '0', expected a number in [1e-06, 10");
  for (const char* how : {"rows", "slow", "steady:2", "steady:x", "steady:1:1", "bursts",
                          "bursts:0", "bursts:1.5", "bursts:2:-1", "bursts:2:1:1"}) {
    starts({"--arrivals", how}, fmt::format("command line: --arrivals: found '{}', expected steady "
                                            "or bursts:N, and :SHARE in [0, 1]",
                                            how));
  }
  for (const char* shares : {"1", "1,1,1", "1,1,1,x", "0,0,0,0", "1,1,1,-1", "1,1,1,1,1"}) {
    starts({"--priorities", shares},
           fmt::format("command line: --priorities: found '{}', expected LOW,NORMAL,HIGH,EMERGENCY",
                       shares));
  }
  for (const char* delay : {"x", "-1", "5:", "5:3", "1,2", "1,2,3,4,5", "1,2,3,soon"}) {
    for (const std::string flag : {"due", "expires"}) {
      starts({"--" + flag, delay},
             fmt::format("command line: --{}: found '{}', expected minutes A, A:B or none", flag,
                         delay));
    }
  }
  starts({"--preset", "Random_99"}, "no preset 'Random_99'");
  starts({"extra"}, "unexpected argument 'extra'");
  EXPECT_THROW(Run(ScenarioCommand, {"--out", File("none/s.json")}), SystemError);
}

TEST_F(ScenarioCommandTest, NothingIsWrittenOnError) {
  std::ofstream(File("s.json")) << "kept";
  EXPECT_NE(ErrorOf(ScenarioCommand, {"--tick", "7", "--out", File("s.json")}), "no error");
  std::string text;
  std::ifstream(File("s.json")) >> text;
  EXPECT_EQ(text, "kept");
}

TEST_F(ScenarioCommandTest, ImportsCsvAndGeoJsonAlike) {
  std::ofstream(File("points.csv")) << "Lat,Lng,code\n10.001,20.001,1a;9\n10.012,20.001,7\n"
                                       "10.013,20.022,1b\n10.0131,20.0221,2d\n";
  std::ofstream(File("points.geojson")) << R"({"type": "FeatureCollection", "features": [
    {"type": "Feature", "geometry": {"type": "Point", "coordinates": [20.001, 10.001]}, "properties": {"code": "1a;9"}},
    {"type": "Feature", "geometry": {"type": "Point", "coordinates": [20.001, 10.012]}, "properties": {"code": 7}},
    {"type": "Feature", "geometry": {"type": "Point", "coordinates": [20.022, 10.013]}, "properties": {"code": "1b"}},
    {"type": "Feature", "geometry": {"type": "Point", "coordinates": [20.0221, 10.0131]}, "properties": {"code": "2d"}}]})";
  const auto import = [&](const std::string& points) {
    EXPECT_EQ(Run(ImportCommand, {File(points), "--window", "10,20,3,2", "--tasks-where", "code=1*",
                                  "--charging-where", "code=7*,2d", "--workers", "7", "--name", "n",
                                  "--quiet", "--out", File("s.json")}),
              kExitOk);
    return LoadScenario(File("s.json"));
  };
  const Scenario s = import("points.csv");
  ASSERT_EQ(s.tasks.size(), 2u);
  EXPECT_EQ(s.tasks[0].at, (Point{500, 500}));
  EXPECT_EQ(s.tasks[1].at, (Point{2500, 1500}));
  ASSERT_EQ(s.charging_points.size(), 2u);
  EXPECT_EQ(s.charging_points[0].at, (Point{500, 1500}));
  EXPECT_EQ(s.charging_points[1].at, (Point{2500, 1500}));
  EXPECT_EQ(s.workers.size(), 7u);
  EXPECT_EQ(s.origin->longitude_deg, 20);
  EXPECT_EQ(ScenarioToJson(import("points.geojson")), ScenarioToJson(s));
}

/// An incident of 9 by 4 km: without a size it gets an area around it, not one of 30 by 30 km.
TEST_F(ScenarioCommandTest, ImportTakesAnAreaAroundASmallIncident) {
  std::ofstream(File("points.csv")) << "lat,lon\n47.10,9.50\n47.13,9.55\n47.11,9.62\n";
  const auto import = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), File("points.csv"));
    flags.insert(flags.end(), {"--quiet", "--out", File("s.json")});
    EXPECT_EQ(Run(ImportCommand, flags), kExitOk);
    return LoadScenario(File("s.json"));
  };
  const Scenario own = import({});
  EXPECT_EQ(own.width_m, 11'000);
  EXPECT_EQ(own.height_m, 5'000);
  ASSERT_EQ(own.tasks.size(), 3u);
  for (const Task& task : own.tasks) {
    EXPECT_GT(task.at.x_m, 0);
    EXPECT_LT(task.at.x_m, own.width_m);
    EXPECT_LT(task.at.y_m, own.height_m);
  }
  EXPECT_EQ(import({"--area", "30x30"}).width_m, 30'000);
  EXPECT_EQ(import({"--shape", "Random_1"}).width_m, 30'000);
  // One place alone has some room around it.
  std::ofstream(File("points.csv")) << "lat,lon\n47.10,9.50\n";
  EXPECT_EQ(import({}).width_m, 2'000);
}

TEST_F(ScenarioCommandTest, ImportTakesTheFleetAndTheDepotsOfTheUser) {
  std::ofstream(File("points.csv")) << "lat,lon\n47.10,9.50\n47.13,9.55\n47.11,9.62\n";
  std::ofstream(File("depots.csv"))
      << "latitude,longitude,capacity\n47.12,9.52,2\n47.05,9.5,none\n";
  const auto fleet = [&](const std::string& text) {
    std::ofstream(File("fleet.csv")) << text;
    return std::vector<std::string>{
        File("points.csv"), "--fleet", File("fleet.csv"), "--depots",
        File("depots.csv"), "--quiet", "--out",           File("s.json")};
  };
  EXPECT_EQ(Run(ImportCommand, fleet("class,lat,lon,speed_km_per_min,full_range_km,range_km,"
                                     "charge_km_per_min,online_from_min,online_until_min\n"
                                     "Drone,47.12,9.52,0.9,25,20,,,\n"
                                     "workers,47.16,9.55,0.1,,,,15,60\n"
                                     "vehicle,47.05,9.50,,,,2,,\n")),
            kExitOk);
  const Scenario scenario = LoadScenario(File("s.json"));
  ASSERT_EQ(scenario.uavs.size(), 1u);
  EXPECT_NEAR(scenario.uavs[0].speed_m_s, 15, 1e-9);
  EXPECT_EQ(scenario.uavs[0].range_full_m, 25'000);
  EXPECT_EQ(scenario.uavs[0].range_m, 20'000);
  EXPECT_EQ(scenario.uavs[0].online_from_us, 0);
  EXPECT_EQ(scenario.uavs[0].online_until_us, scenario.rules.limit_us);
  ASSERT_EQ(scenario.workers.size(), 1u);
  EXPECT_EQ(scenario.workers[0].online_from_us, 15 * kMinuteUs);
  EXPECT_EQ(scenario.workers[0].online_until_us, 60 * kMinuteUs);
  ASSERT_EQ(scenario.vehicles.size(), 1u);
  EXPECT_NEAR(scenario.vehicles[0].charge_rate_m_s, 2000.0 / 60, 1e-9);
  ASSERT_EQ(scenario.charging_points.size(), 2u);
  EXPECT_EQ(scenario.charging_points[0].capacity, 2);
  EXPECT_FALSE(scenario.charging_points[1].capacity);
  // The UAV stands at the first depot, some 2.7 km from the first task's place: a degree of
  // latitude has 111 km, one of longitude here 76.
  EXPECT_EQ(scenario.uavs[0].at, scenario.charging_points[0].at);
  EXPECT_NEAR(Distance(scenario.vehicles[0].at, scenario.charging_points[0].at),
              std::hypot(0.07 * 111'180, 0.02 * 75'900), 30);

  const auto error = [&](const std::string& text) { return ErrorOf(ImportCommand, fleet(text)); };
  const std::string name = File("fleet.csv");
  EXPECT_EQ(error("class,lat,lon\ntank,47,9.5\n"),
            name + ": record 2: class: found tank, expected uav, worker or vehicle");
  EXPECT_EQ(error("class,lat,lon\nuav,x,9.5\n"),
            name + ": record 2: latitude: found x, expected degrees within 90");
  EXPECT_EQ(error("class,lat,lon,full_range_km\nuav,47,9.5,-3\n"),
            name + ": record 2: full_range_km: found -3, expected a number above 0");
  EXPECT_EQ(
      error("class,lat,lon\nuav,47,9.5\n"),
      name + ": class: found no worker, expected at least one UAV, one worker and one vehicle");
  EXPECT_NE(error("class,lat,lon\nuav,47.1,9.5\nworker,47.1,9.5\nvehicle,10,20\n")
                .find("vehicle:0: place: found 10.000000, 20.000000"),
            std::string::npos);
}

TEST_F(ScenarioCommandTest, ImportSeveralFiltersMustAllHold) {
  std::ofstream(File("points.csv")) << "lat,lon,code,ok\n10.001,20.001,1,YES\n10.012,20.001,1,NO\n"
                                       "10.013,20.022,2,YES\n";
  EXPECT_EQ(Run(ImportCommand, {File("points.csv"), "--window", "10,20,3,2", "--where", "code=1",
                                "--where", "ok=YES", "--quiet", "--out", File("s.json")}),
            kExitOk);
  EXPECT_EQ(LoadScenario(File("s.json")).tasks.size(), 1u);
}

TEST_F(ScenarioCommandTest, ImportNamesWhatIsWrong) {
  std::ofstream(File("points.csv")) << "lat,lon\n10,20\n";
  const auto error = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), File("points.csv"));
    return ErrorOf(ImportCommand, flags);
  };
  EXPECT_EQ(ErrorOf(ImportCommand, {}),
            "command line: FILE: found nothing, expected a table of places (see --help)");
  for (const char* window :
       {"1,2,3", "91,0,1,1", "0,181,1,1", "0,0,0,1", "0,0,1,5000", "a,0,1,1"}) {
    EXPECT_EQ(error({"--window", window}).find("command line: --window: found '"), 0u) << window;
  }
  EXPECT_EQ(error({"--where", "code"}).find("command line: --where: found 'code'"), 0u);
  EXPECT_EQ(error({"--tasks-at", "a"}).find("command line: --tasks-at: found 'a'"), 0u);
  EXPECT_EQ(error({"--start", "noon"}).find("command line: --start: found 'noon'"), 0u);
  EXPECT_EQ(error({"--start", "2010-01-16T09:00:00"})
                .find("command line: --start: found '2010-01-16T09:00:00', expected a time of day "
                      "like 7:30, or ISO 8601 with seconds and an offset or Z"),
            0u);
  EXPECT_EQ(error({"--utc-offset", "EST"}),
            "command line: --utc-offset: found 'EST', expected an offset like -05:00 or 05:30, at "
            "most 14:00");
  EXPECT_EQ(error({"--utc-offset", "-04:00", "--start", "2010-01-16T09:00:00-05:00"}),
            "command line: --utc-offset: found '-04:00', expected UTC-05:00, that of --start");
  EXPECT_THROW(Run(ImportCommand, {File("none.csv")}), InputError);
}

}  // namespace
}  // namespace muster::tools
