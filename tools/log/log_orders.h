#pragma once

#include <optional>
#include <string>

#include "model/scenario.h"
#include "tools/log/log_source.h"

namespace muster::tools {

/// The orders that a mission took, a line of JSON each, with the minute of its tick: given to
/// muster run --orders with the mission's scenario before it took any, they make the same mission
/// again.
struct CapturedOrders {
  std::string lines;
  std::optional<Scenario> scenario;  ///< the mission's, as it was before
  /// With all tasks and agents that orders added as if the file had had them, their report times
  /// and changes included.
  std::optional<Scenario> with;
  int left_out = 0;  ///< orders that such a file cannot say: cancel, hold, resume, leave, recall
  int taken = 0;
};

/// Throws InputError when the log has no scenario.
CapturedOrders CaptureOrders(MessageSource* source);

}  // namespace muster::tools
