// Long runs: each process of a mission held by a signal for 1, 5 and 20 s at random ticks, in both
// modes. MUSTER_MISSIONS says how many missions (default 50).
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "base/random.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "scheduler/policies/registry.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/launch/live_log.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

class LongFreezeTest : public ::testing::Test {
 protected:
  void SetUp() override { MUSTER_NEEDS_MULTICAST(); }
  Json Report(const std::string& name) const {
    return Json::parse(TextOf(folder_.File(name) + "/report.json"), nullptr, false);
  }

  TemporaryFolder folder_;
  std::string scenario_ = folder_.File("scenario.json");
};

TEST_F(LongFreezeTest, WhoeverIsHeldAtAnyTickComesBackOrIsLeftBehind) {
  // Where lcm-logger writes, the launcher is the mission's recorder, too.
  constexpr std::array kVictims = {"world",     "uav",      "worker", "vehicle",
                                   "scheduler", "launcher", "logger"};
  constexpr std::array kHeld_s = {1, 5, 20};
  std::ofstream(scenario_) << ScenarioToJson(Generate(PresetByName("Random_1"), 1));
  // A scheduler is held while it decides, too.
  const std::string policy(scheduler::kDefaultPolicy);
  Muster simulate(
      folder_, "simulate",
      {"simulate", scenario_, "--policy", policy, "--quiet", "--out", folder_.File("simulated")});
  ASSERT_EQ(simulate.Wait(), 0) << simulate.output();
  const Json expected = Report("simulated")["digest"];
  const char* const text = std::getenv("MUSTER_MISSIONS");
  const int missions = text == nullptr ? 50 : std::atoi(text);
  for (int i = 0; i < missions; ++i) {
    const std::string victim = kVictims[static_cast<std::size_t>(i) % kVictims.size()];
    const int held_s = kHeld_s[static_cast<std::size_t>(i) / kVictims.size() % kHeld_s.size()];
    const bool lcm = i % 2 == 1;
    const bool goes_on = static_cast<std::size_t>(i) / kVictims.size() / kHeld_s.size() % 2 == 0;
    Random random(static_cast<std::uint64_t>(i), Stream::kTest);
    const std::int64_t at = 5 + random.Below(350);  // of 361 ticks
    SCOPED_TRACE(fmt::format("mission {}: {} held for {} s at tick {}, {}, {}", i, victim, held_s,
                             at, goes_on ? "continue" : "wait", lcm ? "lcm-logger" : "recorder"));
    Muster muster(folder_, "run",
                  {"run", scenario_, "--policy", policy, "--quiet", "--out", folder_.File("run"),
                   "--rate", "3600", "--on-loss", goes_on ? "continue" : "wait", "--lost-after",
                   "3", "--logger", lcm ? "lcm" : "muster"});
    LiveLog log(folder_.File("run"));
    const auto pid = [&] {
      if (victim == "launcher") return muster.child().pid();
      if (victim != "logger") return log.pid(victim);
      return lcm ? ChildOf(muster.child().pid(), "lcm-logger") : log.pid("recorder");
    };
    ASSERT_TRUE(Eventually([&] {
      log.Read();
      return (log.tick() >= at && pid() > 0) || muster.child().Poll();
    }));
    ASSERT_FALSE(muster.child().Poll()) << muster.output();
    ASSERT_EQ(kill(pid(), SIGSTOP), 0);
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(held_s);
    while (std::chrono::steady_clock::now() < end && !muster.child().Poll()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    if (!muster.child().Poll()) kill(pid(), SIGCONT);
    ASSERT_EQ(muster.Wait(std::chrono::minutes(3)), 0) << muster.output();
    const Json report = Report("run");
    EXPECT_TRUE(report["log"]["complete"].get<bool>()) << report["log"];
    const bool may_be_lost =
        goes_on && held_s > 3 && victim != "world" && victim != "launcher" && victim != "logger";
    if (may_be_lost) {
      for (const char* const other : kVictims) {
        if (other == victim) continue;
        EXPECT_EQ(muster.output().find(fmt::format("{} has been silent", other)), std::string::npos)
            << muster.output();
      }
    } else {
      EXPECT_EQ(report["digest"], expected) << muster.output();
      EXPECT_EQ(report["events"]["process_lost"], 0) << muster.output();
    }
    std::filesystem::remove_all(folder_.File("run"));
  }
}

}  // namespace
}  // namespace muster::tools
