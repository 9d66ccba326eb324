#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace muster::tools {

/// How one policy did in one mission.
struct ComparedMission {
  std::string mission;  ///< "seed 3", or a scenario's file
  int done = 0, tasks = 0;
  double response_s = 0;  ///< mean time from a task's report to its sensing; NaN: none was done
  double decision_s = 0;  ///< median
};

/// [n_policies][n_missions], the missions in the same order for each policy.
struct Comparison {
  std::vector<std::string> policies;
  std::vector<std::vector<ComparedMission>> missions;
};

/// A table, and for each policy after the first what it does more or less than the first, mission
/// by mission, with the interval that holds the true mean in 95 of 100 such comparisons (Student's
/// t).
std::string ComparisonText(const Comparison& comparison);
nlohmann::ordered_json ToJson(const Comparison& comparison);

/// `muster compare`: simulates the same missions with several policies.
int CompareCommand(int argc, const char* const* argv);

}  // namespace muster::tools
