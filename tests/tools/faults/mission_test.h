#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/generator.h"
#include "model/scenario_json.h"
#include "tests/base/sanitized.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {

/// By how much a sanitizer's build needs longer for a decision.
inline constexpr double kSlowness = kSanitized ? 8 : 1;

/// A mission at half an hour a second: as fast as it can, it may be over before the launcher hears
/// of the minute of a fault.
inline std::vector<std::string> InTime(std::vector<std::string> more = {}) {
  more.insert(more.end(), {"--rate", "1800"});
  return more;
}

/// A mission at a quarter of an hour a second that goes on without who is silent for a second: who
/// starts again while the mission makes up for that second has to be there before its end. Its
/// policy has to be a quick one: on a busy machine others decide for longer than that second, and
/// the scheduler would be lost.
inline std::vector<std::string> GoingOn() {
  return {"--policy",     kQuickPolicy,
          "--on-loss",    "continue",
          "--lost-after", fmt::to_string(kSlowness),
          "--rate",       fmt::to_string(900 / kSlowness)};
}

/// Missions of Random_1, and the digest that each of them has when nothing disturbs it (by
/// kQuickPolicy, as every mission of Muster that names no policy).
class MissionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    MUSTER_NEEDS_MULTICAST();
    std::ofstream(scenario_) << ScenarioToJson(Generate(PresetByName("Random_1"), 1));
    undisturbed_ = Undisturbed();
  }
  /// The digest that the mission has by that policy when nothing disturbs it.
  std::string Undisturbed(const std::string& policy = kQuickPolicy) const {
    Muster simulate(folder_, "simulate",
                    {"simulate", scenario_, "--quiet", "--policy", policy, "--out",
                     folder_.File("simulated-" + policy)});
    EXPECT_EQ(simulate.Wait(), 0) << simulate.output();
    return Report("simulated-" + policy)["digest"];
  }
  /// report.json of that run directory.
  nlohmann::json Report(const std::string& name = "run") const {
    return nlohmann::json::parse(TextOf(folder_.File(name) + "/report.json"), nullptr, false);
  }

  TemporaryFolder folder_;
  std::string scenario_ = folder_.File("scenario.json");
  std::string undisturbed_;
};

}  // namespace muster::tools
