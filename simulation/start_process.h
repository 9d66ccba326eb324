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

/// The processes of a mission with one process per agent class: world, uav, worker, vehicle, and
/// the schedulers.
std::vector<std::string> ProcessNames(int schedulers = 1);

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
};

/// The core of that name of those: agent classes with all their agents.
std::unique_ptr<Process> StartProcess(const Identity& identity, const ProcessSettings& settings);

}  // namespace muster::simulation
