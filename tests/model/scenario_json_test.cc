#include "model/scenario_json.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "base/check.h"
#include "base/random.h"
#include "model/generator.h"
#include "model/made_up.h"
#include "tests/temporary_folder.h"

namespace muster {
namespace {

using nlohmann::json;

constexpr const char* kSmall = R"({
  "version": 1, "name": "small", "seed": 18446744073709551615, "area_km": [4, 3.5],
  "interval_min": 10, "limit_min": 180,
  "uavs": [{"id": 0, "x_km": 0.5, "y_km": 1.5, "speed_km_per_min": 1.2, "full_range_km": 30,
            "range_km": 12.25, "online_from_min": 0, "online_until_min": 60}],
  "workers": [{"id": 0, "x_km": 4, "y_km": 3.5, "speed_km_per_min": 0.5, "online_from_min": 1.5,
               "online_until_min": 61.5}],
  "vehicles": [{"id": 0, "x_km": 0, "y_km": 0, "speed_km_per_min": 0.75, "charge_km_per_min": 10,
                "online_from_min": 20, "online_until_min": 20}],
  "tasks": [{"id": 0, "x_km": 1, "y_km": 1, "cost_km": 3}, {"id": 1, "x_km": 2, "y_km": 2, "cost_km": 0}],
  "charging_points": [{"id": 0, "x_km": 3, "y_km": 1}, {"id": 1, "x_km": 3, "y_km": 1, "capacity": 4},
                      {"id": 2, "x_km": 3, "y_km": 1, "capacity": null}]
})";

std::string ErrorOf(const std::string& text) {
  try {
    ParseScenario(text, "f.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

/// Bit for bit, so that -0, rounding and lost digits show.
bool SameBits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

void ExpectSame(const Scenario& a, const Scenario& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.seed, b.seed);
  EXPECT_TRUE(SameBits(a.width_m, b.width_m) && SameBits(a.height_m, b.height_m));
  EXPECT_EQ(a.rules, b.rules);
  EXPECT_EQ(a.disturbances, b.disturbances);
  ASSERT_EQ(a.origin.has_value(), b.origin.has_value());
  if (a.origin) {
    EXPECT_TRUE(SameBits(a.origin->latitude_deg, b.origin->latitude_deg));
    EXPECT_TRUE(SameBits(a.origin->longitude_deg, b.origin->longitude_deg));
  }
  for (const AgentKind kind : kAgentKinds) {
    ASSERT_EQ(a.agents(kind).size(), b.agents(kind).size());
    for (std::size_t i = 0; i < a.agents(kind).size(); ++i) {
      const AgentSpec& x = a.agents(kind)[i];
      const AgentSpec& y = b.agents(kind)[i];
      EXPECT_TRUE(SameBits(x.at.x_m, y.at.x_m) && SameBits(x.at.y_m, y.at.y_m));
      EXPECT_TRUE(SameBits(x.speed_m_s, y.speed_m_s)) << x.speed_m_s;
      EXPECT_TRUE(SameBits(x.range_full_m, y.range_full_m) && SameBits(x.range_m, y.range_m));
      EXPECT_TRUE(SameBits(x.charge_rate_m_s, y.charge_rate_m_s)) << x.charge_rate_m_s;
      EXPECT_EQ(x.online_from_us, y.online_from_us);
      EXPECT_EQ(x.online_until_us, y.online_until_us);
    }
  }
  ASSERT_EQ(a.tasks.size(), b.tasks.size());
  for (std::size_t i = 0; i < a.tasks.size(); ++i) {
    EXPECT_EQ(a.tasks[i].at, b.tasks[i].at);
    EXPECT_TRUE(SameBits(a.tasks[i].cost_m, b.tasks[i].cost_m));
  }
  ASSERT_EQ(a.charging_points.size(), b.charging_points.size());
  for (std::size_t i = 0; i < a.charging_points.size(); ++i) {
    EXPECT_EQ(a.charging_points[i].at, b.charging_points[i].at);
    EXPECT_EQ(a.charging_points[i].capacity, b.charging_points[i].capacity);
  }
}

TEST(ScenarioJson, ConvertsToSiUnits) {
  const Scenario s = ParseScenario(kSmall, "f.json");
  EXPECT_EQ(s.name, "small");
  EXPECT_EQ(s.seed, 18446744073709551615u);
  EXPECT_EQ(s.width_m, 4000);
  EXPECT_EQ(s.height_m, 3500);
  EXPECT_EQ(s.rules, Rules());
  EXPECT_EQ(s.disturbances, Disturbances());
  EXPECT_FALSE(s.origin.has_value());
  EXPECT_EQ(s.uavs[0].at, (Point{500, 1500}));
  EXPECT_EQ(s.uavs[0].speed_m_s, 20);
  EXPECT_EQ(s.uavs[0].range_full_m, 30000);
  EXPECT_EQ(s.uavs[0].range_m, 12250);
  EXPECT_EQ(s.workers[0].online_from_us, 90 * kSecondUs);
  EXPECT_EQ(s.workers[0].online_until_us, 3690 * kSecondUs);
  EXPECT_EQ(s.vehicles[0].speed_m_s, 12.5);
  EXPECT_EQ(s.vehicles[0].charge_rate_m_s, 10000.0 / 60);
  EXPECT_EQ(s.tasks[0].cost_m, 3000);
  EXPECT_EQ(s.charging_points[0].capacity, 1);
  EXPECT_EQ(s.charging_points[1].capacity, 4);
  EXPECT_EQ(s.charging_points[2].capacity, std::nullopt);
}

TEST(ScenarioJson, ReadsRulesDisturbancesAndOrigin) {
  json file = json::parse(kSmall);
  file["origin"] = {{"latitude_deg", 18.5}, {"longitude_deg", -72.25}};
  file["rules"] = {{"availability", "overrun"},
                   {"tick_s", 0.5},
                   {"ceil_to_minutes", true},
                   {"mean_over_all", true},
                   {"start_on_meeting", true}};
  file["disturbances"] = {{"wind", {0.1, 0.4}},
                          {"communication_km", {0.1, 0.5}},
                          {"agent_failure", {0.01, 0.05}},
                          {"match_failure", {0.05, 0.1}}};
  const Scenario s = ParseScenario(file.dump(), "f.json");
  EXPECT_EQ(s.origin->latitude_deg, 18.5);
  EXPECT_EQ(s.origin->longitude_deg, -72.25);
  EXPECT_EQ(s.rules.availability, Availability::kOverrun);
  EXPECT_EQ(s.rules.tick_us, 500'000);
  EXPECT_TRUE(s.rules.ceil_to_minutes && s.rules.mean_over_all && s.rules.start_on_meeting);
  EXPECT_EQ(s.disturbances.wind, (Disturbances::Interval{0.1, 0.4}));
  EXPECT_EQ(s.disturbances.communication_m, (Disturbances::Interval{100, 500}));
  EXPECT_EQ(s.disturbances.agent_failure, (Disturbances::Interval{0.01, 0.05}));
  EXPECT_EQ(s.disturbances.match_failure, (Disturbances::Interval{0.05, 0.1}));
  ExpectSame(s, ParseScenario(ScenarioToJson(s), "again"));
}

struct BadValue {
  const char* pointer;  ///< JSON pointer of the value to set, or to remove with a discarded value
  json value;
  const char* message;
};

void ExpectRefused(std::span<const BadValue> cases) {
  for (const BadValue& bad : cases) {
    json file = json::parse(kSmall);
    const json::json_pointer pointer(bad.pointer);
    if (bad.value.is_discarded()) {
      file[pointer.parent_pointer()].erase(pointer.back());
    } else {
      file[pointer] = bad.value;
    }
    const std::string error = ErrorOf(file.dump());
    EXPECT_EQ(error.find(std::string("f.json: ") + bad.message), 0u)
        << bad.pointer << " gave: " << error << "\nwanted: " << bad.message;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

const json kRemoved = json(json::value_t::discarded);

TEST(ScenarioJson, AStartIsWrittenAsItWasRead) {
  json file = json::parse(kSmall);
  const std::string without = ScenarioToJson(ParseScenario(file.dump(), "f.json"));
  EXPECT_EQ(without.find("start\""), std::string::npos);
  for (const std::string text :
       {"2010-01-16T09:00:00-05:00", "2010-01-16 14:00:00.000Z", "20100116T090000-0500"}) {
    file["start"] = text;
    const Scenario scenario = ParseScenario(file.dump(), "f.json");
    ASSERT_TRUE(scenario.start) << text;
    EXPECT_EQ(scenario.start->unix_us, 1'263'650'400 * kSecondUs) << text;
    EXPECT_EQ(scenario.start->offset_min, text.ends_with('Z') ? 0 : -300) << text;
    EXPECT_FALSE(scenario.IsOpen());
    const std::string written = ScenarioToJson(scenario);
    EXPECT_NE(written.find("  \"start\": \"" + text + "\",\n"), std::string::npos) << written;
    EXPECT_EQ(ScenarioToJson(ParseScenario(written, "again")), written);
    // Nothing else of the file changes.
    EXPECT_EQ(written.size(),
              without.size() + text.size() + std::string(R"(  "start": "",)").size() + 1);
  }
}

TEST(ScenarioJson, NamesKeyFoundAndExpectedOfTheWhole) {
  const BadValue cases[] = {
      {"/version", 3, "version: found 3, expected 1 or 2"},
      {"/version", kRemoved, "version: found no such key, expected 1"},
      {"/version", "1", "version: found \"1\", expected 1"},
      {"/colour", "red",
       "top level: found the unknown key \"colour\", expected only version, name,"},
      {"/rules", {{"tick", 1}}, "rules: found the unknown key \"tick\""},
      {"/disturbances", {{"rain", 1}}, "disturbances: found the unknown key \"rain\""},
      {"/name", kRemoved, "name: found no such key, expected a string"},
      {"/name", 7, "name: found 7, expected a string"},
      {"/seed", -1, "seed: found -1, expected an integer in [0, 18446744073709551615]"},
      {"/seed", 1.5, "seed: found 1.5, expected an integer"},
      {"/seed", "1", "seed: found \"1\", expected an integer"},
      {"/area_km", 30, "area_km: found 30, expected an array"},
      {"/area_km", {30, 30, 30}, "area_km: found an array of 3, expected [width, height]"},
      {"/area_km/0", "4", "area_km[0]: found \"4\", expected a number"},
      {"/area_km/0", 0, "area_km[0]: found 0, expected a number above 0 and at most 20000"},
      {"/area_km/1", -3, "area_km[1]: found -3, expected a number above 0 and at most 20000"},
      {"/area_km/1", 1e307, "area_km[1]: found inf, expected a number above 0"},
      {"/area_km/1", 20001, "area_km[1]: found 20001, expected a number above 0 and at most 20000"},
      {"/interval_min", 0,
       "interval_min: found 0, expected a number above 0 and at most limit_min"},
      {"/interval_min", 181,
       "interval_min: found 181, expected a number above 0 and at most limit_min (180)"},
      {"/interval_min", true, "interval_min: found true, expected a number"},
      {"/interval_min", 1e-6, "interval_min: found 1e-06, expected at most 1000000 intervals"},
      {"/limit_min", -180, "limit_min: found -180, expected a number in [0, 1000000000]"},
      {"/limit_min", 0, "limit_min: found 0, expected a number above 0"},
      {"/limit_min", 1e300, "limit_min: found 1e+300, expected a number in [0, 1000000000]"},
      {"/start", 1263333190, "start: found 1263333190, expected a string"},
      {"/start", "2010-01-16T09:00:00",
       "start: found \"2010-01-16T09:00:00\", expected ISO 8601 with seconds and an offset or Z, "
       "of the years 1900 to 2199, like 2010-01-16T09:00:00-05:00"},
      {"/start", "", "start: found \"\", expected ISO 8601"},
      {"/start", "3010-01-16T09:00:00Z", "start: found \"3010-01-16T09:00:00Z\", expected ISO"},
      {"/origin",
       {{"latitude_deg", 91}, {"longitude_deg", 0}},
       "origin.latitude_deg: found 91, expected a number in [-90, 90]"},
      {"/origin",
       {{"latitude_deg", 1}, {"longitude_deg", -181}},
       "origin.longitude_deg: found -181, expected a number in [-180, 180]"},
      {"/origin", {{"latitude_deg", 1}}, "origin.longitude_deg: found no such key"},
      {"/rules", 3, "rules: found 3, expected an object"},
      {"/rules",
       {{"availability", "lax"}},
       "rules.availability: found \"lax\", expected \"strict\" or \"overrun\""},
      {"/rules",
       {{"tick_s", 7}},
       "rules.tick_s: found 7, expected a number of seconds that divides interval_min (10)"},
      {"/rules", {{"tick_s", 0}}, "rules.tick_s: found 0, expected"},
      {"/rules", {{"tick_s", 1200}}, "rules.tick_s: found 1200, expected"},
      {"/rules", {{"mean_over_all", 1}}, "rules.mean_over_all: found 1, expected true or false"},
      {"/disturbances",
       {{"wind", {0.4, 0.1}}},
       "disturbances.wind[0]: found 0.4, expected a number in [0, 0.1]"},
      {"/disturbances", {{"wind", 0.4}}, "disturbances.wind: found 0.4, expected an array"},
      {"/disturbances",
       {{"wind", {0.4}}},
       "disturbances.wind: found an array of 1, expected [low, high]"},
      {"/disturbances",
       {{"communication_km", {-1, 2}}},
       "disturbances.communication_km[0]: found -1, expected a number in [0, 2]"},
      {"/disturbances",
       {{"communication_km", {0, 1e6}}},
       "disturbances.communication_km[1]: found 1000000, expected a number in [0, 100000]"},
      {"/disturbances",
       {{"wind", {0, 1001}}},
       "disturbances.wind[1]: found 1001, expected a number in [0, 1000]"},
      {"/disturbances",
       {{"agent_failure", {0, 1.5}}},
       "disturbances.agent_failure[1]: found 1.5, expected a number in [0, 1]"},
      {"/disturbances",
       {{"match_failure", {"a", 1}}},
       "disturbances.match_failure[0]: found \"a\", expected a number"},
  };
  ExpectRefused(cases);
}

TEST(ScenarioJson, NamesKeyFoundAndExpectedOfPlacesAndAgents) {
  const BadValue cases[] = {
      {"/uavs/0/speed", 1, "uavs[0]: found the unknown key \"speed\", expected only id, x_km"},
      {"/workers/0/range_km", 1, "workers[0]: found the unknown key \"range_km\""},
      {"/tasks", kRemoved, "tasks: found no such key, expected an array"},
      {"/uavs/0/range_km", kRemoved, "uavs[0].range_km: found no such key, expected a number"},
      {"/vehicles/0/id", kRemoved, "vehicles[0].id: found no such key, expected an integer"},
      {"/uavs", json::array(), "uavs: found an empty array, expected at least one element"},
      {"/workers", json::array(), "workers: found an empty array, expected at least one element"},
      {"/vehicles", json::array(), "vehicles: found an empty array, expected at least one element"},
      {"/tasks", json::array(), "tasks: found an empty array, expected at least one element"},
      {"/charging_points", json::array(),
       "charging_points: found an empty array, expected at least"},
      {"/uavs", json::object(), "uavs: found an object, expected an array"},
      {"/uavs/0", 3, "uavs[0]: found 3, expected an object"},
      {"/uavs/0/id", 1, "uavs[0].id: found 1, expected 0 (ids count from 0"},
      {"/tasks/1/id", 0, "tasks[1].id: found 0 again, expected 1 (ids count from 0"},
      {"/charging_points/2/id", 3, "charging_points[2].id: found 3, expected 2"},
      {"/workers/0/id", -1, "workers[0].id: found -1, expected an integer in [0, 2147483647]"},
      {"/workers/0/id", 0.5, "workers[0].id: found 0.5, expected an integer"},
      {"/uavs/0/x_km", -0.001, "uavs[0].x_km: found -0.001, expected a number in [0, 4]"},
      {"/workers/0/y_km", 3.501, "workers[0].y_km: found 3.501, expected a number in [0, 3.5]"},
      {"/tasks/1/x_km", 5, "tasks[1].x_km: found 5, expected a number in [0, 4]"},
      {"/charging_points/0/y_km", 9,
       "charging_points[0].y_km: found 9, expected a number in [0, 3.5]"},
      {"/vehicles/0/x_km", nullptr, "vehicles[0].x_km: found null, expected a number"},
      {"/uavs/0/speed_km_per_min", 0,
       "uavs[0].speed_km_per_min: found 0, expected a number in [1e-05, 1000000]"},
      {"/workers/0/speed_km_per_min", -1,
       "workers[0].speed_km_per_min: found -1, expected a number in [1e-05, "},
      {"/workers/0/speed_km_per_min", 9e-6, "workers[0].speed_km_per_min: found "},
      {"/vehicles/0/speed_km_per_min", 1000001, "vehicles[0].speed_km_per_min: found 1000001"},
      {"/vehicles/0/charge_km_per_min", 0,
       "vehicles[0].charge_km_per_min: found 0, expected a number in [1e-05, 1000000]"},
      {"/vehicles/0/charge_km_per_min", 1e-9,
       "vehicles[0].charge_km_per_min: found 1e-09, expected a number in [1e-05, 1000000]"},
      {"/uavs/0/full_range_km", 0,
       "uavs[0].full_range_km: found 0, expected a number above 0 and at most 100000"},
      {"/uavs/0/full_range_km", 1e300, "uavs[0].full_range_km: found 1e+300, expected"},
      {"/uavs/0/range_km", 30.5, "uavs[0].range_km: found 30.5, expected a number in [0, 30]"},
      {"/uavs/0/range_km", -1, "uavs[0].range_km: found -1, expected a number in [0, 30]"},
      {"/uavs/0/online_from_min", -5,
       "uavs[0].online_from_min: found -5, expected a number in [0,"},
      {"/workers/0/online_until_min", 1,
       "workers[0].online_until_min: found 1, expected a number in [1.5 (online_from_min), "},
      {"/tasks/0/cost_km", -3, "tasks[0].cost_km: found -3, expected a number in [0, 100000]"},
      {"/tasks/0/cost_km", 100001, "tasks[0].cost_km: found 100001, expected"},
      {"/charging_points/1/capacity", 0,
       "charging_points[1].capacity: found 0, expected an integer in [1, 2147483647]"},
      {"/charging_points/1/capacity", 1.5,
       "charging_points[1].capacity: found 1.5, expected an integer"},
      {"/charging_points/1/capacity", "many",
       "charging_points[1].capacity: found \"many\", expected"},
  };
  ExpectRefused(cases);
}

TEST(ScenarioJson, TheEdgeOfWhatIsPossibleIsPossible) {
  const std::pair<const char*, json> edges[] = {
      {"/origin", {{"latitude_deg", 90}, {"longitude_deg", 180}}},
      {"/origin", {{"latitude_deg", -90}, {"longitude_deg", -180}}},
      {"/limit_min", 10},
      {"/limit_min", 1e9},  // with intervals of a thousand minutes, below
      {"/interval_min", 180},
      {"/interval_min", 0.00018},  // a million decisions
      {"/rules", {{"tick_s", 600}}},
      {"/disturbances", {{"wind", {0, 0}}}},
      {"/disturbances", {{"wind", {0.4, 0.4}}}},
      {"/disturbances", {{"agent_failure", {0, 1}}}},
      {"/disturbances", {{"match_failure", {1, 1}}}},
      {"/seed", 0},
      {"/uavs/0/x_km", 0},
      {"/uavs/0/x_km", 4},
      {"/uavs/0/y_km", 3.5},
      {"/uavs/0/range_km", 0},
      {"/uavs/0/range_km", 30},
      {"/uavs/0/online_until_min", 1e9},
      {"/workers/0/online_until_min", 1.5},
      {"/area_km", {20000, 20000}},
      {"/uavs/0/speed_km_per_min", 1e-5},
      {"/uavs/0/speed_km_per_min", 1e6},
      {"/vehicles/0/charge_km_per_min", 1e-5},
      {"/vehicles/0/charge_km_per_min", 1e6},
      {"/uavs/0/full_range_km", 1e5},
      {"/disturbances", {{"wind", {0, 1000}}, {"communication_km", {0, 1e5}}}},
      {"/tasks/0/cost_km", 0},
      {"/tasks/0/cost_km", 1e5},
      {"/charging_points/1/capacity", 1},
      {"/charging_points/1/capacity", 2147483647},
  };
  for (const auto& [pointer, value] : edges) {
    json file = json::parse(kSmall);
    file[json::json_pointer(pointer)] = value;
    if (value == 1e9 && std::string(pointer) == "/limit_min") file["interval_min"] = 1000;
    if (value == 0.00018) file["rules"] = {{"tick_s", 0.0108}};
    EXPECT_EQ(ErrorOf(file.dump()), "no error") << pointer << " " << value;
  }
  // What a scenario made in memory may hold and a file cannot.
  const Scenario small = ParseScenario(kSmall, "f.json");
  const auto error = [&](const std::function<void(Scenario*)>& edit) {
    Scenario scenario = small;
    edit(&scenario);
    try {
      ValidateScenario(scenario, "made");
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const TimeUs longest = 1'000'000'000 * kMinuteUs;
  EXPECT_EQ(error([](Scenario*) {}), "");
  EXPECT_EQ(error([&](Scenario* s) { s->uavs[0].online_until_us = longest; }), "");
  EXPECT_EQ(error([&](Scenario* s) {
              s->uavs[0].online_until_us = longest + 1;
            }).find("made: uavs[0].online_until_min: found"),
            0u);
  EXPECT_EQ(error([&](Scenario* s) {
              s->uavs[0].online_from_us = s->uavs[0].online_until_us = longest + 1;
            }).find("made: uavs[0].online_from_min: found"),
            0u);
  EXPECT_EQ(error([](Scenario* s) {
              s->uavs[0].online_from_us = -1;
            }).find("made: uavs[0].online_from_min: found"),
            0u);
  EXPECT_EQ(
      error([&](Scenario* s) { s->rules.limit_us = longest + 1; }).find("made: limit_min: found"),
      0u);
  EXPECT_EQ(error([](Scenario* s) {
              s->charging_points[1].capacity = 0;
            }).find("made: charging_points[1].capacity: found 0"),
            0u);
  EXPECT_EQ(error([](Scenario* s) { s->rules.tick_us = -30; }).find("made: rules.tick_s: found"),
            0u);
  EXPECT_EQ(error([](Scenario* s) {
              s->tasks[1].cost_m = HUGE_VAL;
            }).find("made: tasks[1].cost_km: found inf, expected a number in"),
            0u);
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ScenarioJson, SaysLineAndColumnOfMalformedText) {
  const auto starts = [](const std::string& text, const std::string& message) {
    const std::string error = ErrorOf(text);
    EXPECT_EQ(error.find("f.json: " + message), 0u) << error;
  };
  starts("{\n  \"version\": 1,\n  oops }", "line 3, column 3: found '");
  starts("", "line 1, column ");
  starts("[", "line 1, column ");
  starts("{\"version\": 1} x", "line 1, column 16: found ");
  starts(Replaced(kSmall, "12.25", "NaN"), "line 5, column ");
  starts(Replaced(kSmall, "12.25", "Infinity"), "line 5, column ");
  starts(Replaced(kSmall, "12.25", "1e999"), "line 5, column ");
  EXPECT_NE(ErrorOf(Replaced(kSmall, "12.25", "1e999")).find("number overflow"), std::string::npos);
}

TEST(ScenarioJson, RefusesAKeyGivenTwice) {
  EXPECT_EQ(ErrorOf(Replaced(kSmall, "\"range_km\"", "\"x_km\": 1, \"range_km\"")),
            "f.json: uavs[0].x_km: found the key twice, expected each key once");
  EXPECT_EQ(ErrorOf(Replaced(kSmall, "\"interval_min\"", "\"name\": \"b\", \"interval_min\"")),
            "f.json: name: found the key twice, expected each key once");
}

TEST(ScenarioJson, RefusesDeepNestingWithoutExhaustingTheStack) {
  EXPECT_NE(ErrorOf(std::string(1'000'000, '[')).find("nested deeper"), std::string::npos);
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  EXPECT_NE(ErrorOf(objects).find("nested deeper"), std::string::npos);
}

TEST(ScenarioJson, RefusesEveryTruncation) {
  const std::string text = ScenarioToJson(ParseScenario(kSmall, "f.json"));
  const std::size_t end = text.rfind('}');
  for (std::size_t n = 0; n <= end; ++n) {
    EXPECT_NE(ErrorOf(text.substr(0, n)), "no error") << n;
  }
  EXPECT_EQ(ErrorOf(text.substr(0, end + 1)), "no error");
}

TEST(ScenarioJson, GarbageEndsInAnInputErrorOrAValidScenario) {
  constexpr std::uint64_t kSeed = 5;
  const std::string text = ScenarioToJson(ParseScenario(kSmall, "f.json"));
  for (std::uint32_t round = 0; round < 20'000; ++round) {
    Random random(kSeed, Stream::kTest, round);
    std::string changed = text;
    const std::uint32_t edits = 1 + random.Below(4);
    for (std::uint32_t i = 0; i < edits; ++i) {
      const auto at = random.Below(static_cast<std::uint32_t>(changed.size()));
      switch (random.Below(3)) {
        case 0:
          changed[at] = static_cast<char>(random.Below(256));
          break;
        case 1:
          changed.erase(at, random.Below(20));
          break;
        default:
          changed.insert(at, text.substr(random.Below(static_cast<std::uint32_t>(text.size())), 8));
      }
    }
    try {
      const Scenario scenario = ParseScenario(changed, "f.json");
      EXPECT_NO_THROW(ParseScenario(ScenarioToJson(scenario), "again")) << changed;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).rfind("f.json: ", 0), 0u);
      EXPECT_LT(std::strlen(error.what()), 500u) << "seed " << kSeed << " round " << round;
    }
  }
}

/// A scenario of arbitrary doubles, as no file in round numbers would have.
Scenario Arbitrary(std::uint64_t seed, std::size_t agents) {
  Random random(seed, Stream::kTest);
  Scenario s;
  s.name = "a \"name\"\n\xC3\xA9";
  s.seed = seed;
  s.width_m = random.Uniform(1000, 50000);
  s.height_m = random.Uniform(1000, 50000);
  s.origin = Origin{random.Uniform(-90, 90), random.Uniform(-180, 180)};
  s.rules.interval_us = 1 + random.Below(1'000'000'000);
  s.rules.tick_us = s.rules.interval_us;
  s.rules.limit_us = s.rules.interval_us + random.Below(2'000'000'000);
  s.disturbances.wind = {random.Uniform(0, 0.1), random.Uniform(0.1, 0.5)};
  s.disturbances.communication_m = {random.Uniform(0, 100), random.Uniform(100, 500)};
  const auto point = [&] {
    return Point{random.Uniform(0, s.width_m), random.Uniform(0, s.height_m)};
  };
  const auto agent = [&](AgentKind kind) {
    AgentSpec a;
    a.at = point();
    a.speed_m_s = random.Uniform(0.001, 40);
    a.online_from_us = random.Below(4'000'000'000);
    a.online_until_us = a.online_from_us + std::int64_t{random.Below(4'000'000'000)} * 1000;
    if (kind == AgentKind::kUav) {
      a.range_full_m = random.Uniform(1, 50000);
      a.range_m = random.Uniform(0, a.range_full_m);
    }
    if (kind == AgentKind::kVehicle) a.charge_rate_m_s = random.Uniform(0.001, 300);
    return a;
  };
  for (std::size_t i = 0; i < agents; ++i) s.uavs.push_back(agent(AgentKind::kUav));
  for (std::size_t i = 0; i < agents; ++i) s.workers.push_back(agent(AgentKind::kWorker));
  for (std::size_t i = 0; i < agents; ++i) s.vehicles.push_back(agent(AgentKind::kVehicle));
  for (std::size_t i = 0; i < agents; ++i) s.tasks.push_back({point(), random.Uniform(0, 5000)});
  s.charging_points = {{point(), 1}, {point(), 7}, {point(), std::nullopt}};
  return s;
}

TEST(ScenarioJson, RoundTripIsBitExactForAnyDoubles) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    const Scenario s = Arbitrary(seed, 500);
    const std::string text = ScenarioToJson(s);
    const Scenario again = ParseScenario(text, "again");
    ExpectSame(s, again);
    EXPECT_EQ(ScenarioToJson(again), text);
  }
}

TEST(ScenarioJson, WritesRoundNumbersShort) {
  const std::string text = ScenarioToJson(ParseScenario(kSmall, "f.json"));
  for (const char* part :
       {"\"speed_km_per_min\": 1.2,", "\"charge_km_per_min\": 10,", "\"range_km\": 12.25,",
        "\"online_until_min\": 61.5", "\"capacity\": null", "\"capacity\": 4", "\"tick_s\": 30,",
        "\"wind\": [0, 0]", "\"area_km\": [4, 3.5]"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  }
}

TEST(ScenarioJson, NegativeZeroBecomesZero) {
  const Scenario s = ParseScenario(Replaced(kSmall, "\"x_km\": 0,", "\"x_km\": -0.0,"), "f.json");
  EXPECT_FALSE(std::signbit(s.vehicles[0].at.x_m));
  Scenario in_memory = s;
  in_memory.vehicles[0].at.x_m = -0.0;
  EXPECT_EQ(ScenarioToJson(in_memory), ScenarioToJson(s));
}

TEST(ScenarioJson, ReadsFortyThousandAgents) {
  const Scenario s = Arbitrary(9, 13'334);
  const Scenario again = ParseScenario(ScenarioToJson(s), "large");
  EXPECT_EQ(again.uavs.size() + again.workers.size() + again.vehicles.size(), 40'002u);
}

TEST(ScenarioJson, ValidatesScenariosBuiltInMemory) {
  const auto error = [](const auto& change) -> std::string {
    Scenario s = ParseScenario(kSmall, "f.json");
    change(s);
    try {
      ValidateScenario(s, "memory");
    } catch (const InputError& e) {
      return e.what();
    }
    return "no error";
  };
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error([](Scenario&) {}), "no error");
  EXPECT_EQ(error([&](Scenario& s) { s.uavs[0].at.x_m = nan; }),
            "memory: uavs[0].x_km: found nan, expected a number in [0, 4]");
  EXPECT_EQ(error([&](Scenario& s) { s.tasks[1].cost_m = inf; }),
            "memory: tasks[1].cost_km: found inf, expected a number in [0, 100000]");
  EXPECT_EQ(
      error([&](Scenario& s) { s.workers[0].speed_m_s = nan; }),
      "memory: workers[0].speed_km_per_min: found nan, expected a number in [1e-05, 1000000]");
  EXPECT_EQ(
      error([&](Scenario& s) { s.charging_points[0].capacity = 0; }),
      "memory: charging_points[0].capacity: found 0, expected an integer of at least 1, or null");
  EXPECT_EQ(error([&](Scenario& s) { s.rules.tick_us = 7 * kSecondUs; }),
            "memory: rules.tick_s: found 7, expected a number of seconds that divides interval_min "
            "(10)");
  EXPECT_EQ(error([&](Scenario& s) { s.vehicles[0].online_until_us = kNever; }).substr(0, 45),
            "memory: vehicles[0].online_until_min: found 1");
}

TEST(ScenarioJson, LoadsFilesAndSaysWhyItCannot) {
  const TemporaryFolder folder;
  const std::string path = folder.File("scenario.json");
  std::ofstream(path) << kSmall;
  EXPECT_EQ(LoadScenario(path).name, "small");
  std::ofstream(path, std::ios::trunc).close();
  EXPECT_THROW(LoadScenario(path), InputError);
  std::remove(path.c_str());
  EXPECT_THROW(LoadScenario(path), InputError);
  EXPECT_THROW(LoadScenario(folder.path()), InputError);
}

std::string ReadAll(const std::string& path) {
  std::ifstream in(path);
  EXPECT_TRUE(in) << path;
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(ScenarioJson, TheDocumentationsExamplesAreValid) {
  const std::string page = ReadAll(MUSTER_SOURCE_DIR "/docs/reference/scenario-format.md");
  std::vector<Scenario> examples;
  for (std::size_t begin = 0; (begin = page.find("```json\n", begin)) != page.npos;) {
    const std::size_t end = page.find("```", begin + 8);
    examples.push_back(ParseScenario(page.substr(begin + 8, end - begin - 8), "an example"));
    begin = end + 3;
  }
  ASSERT_EQ(examples.size(), 2u);
  EXPECT_EQ(examples[0].name, "small");
  EXPECT_EQ(examples[0].disturbances.wind.high, 0.4);
  EXPECT_FALSE(examples[0].IsOpen());
  EXPECT_TRUE(examples[1].IsOpen());
  const Task& task = examples[1].tasks.at(1);
  EXPECT_EQ(task.external_id, "A-17");
  // As the page says of it.
  EXPECT_EQ(WorthOf(task, 30 * kMinuteUs, examples[1].rules), 4);
  EXPECT_EQ(WorthOf(task, 30 * kMinuteUs + 1, examples[1].rules), 2);
  EXPECT_FALSE(task.AllowsStart(60 * kMinuteUs));
  EXPECT_EQ(examples[1].rules, Rules());  // its rules are the defaults that the page names
}

TEST(ScenarioJson, ReadyMadeScenariosAreWhatTheirCommandsWrite) {
  const std::string random_1 = ReadAll(MUSTER_SOURCE_DIR "/scenarios/random_1.json");
  EXPECT_EQ(random_1, ScenarioToJson(Generate(PresetByName("Random_1"), 1)));
  const std::string haiti = ReadAll(MUSTER_SOURCE_DIR "/scenarios/haiti.json");
  EXPECT_EQ(haiti, ScenarioToJson(ParseScenario(haiti, "haiti.json")));
}

Scenario OnRoads() {
  Scenario scenario = Generate(PresetByName("Random_10"), 1);
  ScenarioRoads roads;
  roads.file = "grid.roads.json";
  roads.text = RoadsToJson(StreetGrid(4, 2000, 1));
  roads.open_ground = {{}, {40, 500}, {0, 0}};
  UseRoads(std::move(roads), "grid.roads.json", &scenario);
  return scenario;
}

TEST(ScenarioRoads, AreReadAsTheyWereWritten) {
  const ScenarioText text = TextOf(OnRoads());
  const Scenario read = ParseScenario(text, "s.json");
  EXPECT_EQ(ScenarioToJson(read), text.json);
  EXPECT_FALSE(read.ways->straight(AgentKind::kWorker));
  EXPECT_TRUE(read.ways->straight(AgentKind::kUav));
  EXPECT_EQ(read.roads->open_ground.workers.percent, 40);
  EXPECT_EQ(read.roads->open_ground.vehicles.reach_m, 0);
  // Scenarios with the same roads and sites share what was found on them.
  EXPECT_EQ(read.ways, ParseScenario(text, "s.json").ways);
}

TEST(ScenarioRoads, AreRefusedWhereTheyAreNotThoseThatAreNamed) {
  const ScenarioText text = TextOf(OnRoads());
  const auto error = [](const ScenarioText& from) {
    try {
      ParseScenario(from, "s.json");
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(error({text.json}), "s.json: roads: found no road file, expected grid.roads.json");
  EXPECT_EQ(error({text.json, text.roads + " "})
                .rfind("s.json: roads.sha256: the road file grid.roads.json has ", 0),
            0u);
  const auto with = [&](const std::string& before, const std::string& after) {
    std::string changed = text.json;
    changed.replace(changed.find(before), before.size(), after);
    return error({changed, text.roads});
  };
  EXPECT_NE(with("grid.roads.json", "a/b.roads.json").find("roads.file"), std::string::npos);
  EXPECT_NE(with("grid.roads.json", "grid.json").find("*.roads.json"), std::string::npos);
  EXPECT_NE(with("\"percent\": 40", "\"percent\": 140").find("open_ground.workers.percent"),
            std::string::npos);
  EXPECT_NE(with("\"version\": 2", "\"version\": 1").find("in version 1"), std::string::npos);
}

}  // namespace
}  // namespace muster
