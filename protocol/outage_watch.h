#pragma once

#include <optional>
#include <string>

#include "base/units.h"

namespace muster {

/// Says once that the network is gone, and once that it is back.
class OutageWatch {
 public:
  /// `outage`: the bus's (Bus::Outage()), `now_us`: monotonic. A line when that has changed.
  std::optional<std::string> Line(const std::string& outage, TimeUs now_us);
  /// How long the present outage has lasted; 0 where there is none.
  TimeUs lasts_us(TimeUs now_us) const { return begun_us_ == kNever ? 0 : now_us - begun_us_; }
  /// Why, while it lasts; "" where there is none.
  const std::string& reason() const { return reason_; }

 private:
  std::string reason_;
  TimeUs begun_us_ = kNever;
};

}  // namespace muster
