// Tasks with times and priorities: version 2 of the scenario file.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "base/check.h"
#include "model/feasibility.h"
#include "model/generator.h"
#include "model/scenario_json.h"

namespace muster {
namespace {

using nlohmann::json;

json Small() {
  return json::parse(R"({
  "version": 2, "name": "small", "seed": 1, "area_km": [4, 4], "interval_min": 10, "limit_min": 60,
  "rules": {"priority_worth": [0.25, 1, 3, 10], "late_worth": 0.4},
  "uavs": [{"id": 0, "x_km": 1, "y_km": 1, "speed_km_per_min": 1, "full_range_km": 30,
            "range_km": 12, "online_from_min": 0, "online_until_min": 60}],
  "workers": [{"id": 0, "x_km": 1, "y_km": 1, "speed_km_per_min": 0.5, "online_from_min": 0,
               "online_until_min": 60}],
  "vehicles": [{"id": 0, "x_km": 0, "y_km": 0, "speed_km_per_min": 1, "charge_km_per_min": 10,
                "online_from_min": 0, "online_until_min": 60}],
  "tasks": [{"id": 0, "x_km": 1, "y_km": 1, "cost_km": 3},
            {"id": 1, "x_km": 2, "y_km": 2, "cost_km": 1, "reported_min": 12.5, "priority": 3,
             "due_min": 30, "expires_min": 45, "name": "School \"North\"", "external_id": "A-17",
             "source": "hotline", "note": "Third floor,\nring twice"}],
  "charging_points": [{"id": 0, "x_km": 3, "y_km": 1}]})");
}

std::string ErrorOf(const json& scenario) {
  try {
    ParseScenario(scenario.dump(), "f.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(TimedTasks, AreReadInSiUnits) {
  const Scenario s = ParseScenario(Small().dump(), "f.json");
  EXPECT_TRUE(s.tasks[0].IsPlain());
  const Task& task = s.tasks[1];
  EXPECT_FALSE(task.IsPlain());
  EXPECT_EQ(task.reported_us, 750 * kSecondUs);
  EXPECT_EQ(task.due_us, 1800 * kSecondUs);
  EXPECT_EQ(task.expires_us, 2700 * kSecondUs);
  EXPECT_EQ(task.priority, Priority::kEmergency);
  EXPECT_EQ(task.name, "School \"North\"");
  EXPECT_EQ(task.external_id, "A-17");
  EXPECT_EQ(task.source, "hotline");
  EXPECT_EQ(task.note, "Third floor,\nring twice");
  EXPECT_EQ(s.rules.priority_worth[2], 3);
  EXPECT_EQ(s.rules.late_worth, 0.4);
}

TEST(TimedTasks, HaveNotesOfTwoThousandBytesAtMost) {
  json small = Small();
  small["tasks"][0]["note"] = std::string(2000, 'x');
  EXPECT_EQ(ErrorOf(small), "no error");
  small["tasks"][0]["note"] = std::string(2001, 'x');
  EXPECT_EQ(ErrorOf(small), "f.json: tasks[0].note: found 2001 bytes, expected at most 2000");
}

TEST(TimedTasks, SurviveWritingAndReading) {
  const std::string text = ScenarioToJson(ParseScenario(Small().dump(), "f.json"));
  EXPECT_EQ(json::parse(text)["version"], 2);
  EXPECT_EQ(ScenarioToJson(ParseScenario(text, "again")), text);
  const json task = Small()["tasks"][1];
  for (const auto& [key, value] : task.items()) {
    EXPECT_EQ(json::parse(text)["tasks"][1][key], value) << key;
  }
}

TEST(TimedTasks, WithoutAnyTheFileIsOfVersion1) {
  const Scenario generated = Generate(PresetByName("Random_1"), 1);
  EXPECT_FALSE(generated.IsOpen());
  const std::string text = ScenarioToJson(generated);
  json as_2 = json::parse(text);
  EXPECT_EQ(as_2["version"], 1);
  as_2["version"] = 2;
  EXPECT_EQ(ScenarioToJson(ParseScenario(as_2.dump(), "f.json")), text);
}

TEST(TimedTasks, PatienceIsARuleThatFilesMayHave) {
  json file = Small();
  EXPECT_EQ(ParseScenario(file.dump(), "f.json").rules.patience_us, 10 * kMinuteUs);
  file["rules"] = {{"patience_min", 2.5}};
  const Scenario s = ParseScenario(file.dump(), "f.json");
  EXPECT_EQ(s.rules.patience_us, 150 * kSecondUs);
  EXPECT_EQ(ScenarioToJson(ParseScenario(ScenarioToJson(s), "again")), ScenarioToJson(s));
  EXPECT_EQ(json::parse(ScenarioToJson(s))["rules"]["patience_min"], 2.5);
  Scenario plain = Generate(PresetByName("Random_1"), 1);
  plain.uavs[0].measured = true;
  EXPECT_TRUE(ParseScenario(ScenarioToJson(plain), "f.json").uavs[0].measured);
  EXPECT_FALSE(ParseScenario(ScenarioToJson(plain), "f.json").workers[0].measured);
  plain.uavs[0].measured = false;
  plain.rules.patience_us = 0;
  EXPECT_TRUE(plain.IsOpen());
}

TEST(TimedTasks, AreRefusedWhereTheyCannotBe) {
  struct {
    const char* at;
    json value;
    const char* message;
  } const cases[] = {
      {"/version", 3, "version: found 3, expected 1 or 2"},
      {"/version", 1, "rules: found the unknown key \"late_worth\""},
      {"/tasks/1/priority", 4, "tasks[1].priority: found 4, expected an integer in [0, 3]"},
      {"/tasks/1/priority", "high", "tasks[1].priority: found \"high\", expected an integer"},
      {"/tasks/1/reported_min", -1, "tasks[1].reported_min: found -1, expected a number in [0,"},
      {"/tasks/1/due_min", 12, "tasks[1].due_min: found 12, expected a number in [12.5 (reported"},
      {"/tasks/1/expires_min", 29, "tasks[1].expires_min: found 29, expected a number in [30 (due"},
      {"/tasks/0/expires_min", "soon", "tasks[0].expires_min: found \"soon\", expected a number"},
      {"/tasks/1/name", 5, "tasks[1].name: found 5, expected a string"},
      {"/tasks/1/urgent", true, "tasks[1]: found the unknown key \"urgent\""},
      {"/rules/late_worth", 1.5, "rules.late_worth: found 1.5, expected a number in [0, 1]"},
      {"/rules/patience_min", -1, "rules.patience_min: found -1, expected a number in [0,"},
      {"/rules/priority_worth", {1, 2}, "rules.priority_worth: found an array of 2, expected [low"},
      {"/rules/priority_worth/3", -1, "rules.priority_worth[3]: found -1, expected a number in [0"},
  };
  for (const auto& bad : cases) {
    json scenario = Small();
    scenario[json::json_pointer(bad.at)] = bad.value;
    EXPECT_NE(ErrorOf(scenario).find(bad.message), std::string::npos) << ErrorOf(scenario);
  }
  json old = Small();
  old["version"] = 1;
  old.erase("rules");
  EXPECT_NE(ErrorOf(old).find("tasks[1]: found the unknown key"), std::string::npos);
}

TEST(TimedTasks, AreWorthTheirPriorityAndLessWhenLate) {
  Rules rules;
  rules.priority_worth = {0.5, 1, 2, 4};
  rules.late_worth = 0.25;
  Task task;
  EXPECT_EQ(WorthOf(task, 1'000'000, rules), 1);
  task.priority = Priority::kEmergency;
  task.due_us = 100;
  EXPECT_EQ(WorthOf(task, 100, rules), 4);
  EXPECT_EQ(WorthOf(task, 101, rules), 1);
}

TEST(TimedTasks, CanBeBegunBeforeTheyExpire) {
  Task task;
  EXPECT_TRUE(CanBegin(task, 0, 1'000));
  EXPECT_FALSE(CanBegin(task, 0, kNever));
  task.expires_us = 1'500;
  EXPECT_TRUE(CanBegin(task, 500, 999));
  EXPECT_FALSE(CanBegin(task, 500, 1'000));
}

}  // namespace
}  // namespace muster
