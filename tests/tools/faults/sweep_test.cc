// Long runs: every process killed at a hundred ticks, and random plans without end. MUSTER_MISSIONS
// says how many missions each test runs (default 100 and 200); each is audited.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "base/random.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

/// A mission of seconds may take minutes under a sanitizer on a busy machine.
constexpr std::chrono::minutes kLongestMission{15};

int Missions(int usual) {
  const char* text = std::getenv("MUSTER_MISSIONS");
  return text == nullptr ? usual : std::atoi(text);
}

/// Who writes the log of that mission: each in turn.
const char* LoggerOf(int mission) { return mission % 2 == 0 ? "muster" : "lcm"; }

class LongSweepTest : public ::testing::Test {
 protected:
  void SetUp() override { MUSTER_NEEDS_MULTICAST(); }
  void Write(const Scenario& scenario) { std::ofstream(scenario_) << ScenarioToJson(scenario); }
  Json Report(const std::string& name) const {
    return Json::parse(TextOf(folder_.File(name) + "/report.json"), nullptr, false);
  }

  TemporaryFolder folder_;
  std::string scenario_ = folder_.File("scenario.json");
};

TEST_F(LongSweepTest, AnyOneProcessKilledAtAnyTickChangesNothing) {
  Write(Generate(PresetByName("Random_1"), 1));
  Muster simulate(
      folder_, "simulate",
      {"simulate", scenario_, "--quiet", "--policy", "mpq", "--out", folder_.File("simulated")});
  ASSERT_EQ(simulate.Wait(), 0) << simulate.output();
  const Json expected = Report("simulated")["digest"];
  // Each once a mission, in an order of its own: a sixth of the mission for each.
  for (int i = 0; i < Missions(100); ++i) {
    Random random(static_cast<std::uint64_t>(i), Stream::kTest);
    std::vector<std::string> victims = {"uav",       "worker", "vehicle",
                                        "scheduler", "world",  "lcm-logger"};
    random.Shuffle(victims);
    std::vector<std::string> arguments = {"run",      scenario_, "--quiet",           "--policy",
                                          "mpq",      "--out",   folder_.File("run"), "--logger",
                                          LoggerOf(i)};
    for (std::size_t k = 0; k < victims.size(); ++k) {
      const double at_min = 0.5 * static_cast<double>(60 * k + random.Below(60));
      arguments.insert(arguments.end(),
                       {"--fault", fmt::format("process_killed:{}@{}", victims[k], at_min)});
    }
    SCOPED_TRACE(fmt::format("{}", fmt::join(arguments, " ")));
    Muster muster(folder_, "run", arguments);
    ASSERT_EQ(muster.Wait(kLongestMission), 0) << muster.output();
    const Json report = Report("run");
    ASSERT_EQ(report["digest"], expected);
    ASSERT_TRUE(report["log"]["complete"].get<bool>()) << report["log"];
    ASSERT_EQ(report["events"]["process_lost"], 6);
    std::filesystem::remove_all(folder_.File("run"));
  }
}

TEST_F(LongSweepTest, RandomPlansBreakNoInvariant) {
  for (int seed = 1; seed <= Missions(200); ++seed) {
    SCOPED_TRACE(seed);
    GeneratorSettings settings = PresetByName("Random_10");
    settings.rules.limit_us = 90 * kMinuteUs;
    Write(Generate(settings, static_cast<std::uint64_t>(seed)));
    const bool goes_on = seed % 2 == 0;
    const std::string on_loss = goes_on ? "continue" : "wait";
    Muster draw(folder_, "plan.json",
                {"faults", "random", scenario_, "--seed", std::to_string(seed), "--rate", "6",
                 "--on-loss", on_loss});
    ASSERT_EQ(draw.Wait(), 0) << draw.output();
    const std::string plan = folder_.File("plan.json");
    std::ofstream(plan) << draw.output();
    Muster run(
        folder_, "run",
        {"run", scenario_, "--quiet", "--policy", "mpq", "--out", folder_.File("run"), "--faults",
         plan, "--on-loss", on_loss, "--lost-after", "0.5", "--logger", LoggerOf(seed / 2)});
    ASSERT_EQ(run.Wait(kLongestMission), 0) << run.output() << draw.output();
    std::filesystem::remove_all(folder_.File("run"));
  }
}

}  // namespace
}  // namespace muster::tools
