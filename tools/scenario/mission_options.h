#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/options.h"
#include "model/scenario.h"

namespace muster::tools {

/// What `muster run` and `muster simulate` have in common.
struct MissionOptions {
  std::string scenario_file;
  std::string policy;
  std::optional<double> interval_min;
  std::optional<double> limit_min;
  std::optional<std::uint64_t> seed;
  std::optional<Availability> availability;
  std::string out;  ///< "": the command's default
  bool quiet = false;
};

void AddMissionOptions(Options* options);
/// The scenario file and the overrides of its rules alone.
void AddRuleOptions(Options* options);
MissionOptions ReadRuleOptions(const Arguments& arguments);
/// Throws InputError on a policy that is none of ours, unless the scheduler has an `own_policy`.
MissionOptions ReadMissionOptions(const Arguments& arguments, bool own_policy = false);

/// Loads the scenario and puts the options' overrides into it. Throws InputError, SystemError.
Scenario ResolveScenario(const MissionOptions& options);

}  // namespace muster::tools
