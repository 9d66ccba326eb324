#ifndef MUSTER_TESTS_TOOLS_TRIALS_EACH_POLICY_H_
#define MUSTER_TESTS_TOOLS_TRIALS_EACH_POLICY_H_

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "scheduler/policies/registry.h"

namespace muster::tools {

/// The names of all policies.
inline std::vector<std::string> AllPolicies() {
  std::vector<std::string> names;
  for (const scheduler::PolicyInfo& policy : scheduler::Policies()) names.emplace_back(policy.name);
  return names;
}

/// The name of a policy as GoogleTest takes it.
inline std::string PolicyAsTestName(const ::testing::TestParamInfo<std::string>& policy) {
  std::string name = policy.param;
  for (char& c : name) c = c == '-' || c == ':' || c == '.' ? '_' : c;
  return name;
}

}  // namespace muster::tools

#endif  // MUSTER_TESTS_TOOLS_TRIALS_EACH_POLICY_H_
