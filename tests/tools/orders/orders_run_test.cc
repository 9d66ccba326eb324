// Orders to missions of real processes over LCM.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/faults/mission_test.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class OrdersRunTest : public MissionTest {
 protected:
  std::string Run() const { return folder_.File("run"); }
  /// A command and its exit code.
  int Command(const std::vector<std::string>& arguments, std::string* output = nullptr) {
    Muster muster(folder_, fmt::format("command-{}", commands_++), arguments);
    const int code = muster.Wait();
    if (output != nullptr) *output = muster.output();
    return code;
  }
  std::string DigestOfCaptured() {
    std::string lines, said;
    const std::string scenario = folder_.File("before.json"),
                      orders = folder_.File("captured.jsonl");
    EXPECT_EQ(Command({"log", "orders", Run(), "--scenario", scenario}, &lines), 0) << lines;
    std::ofstream(orders) << lines;
    EXPECT_EQ(Command({"simulate", scenario, "--orders", orders, "--quiet", "--out",
                       folder_.File("again")},
                      &said),
              0)
        << said;
    return Report("again")["digest"];
  }
  int commands_ = 0;
};

TEST_F(OrdersRunTest, WhatIsAskedWhileItRunsIsTakenLoggedAndPlayedAgain) {
  Muster mission(folder_, "mission",
                 {"run", scenario_, "--quiet", "--take-orders", "--rate", "400", "--limit", "60",
                  "--out", Run()});
  ASSERT_TRUE(Eventually([&] { return fs::exists(Run() + "/orders.sock"); })) << mission.output();
  std::string output;
  EXPECT_EQ(Command({"task", "add", Run(), "--at", "3,4", "--priority", "emergency", "--due-in",
                     "20", "--name", "School"},
                    &output),
            0)
      << output;
  EXPECT_NE(output.find("task_add task 120"), std::string::npos) << output;
  // A log that grows all the time: one snapshot is of now, not of the mission's end.
  EXPECT_EQ(Command({"top", Run(), "--once"}, &output), 0) << output;
  EXPECT_EQ(output.find(", ended"), std::string::npos) << output;
  EXPECT_EQ(Command({"task", "change", Run(), "120", "--due", "1:45"}, &output), 0) << output;
  EXPECT_EQ(Command({"task", "change", Run(), "120", "--due", "noon"}, &output), 2);
  EXPECT_NE(output.find("--due: found noon, expected a clock time, as 14:30"), std::string::npos)
      << output;
  EXPECT_EQ(Command({"task", "change", Run(), "120", "--due", "1:45", "--due-in", "3"}, &output),
            2);
  EXPECT_EQ(Command({"task", "cancel", Run(), "5"}), 0);
  EXPECT_EQ(Command({"task", "cancel", Run(), "5"}, &output), 4);
  EXPECT_NE(output.find("refused: task 5 is cancelled"), std::string::npos) << output;
  EXPECT_EQ(Command({"task", "cancel", Run(), "5000"}), 4);
  EXPECT_EQ(Command({"agent", "join", Run(), "uav", "--at", "2,2", "--speed", "1", "--range", "30"},
                    &output),
            0);
  EXPECT_NE(output.find("uav:30"), std::string::npos) << output;
  EXPECT_EQ(Command({"agent", "recall", Run(), "worker:3"}), 0);
  EXPECT_EQ(Command({"direct", "pin", Run(), "uav:1", "worker:7", "--task", "5"}, &output), 4);
  EXPECT_NE(output.find("refused: task 5 is cancelled"), std::string::npos) << output;
  EXPECT_EQ(Command({"direct", "go", Run(), "vehicle:4", "--at", "15,15", "--id", "g"}), 0);
  EXPECT_EQ(Command({"direct", "forbid", Run(), "uav:2", "--task", "8"}), 0);
  EXPECT_EQ(Command({"direct", "forbid", Run(), "--class", "worker", "--circle", "9,9,1"}), 0);
  EXPECT_EQ(Command({"direct", "release", Run(), "--directive", "g"}), 0);
  EXPECT_EQ(Command({"decide", Run()}, &output), 0);
  EXPECT_NE(output.find("decide_now"), std::string::npos) << output;
  EXPECT_EQ(Command({"direct", "unpin", Run(), "--task", "9"}, &output), 4);
  EXPECT_NE(output.find("refused: task 9 is not pinned"), std::string::npos) << output;
  EXPECT_EQ(Command({"direct", "pin", Run(), "--task", "9"}, &output), 2);
  EXPECT_NE(output.find("AGENT: found nothing, expected a UAV, a worker or both"),
            std::string::npos)
      << output;
  EXPECT_EQ(Command({"direct", "pin", Run(), "uav:x", "--task", "9"}, &output), 2);
  EXPECT_NE(output.find("an agent, as \"uav:3\""), std::string::npos) << output;
  const std::string rows = folder_.File("rows.jsonl");
  std::ofstream(rows) << R"({"order": "task_add", "task": {"x_km": 1, "y_km": 1}})"
                      << "\n"
                      << R"({"order": "task_add", "task": {"x_km": 100, "y_km": 1}})"
                      << "\n"
                      << "nonsense\n"
                      << R"({"x": )" << std::string(1'000'000, '[') << std::string(1'000'000, ']')
                      << "}\n";
  EXPECT_EQ(Command({"feed", Run(), rows}, &output), 4);
  EXPECT_NE(output.find("1 taken, 3 refused"), std::string::npos) << output;
  ASSERT_EQ(mission.Wait(), 0) << mission.output();
  const Json report = Report();
  EXPECT_EQ(report["tasks_total"], 122);
  EXPECT_EQ(report["events"]["task_cancelled"], 1);
  EXPECT_EQ(report["events"]["agent_joined"], 1);
  EXPECT_FALSE(fs::exists(Run() + "/orders.sock"));
  EXPECT_EQ(DigestOfCaptured(), report["digest"]);
  EXPECT_EQ(Command({"task", "cancel", Run(), "5"}, &output), 2);
  EXPECT_NE(output.find("no mission runs here that takes orders"), std::string::npos) << output;
}

TEST_F(OrdersRunTest, AnyDeathInTheMiddleChangesNothing) {
  const std::string orders = folder_.File("orders.jsonl");
  std::ofstream out(orders);
  for (int i = 0; i < 60; ++i) {
    out << fmt::format(
               R"({{"id": "a{}", "at_min": {}, "order": "task_add", "task": {{"x_km": {}, "y_km": {}, "priority": {}}}}})",
               i, 2 * i, i % 30, (7 * i) % 29, i % 4)
        << "\n";
  }
  out << R"({"id": "j", "at_min": 25, "order": "agent_join", "class": "uav", "agent": {"x_km": 5, )"
      << R"("y_km": 5, "speed_km_per_min": 1, "full_range_km": 30}})"
      << "\n"
      << R"({"id": "l", "at_min": 40, "order": "agent_recall", "agent": "worker:2"})"
      << "\n"
      << R"({"id": "c", "at_min": 55, "order": "task_cancel", "task": 130})"
      << "\n";
  out.close();
  std::string said;
  ASSERT_EQ(
      Command({"simulate", scenario_, "--orders", orders, "--quiet", "--out", folder_.File("calm")},
              &said),
      0)
      << said;
  const std::pair<const char*, const char*> victims[] = {
      {"world", "uav"}, {"worker", "scheduler"}, {"recorder", "vehicle"}};
  for (const auto& [first, second] : victims) {
    SCOPED_TRACE(first);
    fs::remove_all(Run());
    Muster mission(folder_, "mission",
                   {"run", scenario_, "--quiet", "--orders", orders, "--out", Run(), "--rate",
                    "1800", "--fault", fmt::format("process_killed:{}@26", first), "--fault",
                    fmt::format("process_killed:{}@60.5", second)});
    ASSERT_EQ(mission.Wait(), 0) << mission.output();
    EXPECT_EQ(Report()["digest"], Report("calm")["digest"]) << mission.output();
    EXPECT_EQ(Report()["tasks_total"], 180);
    // The others know how things stand, and are heard at once.
    EXPECT_EQ(mission.output().find("no process answered"), std::string::npos) << mission.output();
  }
}

TEST_F(OrdersRunTest, AMissionWithoutTasksIsPlayedAgain) {
  Json scenario = Json::parse(TextOf(scenario_));
  scenario["version"] = 2;
  scenario["tasks"] = Json::array();
  scenario["room"] = {{"tasks", 5}};
  std::ofstream(scenario_) << scenario;
  const std::string orders = folder_.File("orders.jsonl");
  std::ofstream(orders) << R"({"at_min": 3, "order": "task_add", "task": {"x_km": 9, "y_km": 9}})"
                        << "\n"
                        << R"({"at_min": 9, "order": "task_add", "task": {"x_km": 4, "y_km": 8}})"
                        << "\n";
  ASSERT_EQ(Command({"run", scenario_, "--orders", orders, "--quiet", "--out", Run()}), 0);
  EXPECT_EQ(Report()["tasks_total"], 2);
  EXPECT_EQ(DigestOfCaptured(), Report()["digest"]);
}

TEST_F(OrdersRunTest, WhatIsNoOrderIsRefusedBeforeTheMission) {
  const std::string orders = folder_.File("orders.jsonl");
  std::ofstream(orders) << R"({"order": "task_add", "task": {"x_km": 1}})"
                        << "\n";
  std::string output;
  EXPECT_EQ(Command({"run", scenario_, "--orders", orders, "--out", Run()}, &output), 2);
  EXPECT_NE(output.find("orders.jsonl: line 1: task.y_km: found no such key, expected a number"),
            std::string::npos)
      << output;
  EXPECT_FALSE(fs::exists(Run()));
  EXPECT_EQ(Command({"run", scenario_, "--control"}), 2);
  EXPECT_EQ(Command({"run", scenario_, "--room", "task=5"}), 2);
  EXPECT_EQ(Command({"run", scenario_, "--take-orders", "--room", "boat=5"}), 2);
}

}  // namespace
}  // namespace muster::tools
