#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "world/model/scenario.h"

namespace muster::tools {

/// What `muster run` was asked for.
struct LaunchOptions {
  std::string scenario_file;
  std::string policy;
  std::optional<double> interval_min;
  std::optional<double> limit_min;
  std::optional<std::uint64_t> seed;
  std::optional<Availability> availability;
  std::string rate;  ///< as muster-world takes it
  std::string out;   ///< "": a new folder in runs/
  double drop = 0;   ///< share of received packets that each process drops
  std::map<AgentKind, int> processes;
  std::string lcm_url;  ///< "": a network of the mission's own, or a free port
  bool quiet = false;
};

/// Reads the command line. No value: --help or --version was answered. Throws InputError.
std::optional<LaunchOptions> ParseLaunchOptions(int argc, const char* const* argv);

/// Loads the scenario and puts the options' overrides into it. Throws InputError, SystemError.
Scenario ResolveScenario(const LaunchOptions& options);

/// One process of a mission: program (a file name in the folder of `muster`) and its arguments.
struct ProcessPlan {
  std::string name;
  std::string program;
  std::vector<std::string> arguments;
};

/// What a mission's processes have in common.
struct MissionIdentity {
  std::string scenario_file;  ///< the resolved one
  std::string lcm_url;
  std::int64_t run_id = 0;
};

/// The processes to start, in that order. An agent class in k > 1 processes is named uav-1 ...
/// uav-k and dealt out in blocks of ids. Throws InputError when a class has fewer agents than
/// processes.
std::vector<ProcessPlan> PlanProcesses(const LaunchOptions& options, const Scenario& scenario,
                                       const MissionIdentity& mission);

}  // namespace muster::tools
