#pragma once

#include <string>

#include "base/units.h"

namespace muster {

// Numbers of our files and the units they are in. Conversions are done in long double (64 bits of
// fraction or more) from the text itself and rounded once to double, so that every double has a
// text that gives it: with double arithmetic one in sixteen speeds could not be written down.

/// A file's unit is `numerator / denominator` of ours.
struct Unit {
  long double numerator = 1;
  long double denominator = 1;
};
inline constexpr Unit kOne{};
inline constexpr Unit kKm{1000, 1};
inline constexpr Unit kKmPerMin{1000, 60};
inline constexpr long double kMinute = kMinuteUs;
inline constexpr long double kSecond = kSecondUs;

/// The longest time that a file may name: 1,900 years; far from the end of int64 microseconds.
inline constexpr double kMaxMinutes = 1e9;

double FromText(const std::string& text, Unit unit);
TimeUs TimeFromText(const std::string& text, long double unit_us);

/// The shortest text, in the file's unit, that gives the value again.
std::string ToText(double value, Unit unit);
std::string TimeToText(TimeUs value, long double unit_us);

}  // namespace muster
