#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lcmtypes/bus/event_log.h"
#include "tools/host/progress.h"

namespace muster::tools {

/// Says on stderr how much of a run's log has been read, in bytes, once the work has taken two
/// seconds. Shorter work stays silent.
class LogProgress {
 public:
  /// `what` names the work: "audit".
  LogProgress(std::string what, const std::vector<std::string>& files);

  void Add(const LogEvent& event);
  /// The log is read from its start again.
  void Rewind() { read_bytes_ = 0; }
  /// Other text follows.
  void Break() { printer_.Break(); }

  /// "audit: 43 % of 1.9 GB read"
  static std::string Line(const std::string& what, std::int64_t read_bytes, std::int64_t all_bytes);

 private:
  std::string what_;
  std::int64_t all_bytes_ = 0, read_bytes_ = 0;
  std::int64_t looked_bytes_ = 0;  ///< at which the clock was looked at
  TimeUs start_us_ = 0;
  ProgressPrinter printer_;
};

}  // namespace muster::tools
