#pragma once

#include <cstdint>
#include <string>

#include "base/units.h"

namespace muster::tools {

/// A process of the mission, or the logger, over all its starts.
struct Member {
  std::string name;
  std::int64_t starts = 0;
  bool down = false;           ///< ended, and to be started again
  TimeUs restart_us = kNever;  ///< then
  bool held = false;           ///< not before it is released
  std::int64_t forgiven = 0;   ///< ends that the fault plan caused
  bool back_due = false;       ///< started again, but nothing has been heard from that start yet
  bool gone = false;           ///< ended for good, and the mission goes on
  bool moved = false;          ///< ended by the launcher, to start on its host's standby
};

}  // namespace muster::tools
