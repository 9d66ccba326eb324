#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/units.h"
#include "model/scenario.h"

namespace muster::tools {

// What the fields of a table say.

std::string_view Trim(std::string_view text);

/// Empty, NA, N/A, NaN or null.
bool IsBlank(std::string_view field);

/// Degrees in [-limit, limit]; none otherwise.
std::optional<double> Degrees(std::string_view field, double limit);

/// Keeps rows by one column. A field may hold several codes joined by ';'; one that matches one
/// pattern is enough. A pattern is a whole code, or its beginning when it ends in '*'.
struct RowFilter {
  std::string column;
  std::vector<std::string> patterns;

  bool Matches(std::string_view field) const;
};

/// "category=1*,2d"; throws InputError naming the flag.
RowFilter ParseFilter(std::string_view flag, std::string_view text);

/// Microseconds since midnight. A clock time: the first "H:MM", "H:MM:SS" or "H:MM:SS.fff" in the
/// text, with "AM" or "PM" behind it or not; ISO 8601, with colons or without. Both as they are
/// written: date and offset are not looked at. Or the whole text is Unix seconds or milliseconds:
/// the time of day in UTC.
std::optional<TimeUs> TimeOfDay(std::string_view text);

/// 0 to 3, or low, normal, high or emergency in any case of letters.
std::optional<Priority> PriorityOf(std::string_view field);

}  // namespace muster::tools
