#include "tools/scenario/fields.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>

#include "base/check.h"
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

std::optional<TimeUs> TimeOfDay(std::string_view text) {
  if (const auto clock = ClockTime(text)) return clock;
  if (const auto basic = BasicTime(text)) return basic;
  if (const auto since_1970 = UnixTime(Trim(text))) return *since_1970 % (24 * kHourUs);
  return std::nullopt;
}

std::optional<Priority> PriorityOf(std::string_view field) {
  static const std::array<std::string, kPriorities> words = {"LOW", "NORMAL", "HIGH", "EMERGENCY"};
  const std::string upper = Upper(Trim(field));
  const auto number = ToNumber(upper);
  for (std::size_t i = 0; i < kPriorities; ++i) {
    if (upper == words[i] || number == static_cast<double>(i)) return static_cast<Priority>(i);
  }
  return std::nullopt;
}

}  // namespace muster::tools
