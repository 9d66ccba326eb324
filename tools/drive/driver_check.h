#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "agents/driver/driver_program.h"

namespace muster::tools {

struct DriverCheckOptions {
  std::vector<std::string> argv;
  AgentKind kind = AgentKind::kUav;
  agents::DriverSession::Rules rules;
  /// Takes words on what happens now, which may last for minutes; none: nobody wants them.
  std::function<void(const std::string&)> progress;
};

/// What a driver did when it was tried.
struct DriverCheckResult {
  struct Step {
    std::string what;  ///< "goto 1", "sense 2"
    double planned_s = 0;
    std::optional<double> took_s;  ///< none: it did not come to that, or was not to
    std::string note;              ///< "cancelled", "replaced"
  };
  struct Wrong {
    double mission_s = 0;
    std::string what;
  };
  std::string name;
  std::vector<Step> steps;
  std::vector<Wrong> wrong;
  double ready_s = 0;  ///< when it could set out
  double mission_s = 0;
};

/// Plays a small mission of one agent with it: two ways with something to do at their ends, one
/// that is cancelled, one that is replaced by another, and the end. Ticks are of 30 s. Throws
/// SystemError when the driver cannot be started.
DriverCheckResult CheckDriver(const DriverCheckOptions& options);

}  // namespace muster::tools
