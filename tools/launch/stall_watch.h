#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "world/model/units.h"

namespace muster::tools {

/// Notices, from what is heard on the bus, that the mission's clock stands, and for whom.
class StallWatch {
 public:
  /// `processes`: the mission's, by name; they are looked for in that order. `tick_wall_us`: how
  /// long a tick lasts by --rate, 0 at full speed.
  StallWatch(std::vector<std::string> processes, TimeUs tick_wall_us);

  void OnHeard(const Packet& packet, TimeUs now_us);
  /// A line to say now: that the mission stands (after 3 s, 6 s, 12 s ...), and for whom it waits,
  /// or that it goes on.
  std::optional<std::string> Line(TimeUs now_us);
  /// Whose word on the newest tick has not been heard.
  std::vector<std::string> Missing() const;

 private:
  enum class Role { kUnknown, kAgents, kScheduler, kOther };
  struct Peer {
    Role role = Role::kUnknown;
    TimeUs answered_us = -1;  ///< mission time of its newest states or schedule
    TimeUs heard_us = -1;     ///< monotonic
  };

  std::vector<std::string> processes_;
  TimeUs patience_us_;
  std::map<std::string, Peer> peers_;
  TimeUs clock_us_ = -1;  ///< mission time of the newest clock
  bool decision_due_ = false;
  bool ended_ = false;
  TimeUs moved_us_ = -1;  ///< monotonic
  TimeUs said_after_us_ = 0;
};

}  // namespace muster::tools
