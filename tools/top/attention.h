#pragma once

#include <string>
#include <vector>

#include "tools/report/timeline.h"

namespace muster::tools {

/// One thing that goes wrong in a mission, as the page's attention panel has it.
struct Concern {
  std::string kind;  ///< "agents failed"
  std::string who;   ///< "uav:7"
  std::string note;  ///< "since 1:20:00"; may be empty
  bool bad = true;   ///< red; else of note only
};

/// What needs attention at the newest time that `timeline` knows: kinds in the page's order, the
/// most harmful first, each by harm. `silent`: processes that have said nothing for long. A task is
/// at risk when it is due or expires within two intervals and nobody is on the way, or when the
/// pair that is on the way starts too late; priority weighs most. Others that nobody is sent to
/// count from half of the mission's time on. Time grows with agents and tasks, and with charging
/// points for each UAV that is low.
std::vector<Concern> Attention(const Timeline& timeline, const std::vector<std::string>& silent);

}  // namespace muster::tools
