#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "tools/launch/child.h"
#include "tools/launch/progress.h"
#include "tools/launch/stop_signals.h"
#include "tools/report/run_record.h"

namespace muster::tools {

/// What a mission needs to run.
struct MissionPlan {
  std::int64_t run_id = 0;
  std::vector<ChildSpec> processes;  ///< by sender name
  ChildSpec logger;                  ///< a stock lcm-logger that writes log_file
  std::string log_file;
};

enum class MissionEnd {
  kComplete,     ///< to the limit, everybody's end in the log
  kInterrupted,  ///< by a signal
  kFailed,       ///< a process of the mission ended by itself, or never spoke
};

struct MissionResult {
  MissionEnd end = MissionEnd::kFailed;
  std::vector<std::string> problems;  ///< in words, a line or more each
  RunRecord record;                   ///< of all that the log holds
};

/// Starts the processes, takes the recorder's part, waits for the end or for the first of `stop`'s
/// signals, then stops everybody in order: the processes, the recorder, the logger. A second signal
/// kills them. Nothing of it is left when it returns or throws. Throws SystemError when a process
/// cannot be started or the bus fails.
MissionResult RunMission(const MissionPlan& plan, Bus* bus, const StopSignals& stop,
                         ProgressPrinter* progress);

}  // namespace muster::tools
