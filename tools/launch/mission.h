#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/bus/lossy_bus.h"
#include "tools/host/child.h"
#include "tools/host/progress.h"
#include "tools/host/stop_signals.h"
#include "tools/launch/hosts.h"
#include "tools/launch/supervisor.h"

namespace muster::tools {

/// What a mission over LCM starts.
struct MissionPrograms {
  std::vector<ChildSpec> processes;  ///< by sender name, with their keys; --boot-id is added
  HostList hosts;                    ///< hosts of the processes that run elsewhere
  /// By NameOf(MissionPlan::logger): a stock lcm-logger, or ours; its file is added.
  ChildSpec logger;
  std::string lcm_url = {};
  std::optional<Seal> seal = {};  ///< of the mission, where it is sealed
  std::string log_file;           ///< of the first logger; the next one's is log_file.1, ...
  std::vector<std::string> earlier_logs = {};  ///< files of a mission that goes on
};

/// Supervises the mission with real processes over LCM until its end or the first of `stop`'s
/// signals; a second one kills them. Throws SystemError when a process cannot be started or the bus
/// fails.
MissionResult RunMission(const MissionPlan& plan, const MissionPrograms& programs, LossyBus* bus,
                         const StopSignals& stop, ProgressPrinter* progress);

}  // namespace muster::tools
