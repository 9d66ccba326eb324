#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "agents/core/agent_process.h"
#include "model/scenario_json.h"
#include "protocol/process.h"
#include "scheduler/process/scheduler_process.h"
#include "world/world_process.h"

namespace muster::simulation {

/// The most processes of each agent class in virtual time.
inline constexpr int kMostPerClass = 9;

/// The processes of a mission: world, uav, worker, vehicle, and the schedulers. With several
/// processes of each agent class: uav-1, uav-2, ...
std::vector<std::string> ProcessNames(int schedulers = 1, int per_class = 1);

/// Makes the drivers of the measured agents of that class; null: they move as computed.
using DriversOf = std::function<std::unique_ptr<agents::DriverPort>(AgentKind)>;

/// What they are started with.
struct ProcessSettings {
  ScenarioText scenario;
  std::string policy;
  /// How long decisions took is measured by it; the log is to be a function of its seed: always 0.
  scheduler::Stopwatch stopwatch = [] { return TimeUs{0}; };
  world::WorldOptions world = {};
  int world_window = 0;                                       ///< see Sender
  int window = 0;                                             ///< of the others
  std::size_t most_whole = agents::AgentProcess::kMostWhole;  ///< see there
  DriversOf drivers = {};
  /// Processes of each agent class, which has at least as many agents, and how many agents they
  /// share, in blocks of ids.
  int per_class = 1;
  PerKind<int> agents = {};  ///< not used where per_class is 1
};

/// The core of that name of those.
std::unique_ptr<Process> StartProcess(const Identity& identity, const ProcessSettings& settings);

}  // namespace muster::simulation
