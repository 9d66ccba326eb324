#pragma once

#include <functional>
#include <vector>

#include "lcmtypes/bus/lossy_bus.h"
#include "protocol/fault_switch.h"
#include "protocol/process.h"

namespace muster {

/// What goes on between a process's core and its bus, one turn at a time: faults on packets that
/// MUSTER_FAULT orders for it, its step, its heartbeat, what it publishes. RunProcess() turns it by
/// this host's clock, the simulation in virtual time. Neither is owned.
class Drive {
 public:
  Drive(Process* process, LossyBus* bus);

  /// With what has arrived, possibly nothing. `usage` is asked for when the state is reported.
  /// Returns whether the process's state has changed.
  bool Turn(const std::vector<Packet>& arrived, const Now& now,
            const std::function<Usage()>& usage);

  /// Latest monotonic time of the next turn even if nothing arrives, after one at `now_us`.
  TimeUs wake_us(TimeUs now_us) const;

 private:
  Process* process_;
  LossyBus* bus_;
  FaultSwitch faults_;
  std::vector<Packet> out_;
  ProcessState reported_ = ProcessState::kStarting;
  TimeUs heartbeat_us_ = kNever;  ///< unknown before the first turn
};

}  // namespace muster
