#pragma once

#include <cmath>
#include <cstdint>

#include "base/geometry.h"
#include "base/units.h"
#include "model/scenario.h"

namespace muster::scheduler {

/// Number of decision intervals that an agent of one speed takes for a distance, equal bit for bit
/// to Intervals(TravelUs(distance, speed), unit): a multiplication where the distance is not within
/// a microsecond of a whole number of intervals, the definition itself where it is.
class LevelOf {
 public:
  LevelOf(double speed_m_s, const Rules& rules)
      : speed_m_s_(speed_m_s),
        unit_us_(rules.ceil_to_minutes ? kMinuteUs : rules.interval_us),
        per_m_(1e6 / (speed_m_s * static_cast<double>(unit_us_))),
        close_(1.0 / static_cast<double>(unit_us_)) {}

  /// Levels above 2^30 are returned as 2^30.
  std::int32_t operator()(double distance_m) const {
    const double z = distance_m * per_m_;
    if (!(z < kHighest)) return kHighest;
    const auto floor = static_cast<std::int32_t>(z);
    const double rest = z - floor;
    const double close = close_ + z * 1e-14;
    if ((rest < close && z > 0.5) || rest > 1 - close) return Exact(distance_m);
    return floor + 1;
  }

  /// Metres that level 1 covers.
  double reach_m() const { return 1.0 / per_m_; }
  double per_m() const { return per_m_; }
  /// Distances whose quotient is this close (and a part in 1e-14) to a whole number go to Exact.
  double close() const { return close_; }

  std::int32_t Exact(double distance_m) const {
    const std::int64_t n = Intervals(TravelUs(distance_m, speed_m_s_), unit_us_);
    return n < kHighest ? static_cast<std::int32_t>(n) : kHighest;
  }

  static constexpr std::int32_t kHighest = 1 << 30;

 private:
  double speed_m_s_;
  TimeUs unit_us_;
  double per_m_;
  double close_;
};

}  // namespace muster::scheduler
