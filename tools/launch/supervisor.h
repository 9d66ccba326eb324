#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "model/scenario.h"
#include "tools/faults/fault_plan.h"
#include "tools/launch/mission_host.h"
#include "tools/orders/order_gate.h"
#include "tools/record/run_record.h"

namespace muster::tools {

/// How often and when a process that ended by itself is started again: after first_us, then each
/// time twice as long, up to longest_us.
struct RestartPolicy {
  int most = 5;  ///< per process
  TimeUs first_us = 100'000;
  TimeUs longest_us = 2'000'000;
};

/// The program that writes the log.
enum class Logger {
  kLcm,     ///< stock lcm-logger; the launcher follows the file and takes the recorder's part
  kMuster,  ///< the recorder, a process of the mission
};
/// What it is called, and the launcher as it speaks on the bus.
std::string_view NameOf(Logger logger);
std::string_view LauncherNameWith(Logger logger);

/// What a mission is, wherever it runs.
struct MissionPlan {
  std::int64_t run_id = 0;
  Logger logger = Logger::kMuster;
  Scenario scenario;
  std::vector<std::string> processes;  ///< by sender name, in the order of their start
  /// Of an agent process that decides: the scheduler that is part of it.
  std::map<std::string, std::string> decides_as = {};
  RestartPolicy restarts = {};
  FaultPlan faults = {};
  /// Called with every event of the log, as it is read; it must return soon.
  std::function<void(const Packet&)> on_logged = {};
  bool has_second_log = false;  ///< of process_name::kSecondRecorder
  bool goes_on = false;         ///< without agent processes and scheduler when they are lost
  TimeUs lost_after_us =
      5 * kSecondUs;  ///< a process that is silent for longer after the end is not waited for
  OrderGate* orders = nullptr;  ///< where orders come in; null: nowhere
  double rate = 0;              ///< mission seconds per wall second; 0: as fast as it goes
  /// How often each sender has started before, in a mission that goes on from its log.
  std::map<std::string, std::int64_t> starts = {};
  /// Starts below it may live on and end first; 0: there are none.
  std::int64_t first_boot = 0;

  std::int64_t StartsOf(const std::string& sender) const;
};

enum class MissionEnd {
  kComplete,     ///< to the limit, everybody's end in the log
  kInterrupted,  ///< by the user
  kFailed,       ///< a process ended by itself once too often, or never spoke
};

struct MissionResult {
  MissionEnd end = MissionEnd::kFailed;
  std::vector<std::string> problems;        ///< in words, a line or more each
  std::vector<std::string> without_effect;  ///< faults that hit nothing, in words, a line each
  std::int64_t refused = 0;         ///< packets without the mission's tag that the launcher heard
  std::int64_t message_bytes = 0;   ///< of the log's messages, each once
  std::int64_t repeated_bytes = 0;  ///< of their copies in the log
  RunRecord record;                 ///< of all that the log holds
};

/// The launcher as it speaks in that mission.
Identity LauncherOf(const MissionPlan& plan);

/// The exit code of a mission: 0, 3 failed, 4 something is missing in its log or a fault hit
/// nothing, 130 interrupted.
int ExitCodeOf(const MissionResult& result);
/// What went wrong, on stderr.
void PrintProblems(const MissionResult& result);

/// Starts the processes, acts as the recorder, and injects the plan's faults. Restarts a process
/// that has ended by itself, and reports this also as event_t. At the mission's end, or when it is
/// asked to stop, it stops the processes, then the recorder, then the logger. Asked a second time,
/// it kills them. No process is left when it returns or throws. Throws what the host throws.
MissionResult Supervise(const MissionPlan& plan, MissionHost* host);

}  // namespace muster::tools
