// `muster run` over LCM and `muster simulate` in one process are one rule book: the same decisions
// and outcomes.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "model/generator.h"
#include "model/scenario_json.h"
#include "scheduler/policies/registry.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

class Comparison : public ::testing::Test {
 protected:
  void SetUp() override { MUSTER_NEEDS_MULTICAST(); }

  std::string Generated(const char* preset, std::uint64_t seed) const {
    const std::string file = folder_.File("scenario.json");
    std::ofstream(file) << ScenarioToJson(Generate(PresetByName(preset), seed));
    return file;
  }

  /// report.json of `muster COMMAND SCENARIO MORE...`.
  Json Report(const std::string& command, const std::string& scenario,
              const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {command, scenario, "--policy",
                                          policy_, "--out",  folder_.File(command)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Muster muster(folder_, command, arguments);
    EXPECT_EQ(muster.Wait(), 0) << muster.output();
    return Json::parse(TextOf(folder_.File(command) + "/report.json"), nullptr, false);
  }

  void ExpectTheSame(const std::string& scenario,
                     const std::vector<std::string>& more_for_run = {}) {
    const Json simulated = Report("simulate", scenario, {});
    const Json ran = Report("run", scenario, more_for_run);
    ASSERT_TRUE(simulated.is_object() && ran.is_object());
    EXPECT_GT(simulated["tasks_done"], 0);
    ASSERT_EQ(ran["decisions"].size(), simulated["decisions"].size());
    for (std::size_t i = 0; i < ran["decisions"].size(); ++i) {
      const Json& a = ran["decisions"][i];
      const Json& b = simulated["decisions"][i];
      EXPECT_EQ(a["actions"], b["actions"]) << "decision " << i;
      EXPECT_EQ(a["weight"], b["weight"]) << "decision " << i;
      EXPECT_EQ(a["candidates"], b["candidates"]) << "decision " << i;
    }
    EXPECT_EQ(ran["tasks_done"], simulated["tasks_done"]);
    EXPECT_EQ(ran["digest"], simulated["digest"]);
    EXPECT_TRUE(ran["log"]["complete"].get<bool>()) << ran["log"];
    EXPECT_TRUE(ran["log"]["gaps"].empty()) << ran["log"];
  }

  TemporaryFolder folder_;
  std::string policy_ = kQuickPolicy;
};

/// The default policy, and four that take a twentieth of its time or less.
constexpr std::string_view kPolicies[] = {scheduler::kDefaultPolicy, kQuickPolicy, "certified",
                                          "mpq", "kwta"};

class ComparisonBySeed : public Comparison, public ::testing::WithParamInterface<int> {};
INSTANTIATE_TEST_SUITE_P(Random1, ComparisonBySeed, ::testing::Range(1, 6),
                         [](const auto& seed) { return "Seed" + std::to_string(seed.param); });

TEST_P(ComparisonBySeed, RunAndSimulateDecideTheSame) {
  policy_ = kPolicies[GetParam() - 1];
  ExpectTheSame(Generated("Random_1", static_cast<std::uint64_t>(GetParam())));
}

TEST_F(Comparison, OnImportedPoints) { ExpectTheSame(MUSTER_SCENARIOS "/haiti.json"); }

TEST_F(Comparison, EveryProcessLosingThirtyPercentChangesNothing) {
  ExpectTheSame(Generated("Random_1", 6), {"--drop", "0.3"});
}

using LongComparison = Comparison;
TEST_F(LongComparison, OnTheLargestPreset) {
  policy_ = scheduler::kDefaultPolicy;
  ExpectTheSame(Generated("Random_29", 1));
}

}  // namespace
}  // namespace muster::tools
