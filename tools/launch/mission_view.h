#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "base/units.h"
#include "lcmtypes/bus/bus.h"
#include "protocol/process.h"

namespace muster::tools {

/// How far a mission is, from its messages.
class MissionView {
 public:
  /// Takes a message of the mission; each once, in any order.
  void Add(const Packet& packet);

  bool started() const { return tick_ >= 0; }
  std::int64_t tick() const { return tick_; }  ///< -1 before the first
  TimeUs tick_us() const { return tick_us_; }
  TimeUs limit_us() const { return limit_us_; }
  int done() const { return done_; }
  int tasks() const { return tasks_; }
  int decisions() const { return decisions_; }
  /// The world has announced the end.
  bool end_announced() const { return end_announced_; }
  /// Highest state that a process has reported of itself; kStarting before.
  ProcessState StateOf(const std::string& name) const;
  /// All processes have ended and will start again.
  void ForgetProcesses() { states_.clear(); }

 private:
  std::int64_t tick_ = -1;
  TimeUs tick_us_ = 0;
  TimeUs limit_us_ = 0;
  std::int64_t world_tick_ = -1;
  int done_ = 0;
  int tasks_ = 0;
  int decisions_ = 0;
  bool end_announced_ = false;
  std::map<std::string, ProcessState> states_;
};

/// The mission in one line: time, tick, tasks, decisions, ticks that the log lags, speed.
/// `wall_us`: how long the mission has been running.
std::string ProgressLine(const MissionView& mission, std::int64_t log_lag_ticks, TimeUs wall_us);

}  // namespace muster::tools
