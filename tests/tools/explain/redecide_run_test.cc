// Logs of real missions under faults, decided again.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "model/generator.h"
#include "model/scenario_json.h"
#include "scheduler/policies/registry.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

/// A fifth of all packets lost for an hour; the scheduler, the UAVs' process and twice the logger
/// killed: a log in three parts.
class RedecideRun : public ::testing::Test {
 protected:
  void SetUp() override { MUSTER_NEEDS_MULTICAST(); }
  void Check(const std::string& scenario, const std::string& policy) {
    const std::string run = folder_.File("run");
    Muster mission(folder_, "mission",
                   {"run", scenario, "--policy", policy, "--quiet", "--out", run, "--rate", "1800",
                    "--fault", "loss:*@30+60=0.2", "--fault", "process_killed:scheduler@45",
                    "--fault", "process_killed:lcm-logger@70", "--fault", "process_killed:uav@100",
                    "--fault", "process_killed:lcm-logger@130"});
    ASSERT_EQ(mission.Wait(), 0) << mission.output();  // audits and redecides, too
    EXPECT_TRUE(std::filesystem::exists(run + "/mission.lcm.2"));
    const std::string said = TextOf(folder_.File("mission.output.redecide"));
    EXPECT_NE(said.find("18 decisions made again"), std::string::npos) << said;
    EXPECT_NE(said.find("every decision is the same, bit for bit"), std::string::npos) << said;
  }
  std::string Generated(const char* preset) const {
    const std::string file = folder_.File("scenario.json");
    std::ofstream(file) << ScenarioToJson(Generate(PresetByName(preset), 1));
    return file;
  }
  TemporaryFolder folder_;
  const std::string default_policy_{scheduler::kDefaultPolicy};
};

TEST_F(RedecideRun, Random1UnderFaults) { Check(Generated("Random_1"), default_policy_); }
TEST_F(RedecideRun, HaitiUnderFaults) { Check(MUSTER_SCENARIOS "/haiti.json", kQuickPolicy); }

using LongRedecideRun = RedecideRun;
TEST_F(LongRedecideRun, Random29UnderFaults) { Check(Generated("Random_29"), default_policy_); }

}  // namespace
}  // namespace muster::tools
