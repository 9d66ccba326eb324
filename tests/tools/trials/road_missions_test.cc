// Whole missions by road: each passes the audit, which finds its own ways, and each of their
// decisions is made again.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "scheduler/policies/registry.h"
#include "tests/tools/trials/road_missions.h"
#include "tools/trials/soak.h"

namespace muster::tools {
namespace {

class RoadMissions : public ::testing::TestWithParam<std::string> {};

TEST_P(RoadMissions, AreAuditedAndDecidedAgain) {
  for (const std::uint64_t seed : {1, 2}) {
    for (const std::string& finding : FindingsOf(RoadMission(GetParam(), seed))) {
      ADD_FAILURE() << "seed " << seed << ": " << finding;
    }
  }
}

std::vector<std::string> AllPolicies() {
  std::vector<std::string> names;
  for (const scheduler::PolicyInfo& policy : scheduler::Policies()) names.emplace_back(policy.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Policies, RoadMissions, ::testing::ValuesIn(AllPolicies()),
                         [](const auto& policy) {
                           std::string name = policy.param;
                           for (char& c : name) c = c == '-' || c == ':' || c == '.' ? '_' : c;
                           return name;
                         });

TEST(RoadMissions, WithKillsAndLossAreAuditedAndDecidedAgain) {
  const std::vector<std::string> policies = {"certified",     "horizon",       "rollout",
                                             "rollout-steps", "horizon-steps", "greedy-sum"};
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SoakSettings settings;
    settings.policy = policies[seed % policies.size()];
    settings.scenario = RoadMission("", seed).scenario;
    for (const std::string& finding : FindingsOf(DrawMission(settings, seed))) {
      ADD_FAILURE() << "seed " << seed << ", " << settings.policy << ": " << finding;
    }
  }
}

}  // namespace
}  // namespace muster::tools
