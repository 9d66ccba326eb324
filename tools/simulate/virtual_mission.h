#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "simulation/start_process.h"
#include "simulation/virtual_logger.h"
#include "tools/launch/supervisor.h"

namespace muster::tools {

/// A host's clock is set, forward or back.
struct ClockJump {
  std::string process;  ///< on that host; the launcher's: process_name::kLauncher
  TimeUs at_us = 0;     ///< of network time
  TimeUs by_us = 0;
};

/// A mission with faults in virtual time.
struct VirtualMission {
  Scenario scenario;
  std::string policy;
  FaultPlan faults = {};  ///< checked
  std::vector<world::PlannedOrder> orders = {};
  int schedulers = 1;
  int per_class = 1;     ///< processes of each agent class; at most as many as its agents
  bool goes_on = false;  ///< without agent processes and scheduler when they are lost
  TimeUs lost_after_us = 5 * kSecondUs;
  RestartPolicy restarts = {};
  double drop = 0;               ///< share of received packets that each process drops
  std::uint64_t fault_seed = 1;  ///< of what becomes of packets, and of how long they travel

  std::vector<ClockJump> clock_jumps = {};
  TimeUs epoch_us = 0;  ///< what all clocks show at first, since the Unix epoch

  simulation::DriversOf drivers = {};  ///< of measured agents

  /// Every event of the log, and which start of the logger wrote it.
  std::function<void(const simulation::VirtualLogger::Event&, std::int64_t start)> on_logged = {};
  /// What the launcher says of faults, deaths and restarts.
  std::function<void(const std::string&)> say = {};
  /// How often the user has asked to stop.
  std::function<int()> stops_asked = {};
};

/// Runs in this process, over a virtual network, what `muster run` does with real processes over
/// LCM: the processes' cores, the launcher's supervision and lcm-logger (as with --logger lcm). The
/// result is a function of the arguments: no clock of the host enters, so schedules say that they
/// took no time. The mission fails when it takes longer than half an hour of network time plus the
/// time that its faults last.
MissionResult RunVirtualMission(const VirtualMission& mission);

/// The digest of the same mission with agent failures alone. A mission that waits for lost
/// processes must have this digest.
std::string UndisturbedDigest(const VirtualMission& mission);

}  // namespace muster::tools
