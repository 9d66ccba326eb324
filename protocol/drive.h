#pragma once

#include <functional>
#include <muster/process_status_t.hpp>
#include <optional>
#include <string>
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

  /// Takes what has arrived, possibly nothing. Within its first seconds, throws SystemError when an
  /// older process uses the same name and start. Calls `usage` when it reports the state. Returns
  /// whether the process's state has changed.
  bool Turn(const std::vector<Packet>& arrived, const Now& now,
            const std::function<Usage()>& usage);

  /// During a long computation of the process's step: see Process::Beat.
  void Beat(std::vector<Packet>* arrived, const Now& now, const std::function<Usage()>& usage);

  /// Latest monotonic time of the next turn even if nothing arrives, after one at `now_us`.
  TimeUs wake_us(TimeUs now_us) const;

 private:
  /// Looks for another process under this one's name: hears it, and lets itself be heard.
  void MeetNamesake(const process_status_t& status, const Usage& own, const Now& now);
  /// A process that joins a running mission first listens whether its name is taken.
  void LookForMission(const Packet& packet, const Now& now);
  void Publish(const Now& now);

  Process* process_;
  LossyBus* bus_;
  FaultSwitch faults_;
  std::vector<Packet> out_;
  ProcessState reported_ = ProcessState::kStarting;
  TimeUs heartbeat_us_ = kNever;           ///< unknown before the first turn
  bool beaten_ = false;                    ///< in this turn
  TimeUs begun_us_ = kNever;               ///< likewise
  TimeUs met_us_ = kNever;                 ///< answered a namesake at last
  std::optional<process_status_t> older_;  ///< what a namesake that is older has said
  std::string refused_;                    ///< why it is to end
  std::int64_t later_seq_ = -1;            ///< a number of a later start of this process
  bool has_joined_ = false;                ///< has heard a clock
  TimeUs listens_until_us_ = 0;
  std::vector<Packet> held_;  ///< until then
};

}  // namespace muster
