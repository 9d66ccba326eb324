#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/units.h"
#include "lcmtypes/bus/bus.h"

namespace muster::tools {

/// When to say that a mission still waits for something: after 3 s, 6 s, 12 s ...
class Patience {
 public:
  /// What is waited for, from now on; the same again changes nothing. "": nothing.
  void WaitFor(const std::string& what, TimeUs now_us);
  TimeUs waited_us(TimeUs now_us) const { return now_us - since_us_; }
  /// Whether to say it now.
  bool Due(TimeUs now_us);

 private:
  std::string what_;
  TimeUs since_us_ = 0;
  TimeUs said_after_us_ = 0;
};

/// Notices, from the messages on the bus, that the mission's clock stands still (and for which
/// processes it waits), and that it falls behind its rate.
class StallWatch {
 public:
  /// `processes`: the mission's, by name; they are looked for in that order. `rate`: mission
  /// seconds per wall second, 0 at full speed.
  StallWatch(std::vector<std::string> processes, TimeUs tick_us, double rate);

  void OnHeard(const Packet& packet, TimeUs now_us);
  /// A line to print now: that the mission stands (after 3 s, 6 s, 12 s ...) and which process it
  /// waits for, or that it goes on, or that it is late (by 5 s, 10 s, 20 s ...).
  std::optional<std::string> Line(TimeUs now_us);
  /// Processes whose message on the newest tick has not been heard.
  std::vector<std::string> Missing() const;
  /// Whether the clock has been heard to run, and to have ended.
  bool begun() const { return moved_us_ >= 0; }
  bool ended() const { return ended_; }
  /// Since that process was heard, or since the first call; microseconds.
  TimeUs SilentUs(const std::string& process, TimeUs now_us);

 private:
  std::optional<std::string> LateLine();

  enum class Role { kUnknown, kAgents, kScheduler, kOther };
  struct Peer {
    Role role = Role::kUnknown;
    TimeUs answered_us = -1;  ///< mission time of its newest states or schedule
    TimeUs heard_us = -1;     ///< monotonic
    TimeUs decides_us = -1;   ///< monotonic, since when it says that it is deciding; -1: it is not
  };

  std::vector<std::string> processes_;
  double rate_;
  TimeUs patience_us_;
  std::map<std::string, Peer> peers_;
  TimeUs clock_us_ = -1;  ///< mission time of the newest clock
  bool decision_due_ = false;
  bool ended_ = false;
  TimeUs moved_us_ = -1;  ///< monotonic
  TimeUs said_after_us_ = 0;
  TimeUs begin_wall_us_ = -1, begin_clock_us_ = 0;
  TimeUs said_late_us_ = 0;
};

}  // namespace muster::tools
