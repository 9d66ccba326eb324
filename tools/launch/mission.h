#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "lcmtypes/bus/lossy_bus.h"
#include "model/scenario.h"
#include "tools/faults/fault_plan.h"
#include "tools/host/child.h"
#include "tools/host/progress.h"
#include "tools/host/stop_signals.h"
#include "tools/launch/hosts.h"
#include "tools/record/run_record.h"

namespace muster::tools {

/// How often and when a process that ended by itself is started again: after first_us, then each
/// time twice as long, up to longest_us.
struct RestartPolicy {
  int most = 5;  ///< per process
  TimeUs first_us = 100'000;
  TimeUs longest_us = 2'000'000;
};

/// What a mission needs to run.
struct MissionPlan {
  std::int64_t run_id = 0;
  Scenario scenario;
  std::vector<ChildSpec> processes;  ///< by sender name; --boot-id is added
  HostList hosts;                    ///< who runs elsewhere
  ChildSpec logger;                  ///< a stock lcm-logger; its file is added
  std::string log_file;              ///< of the first logger; the next one's is log_file.1, ...
  RestartPolicy restarts;
  FaultPlan faults;
  /// Called with every event of the log, as it is read; it must return soon.
  std::function<void(const Packet&)> on_logged = {};
  bool goes_on = false;  ///< without agent processes and scheduler when they are lost
  double rate = 0;       ///< mission seconds per wall second; 0: as fast as it goes
};

enum class MissionEnd {
  kComplete,     ///< to the limit, everybody's end in the log
  kInterrupted,  ///< by a signal
  kFailed,       ///< a process ended by itself once too often, or never spoke
};

struct MissionResult {
  MissionEnd end = MissionEnd::kFailed;
  std::vector<std::string> problems;        ///< in words, a line or more each
  std::vector<std::string> without_effect;  ///< faults that hit nothing, in words, a line each
  RunRecord record;                         ///< of all that the log holds
};

/// Starts the processes, takes the recorder's part, starts again who ended by itself (and says so
/// on stderr and by event_t), waits for the end or for the first of `stop`'s signals, then stops
/// everybody in order: the processes, the recorder, the logger. A second signal kills them. Nothing
/// of it is left when it returns or throws. Throws SystemError when a process cannot be started or
/// the bus fails.
MissionResult RunMission(const MissionPlan& plan, LossyBus* bus, const StopSignals& stop,
                         ProgressPrinter* progress);

}  // namespace muster::tools
