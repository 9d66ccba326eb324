#pragma once

#include <cstdint>
#include <cxxopts.hpp>
#include <optional>
#include <string>

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

void AddMissionOptions(cxxopts::Options* parser);
/// The scenario file and the overrides of its rules alone.
void AddRuleOptions(cxxopts::Options* parser);
MissionOptions ReadRuleOptions(const cxxopts::ParseResult& result);
/// Throws InputError on a value that cannot be. `own_policy`: any name of a policy will do.
MissionOptions ReadMissionOptions(const cxxopts::ParseResult& result, bool own_policy = false);

/// Loads the scenario and puts the options' overrides into it. Throws InputError, SystemError.
Scenario ResolveScenario(const MissionOptions& options);

}  // namespace muster::tools
