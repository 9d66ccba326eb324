#pragma once

#include <cstdint>
#include <limits>

namespace muster {

/// Mission time or a duration, in microseconds since mission start.
using TimeUs = std::int64_t;

inline constexpr TimeUs kSecondUs = 1'000'000;
inline constexpr TimeUs kMinuteUs = 60 * kSecondUs;
inline constexpr TimeUs kNever = std::numeric_limits<TimeUs>::max();

/// The whole number nearest to x, halves away from zero: std::llround without the call. |x| < 2^63.
inline std::int64_t RoundHalfAway(double x) {
  const auto whole = static_cast<std::int64_t>(x);
  const double rest = x - static_cast<double>(whole);  // exact
  return whole + (rest >= 0.5 ? 1 : 0) - (rest <= -0.5 ? 1 : 0);
}

/// Seconds to microseconds, rounded to nearest; durations that do not fit become kNever.
inline TimeUs ToUs(double seconds) {
  const double us = seconds * 1e6;
  return us >= 9e18 ? kNever : RoundHalfAway(us);
}
inline constexpr double ToSeconds(TimeUs us) { return static_cast<double>(us) * 1e-6; }
inline constexpr double ToMinutes(TimeUs us) { return static_cast<double>(us) / kMinuteUs; }

/// Number of decision intervals that a duration takes: max(1, ceil(duration / interval)).
/// Source: the paper's `ceil(x, Interval)` (Eq. 4-5 to 4-19), on integer microseconds.
inline constexpr std::int64_t Intervals(TimeUs duration_us, TimeUs interval_us) {
  const std::int64_t n = duration_us / interval_us + (duration_us % interval_us > 0 ? 1 : 0);
  return n < 1 ? 1 : n;
}

}  // namespace muster
