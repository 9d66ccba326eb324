#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/units.h"
#include "lcmtypes/bus/lossy_bus.h"

namespace muster {

/// Says that packets without the mission's tag come in: at once, then what has come since, every
/// ten seconds at most.
class RefusalWatch {
 public:
  /// `now_us`: monotonic.
  std::optional<std::string> Line(const LossyBus& bus, TimeUs now_us);

 private:
  std::int64_t said_ = 0;
  TimeUs said_us_ = kNever;
};

}  // namespace muster
