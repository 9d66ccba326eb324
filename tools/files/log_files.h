#pragma once

#include <string>
#include <vector>

namespace muster::tools {

/// The log files of a run, in the order in which they were written: `run` is a run directory
/// (mission.lcm, mission.lcm.1, ...) or one log file. Throws InputError when there is none.
std::vector<std::string> LogFilesOf(const std::string& run);

}  // namespace muster::tools
