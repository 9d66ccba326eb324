#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "simulation/start_process.h"
#include "simulation/virtual_logger.h"
#include "tools/launch/supervisor.h"

namespace muster::tools {

/// A mission with faults in virtual time.
struct VirtualMission {
  Scenario scenario;
  std::string policy;
  FaultPlan faults = {};  ///< checked
  std::vector<world::PlannedOrder> orders = {};
  bool goes_on = false;  ///< without agent processes and scheduler when they are lost
  TimeUs lost_after_us = 5 * kSecondUs;
  RestartPolicy restarts = {};
  double drop = 0;               ///< share of received packets that each process drops
  std::uint64_t fault_seed = 1;  ///< of what becomes of packets, and of how long they travel

  simulation::DriversOf drivers = {};  ///< of measured agents

  /// Every event of the log, and which start of the logger wrote it.
  std::function<void(const simulation::VirtualLogger::Event&, std::int64_t start)> on_logged = {};
  /// What the launcher says of faults, deaths and restarts.
  std::function<void(const std::string&)> say = {};
  /// How often whoever runs it has asked to stop.
  std::function<int()> stops_asked = {};
};

/// What `muster run` does with real processes over LCM, in this process over a virtual network: the
/// processes' cores, the launcher's supervision, lcm-logger (as with --logger lcm). A function of
/// its arguments: no clock of the host enters, so schedules say that they took no time. It fails
/// when it has not ended after half an hour of network time beside what its faults last.
MissionResult RunVirtualMission(const VirtualMission& mission);

/// The digest of the same mission where only agents fail: what it must have when it waits for
/// everybody.
std::string UndisturbedDigest(const VirtualMission& mission);

}  // namespace muster::tools
