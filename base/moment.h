#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace muster {

/// A point in time as it was written down somewhere, with that place's offset from UTC.
struct Moment {
  std::int64_t unix_us = 0;  ///< since the Unix epoch
  int offset_min = 0;        ///< minutes east of UTC
  std::string text;          ///< as it was written

  bool operator==(const Moment&) const = default;
};

/// What ParseMoment takes, for messages.
inline constexpr std::string_view kMomentExpected =
    "ISO 8601 with seconds and an offset or Z, of the years 1900 to 2199, like "
    "2010-01-16T09:00:00-05:00";

/// The whole text as kMomentExpected says, with an offset of at most 14 hours; none otherwise. No
/// time zone of this computer takes part.
std::optional<Moment> ParseMoment(std::string_view text);

/// "2010-01-16T09:00:00-05:00", in whole seconds; up to the year 9999.
std::string MomentText(std::int64_t unix_us, int offset_min);

/// "-05:00" or "09:30" with any sign or none, as whole minutes of at most 14 hours; "Z" is 0.
std::optional<int> ParseOffset(std::string_view text);

/// "UTC-05:00"
std::string OffsetText(int offset_min);

}  // namespace muster
