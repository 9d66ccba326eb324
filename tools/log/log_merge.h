#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace muster::tools {

struct MergeResult {
  std::int64_t written = 0;
  std::vector<std::int64_t> added;  ///< by run: messages that those before it lack
};

/// Writes one log of several of the same mission, such as those of two recorders: every message
/// once, in the order of the first log. What the first one lacks stands where the log that has it
/// has it: behind the same message. `runs` are run directories or log files; `out` must not exist.
/// Throws InputError, also where a log is another mission's. Memory grows with what the first log
/// lacks.
MergeResult MergeLogs(const std::vector<std::string>& runs, const std::string& out);

}  // namespace muster::tools
