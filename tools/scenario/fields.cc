#include "tools/scenario/fields.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <set>

#include "base/check.h"
#include "base/moment.h"
#include "base/text.h"

namespace muster::tools {
namespace {

constexpr TimeUs kHourUs = 60 * kMinuteUs;

std::string Upper(std::string_view text) {
  std::string upper(text);
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return upper;
}

bool IsDigit(std::string_view text, std::size_t i) {
  return i < text.size() && text[i] >= '0' && text[i] <= '9';
}

/// The first "H:MM", with what follows it.
std::optional<TimeUs> ClockTime(std::string_view text) {
  const auto digit = [&](std::size_t i) { return IsDigit(text, i); };
  const auto pair = [&](std::size_t i) { return (text[i] - '0') * 10 + (text[i + 1] - '0'); };
  for (std::size_t colon = text.find(':'); colon != text.npos; colon = text.find(':', colon + 1)) {
    if (colon == 0 || !digit(colon - 1) || !digit(colon + 1) || !digit(colon + 2)) continue;
    const bool has_two = colon >= 2 && digit(colon - 2);
    if (has_two && colon >= 3 && digit(colon - 3)) continue;
    int hour = has_two ? pair(colon - 2) : text[colon - 1] - '0';
    const int minute = pair(colon + 1);
    std::size_t at = colon + 3;
    TimeUs second_us = 0;
    if (at < text.size() && text[at] == ':' && digit(at + 1) && digit(at + 2)) {
      second_us = pair(at + 1) * kSecondUs;
      at += 3;
      if (at < text.size() && (text[at] == '.' || text[at] == ',')) {
        TimeUs unit_us = kSecondUs / 10;
        for (++at; digit(at); ++at, unit_us /= 10) second_us += (text[at] - '0') * unit_us;
      }
    }
    if (digit(at)) continue;
    const std::string half = Upper(Trim(text.substr(at)).substr(0, 2));
    if (half == "AM" || half == "PM") {
      if (hour < 1 || hour > 12) continue;
      hour = hour % 12 + (half == "PM" ? 12 : 0);
    }
    if (hour > 23 || minute > 59 || second_us >= kMinuteUs) continue;
    return hour * kHourUs + minute * kMinuteUs + second_us;
  }
  return std::nullopt;
}

/// ISO 8601 without colons: "...T0730", "...T073059.5Z".
std::optional<TimeUs> BasicTime(std::string_view text) {
  const std::size_t t = text.find('T');
  if (t == text.npos || t == 0 || !IsDigit(text, t - 1)) return std::nullopt;
  text.remove_prefix(t + 1);
  std::size_t digits = 0;
  while (IsDigit(text, digits)) ++digits;
  if (digits != 4 && digits != 6) return std::nullopt;
  return ClockTime(fmt::format("{}:{}{}{}", text.substr(0, 2), text.substr(2, 2),
                               digits == 6 ? ":" : "", text.substr(4)));
}

/// Seconds or milliseconds since 1970, of the years 1980 to 2286. A compact date ("20240903") is
/// none of them.
std::optional<TimeUs> UnixTime(std::string_view text) {
  constexpr double kFrom = 315'532'800, kUntil = 1e10;
  const auto number = ToNumber(text);
  if (!number) return std::nullopt;
  for (const double per_second : {1.0, 1000.0}) {
    const double seconds = *number / per_second;
    if (seconds >= kFrom && seconds < kUntil) {
      return static_cast<TimeUs>(std::floor(*number * (1e6 / per_second)));
    }
  }
  return std::nullopt;
}

/// The number of `length` digits at `at`.
std::optional<int> DigitsAt(std::string_view text, std::size_t at, std::size_t length) {
  int number = 0;
  for (std::size_t i = at; i < at + length; ++i) {
    if (!IsDigit(text, i)) return std::nullopt;
    number = 10 * number + (text[i] - '0');
  }
  return number;
}

/// Days since 1970; none where there is no such date.
std::optional<std::int64_t> DayOf(int year, int month, int day) {
  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

struct ShortDate {
  int first, second, year;
};

/// "5/7/2010", "05.07.2010" or "05-07-2010" at the beginning.
std::optional<ShortDate> ReadShortDate(std::string_view text) {
  int numbers[2];
  std::size_t at = 0;
  for (int& number : numbers) {
    const std::size_t length = IsDigit(text, at + 1) ? 2 : 1;
    const auto digits = DigitsAt(text, at, length);
    at += length;
    if (!digits || at >= text.size() || std::string_view("/.-").find(text[at]) == text.npos) {
      return std::nullopt;
    }
    number = *digits;
    ++at;
  }
  const auto year = DigitsAt(text, at, 4);
  if (!year || IsDigit(text, at + 4)) return std::nullopt;
  return ShortDate{numbers[0], numbers[1], *year};
}

std::optional<std::int64_t> ReadDate(std::string_view text, DateOrder order) {
  const auto year = DigitsAt(text, 0, 4);
  if (year && text.size() >= 10 && text[4] == '-' && text[7] == '-' && !IsDigit(text, 10)) {
    const auto month = DigitsAt(text, 5, 2), day = DigitsAt(text, 8, 2);
    return month && day ? DayOf(*year, *month, *day) : std::nullopt;
  }
  if (text.find('T') == 8) {
    const auto month = DigitsAt(text, 4, 2), day = DigitsAt(text, 6, 2);
    return year && month && day ? DayOf(*year, *month, *day) : std::nullopt;
  }
  const auto date = ReadShortDate(text);
  if (!date || order == DateOrder::kUnknown) return std::nullopt;
  return order == DateOrder::kDayFirst ? DayOf(date->year, date->second, date->first)
                                       : DayOf(date->year, date->first, date->second);
}

/// "Z", "+02", "+0200" or "+02:00" at the end of a date and time.
std::optional<int> ReadOffset(std::string_view text) {
  constexpr std::size_t kAfterDate = 8;
  if (text.ends_with('Z') || text.ends_with('z')) return 0;
  const std::size_t sign = text.find_last_of("+-");
  if (sign == text.npos || sign <= kAfterDate) return std::nullopt;
  if (text.find_first_of(":T") >= sign) return std::nullopt;  // a part of the date
  std::string offset(text.substr(sign));
  if (offset.size() == 3) offset += ":00";
  if (offset.size() == 5) offset.insert(3, ":");
  return ParseOffset(offset);
}

}  // namespace

std::string_view Trim(std::string_view text) {
  const auto blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

bool IsBlank(std::string_view field) {
  const std::string upper = Upper(Trim(field));
  return upper.empty() || upper == "NA" || upper == "N/A" || upper == "NAN" || upper == "NULL";
}

/// Degrees in [-limit, limit]; none otherwise.
std::optional<double> Degrees(std::string_view field, double limit) {
  field = Trim(field);
  if (field.starts_with('+')) field.remove_prefix(1);
  const auto value = ToNumber(field);
  return value && std::abs(*value) <= limit ? value : std::nullopt;
}

bool RowFilter::Matches(std::string_view field) const {
  for (const std::string& part : Split(field, ';')) {
    const std::string_view code = Trim(part);
    for (const std::string_view pattern : patterns) {
      if (pattern.ends_with('*') ? code.starts_with(pattern.substr(0, pattern.size() - 1))
                                 : code == pattern) {
        return true;
      }
    }
  }
  return false;
}

RowFilter ParseFilter(std::string_view flag, std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == text.npos || equals == 0 || equals + 1 == text.size()) {
    throw InputError("command line", flag, fmt::format("'{}'", text),
                     "COLUMN=VALUE[,VALUE...], a value may end in *");
  }
  return {std::string(text.substr(0, equals)), Split(text.substr(equals + 1), ',')};
}

std::string Shown(const std::vector<RowFilter>& filters) {
  std::string text;
  for (const RowFilter& filter : filters) {
    text += fmt::format("{}{}={}", text.empty() ? " with " : " and ", filter.column,
                        fmt::join(filter.patterns, ","));
  }
  return text;
}

std::optional<TimeUs> TimeOfDay(std::string_view text) {
  if (const auto clock = ClockTime(text)) return clock;
  if (const auto basic = BasicTime(text)) return basic;
  if (const auto since_1970 = UnixTime(Trim(text))) return *since_1970 % (24 * kHourUs);
  return std::nullopt;
}

void DateOrderFinder::Look(std::string_view text) {
  const auto date = ReadShortDate(Trim(text));
  if (!date) return;
  first_over_12_ = first_over_12_ || date->first > 12;
  second_over_12_ = second_over_12_ || date->second > 12;
}

DateOrder DateOrderFinder::order() const {
  if (first_over_12_ == second_over_12_) return DateOrder::kUnknown;
  return first_over_12_ ? DateOrder::kDayFirst : DateOrder::kMonthFirst;
}

FieldTime FieldTime::On(int clocks_offset_min) const {
  if (!offset_min) return *this;
  constexpr TimeUs kDayUs = 24 * kHourUs;
  FieldTime moved = *this;
  const TimeUs us = of_day_us + (clocks_offset_min - *offset_min) * kMinuteUs;
  const std::int64_t days = us >= 0 ? us / kDayUs : -1;
  moved.of_day_us = us - days * kDayUs;
  if (day) moved.day = *day + days;
  moved.offset_min = clocks_offset_min;
  return moved;
}

std::optional<FieldTime> ReadTime(std::string_view text, DateOrder order) {
  text = Trim(text);
  FieldTime time;
  const bool is_written = ClockTime(text) || BasicTime(text);
  if (const auto since_1970 = is_written ? std::nullopt : UnixTime(text)) {
    time.of_day_us = *since_1970 % (24 * kHourUs);
    time.day = *since_1970 / (24 * kHourUs);
    time.offset_min = 0;
    return time;
  }
  const auto of_day = TimeOfDay(text);
  if (!of_day) return std::nullopt;
  time.of_day_us = *of_day;
  time.day = ReadDate(text, order);
  if (time.day) time.offset_min = ReadOffset(text);
  return time;
}

std::optional<Priority> PriorityOf(std::string_view field) {
  static const std::array<std::set<std::string>, kPriorities> words = {{
      {"LOW", "MINOR"},
      {"NORMAL", "MEDIUM", "MODERATE"},
      {"HIGH", "SEVERE"},
      {"EMERGENCY", "EXTREME", "CRITICAL"},
  }};
  const std::string upper = Upper(Trim(field));
  const auto number = ToNumber(upper);
  for (std::size_t i = 0; i < kPriorities; ++i) {
    if (words[i].contains(upper) || number == static_cast<double>(i)) {
      return static_cast<Priority>(i);
    }
  }
  return std::nullopt;
}

}  // namespace muster::tools
