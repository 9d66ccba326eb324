#pragma once

#include <cstdint>
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

/// " with category=1*,2d and ok=YES", for messages; "" of none.
std::string Shown(const std::vector<RowFilter>& filters);

/// Microseconds since midnight. A clock time: the first "H:MM", "H:MM:SS" or "H:MM:SS.fff" in the
/// text, with "AM" or "PM" behind it or not; ISO 8601, with colons or without. Both as they are
/// written: date and offset are not looked at. Or the whole text is Unix seconds or milliseconds:
/// the time of day in UTC.
std::optional<TimeUs> TimeOfDay(std::string_view text);

/// Which of the first two numbers of a date like 05/07/2010 is the day.
enum class DateOrder { kUnknown, kDayFirst, kMonthFirst };

/// The order that the dates of one column show: one date has a number over 12 where the other order
/// has the month, and no date has one where this order has it.
class DateOrderFinder {
 public:
  void Look(std::string_view text);
  DateOrder order() const;

 private:
  bool first_over_12_ = false, second_over_12_ = false;
};

/// A time of day with what the field says of its date and its offset from UTC.
struct FieldTime {
  TimeUs of_day_us = 0;             ///< as TimeOfDay
  std::optional<std::int64_t> day;  ///< days since 1970-01-01
  std::optional<int> offset_min;    ///< minutes east of UTC; of Unix times 0

  /// The same time on clocks of that offset, where its own is known; else as it is.
  FieldTime On(int clocks_offset_min) const;
};

/// A time of day as TimeOfDay reads it. A date is YYYY-MM-DD, YYYYMMDD before a "T", or three
/// numbers of which the last is the year, by `order`; only behind a date an offset is one.
std::optional<FieldTime> ReadTime(std::string_view text, DateOrder order);

/// 0 to 3, or low, normal, high or emergency in any case of letters.
std::optional<Priority> PriorityOf(std::string_view field);

}  // namespace muster::tools
