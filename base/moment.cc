#include "base/moment.h"

#include <fmt/format.h>
#include <glib.h>

#include <cstdlib>
#include <memory>

#include "base/check.h"
#include "base/text.h"

namespace muster {
namespace {

constexpr int kMostOffsetMin = 14 * 60;  // of any place's clocks
constexpr int kFirstYear = 1900, kLastYear = 2199;
constexpr std::int64_t kSecond = 1'000'000;

struct Unref {
  void operator()(GDateTime* time) const { g_date_time_unref(time); }
  void operator()(GTimeZone* zone) const { g_time_zone_unref(zone); }
};
using DateTime = std::unique_ptr<GDateTime, Unref>;
using TimeZone = std::unique_ptr<GTimeZone, Unref>;

bool IsSane(GDateTime* time, int offset_min) {
  const int year = g_date_time_get_year(time);
  return year >= kFirstYear && year <= kLastYear && std::abs(offset_min) <= kMostOffsetMin;
}

}  // namespace

std::optional<Moment> ParseMoment(std::string_view text) {
  if (text.find('\0') != text.npos) return std::nullopt;
  std::string written(text);
  // Without a default zone: a text that has no offset is none.
  const DateTime time(g_date_time_new_from_iso8601(written.c_str(), nullptr));
  if (time == nullptr) return std::nullopt;
  const auto offset_min = static_cast<int>(g_date_time_get_utc_offset(time.get()) / (60 * kSecond));
  if (!IsSane(time.get(), offset_min)) return std::nullopt;
  return Moment{g_date_time_to_unix(time.get()) * kSecond + g_date_time_get_microsecond(time.get()),
                offset_min, std::move(written)};
}

std::string MomentText(std::int64_t unix_us, int offset_min) {
  const std::int64_t seconds = unix_us / kSecond - (unix_us % kSecond < 0 ? 1 : 0);
  const DateTime utc(g_date_time_new_from_unix_utc(seconds));
  const TimeZone zone(g_time_zone_new_offset(offset_min * 60));
  const DateTime local(utc ? g_date_time_to_timezone(utc.get(), zone.get()) : nullptr);
  MUSTER_CHECK(local != nullptr, "{} us, {} min", unix_us, offset_min);
  char* const text = g_date_time_format(local.get(), "%Y-%m-%dT%H:%M:%S%:z");
  std::string result(text);
  g_free(text);
  return result;
}

std::optional<int> ParseOffset(std::string_view text) {
  if (text == "Z") return 0;
  const bool is_west = text.starts_with('-');
  if (is_west || text.starts_with('+')) text.remove_prefix(1);
  if (text.size() != 5 || text[2] != ':') return std::nullopt;
  const auto hours = ToInteger(text.substr(0, 2), 0, kMostOffsetMin / 60);
  const auto minutes = ToInteger(text.substr(3), 0, 59);
  if (!hours || !minutes || *hours * 60 + *minutes > kMostOffsetMin) return std::nullopt;
  return static_cast<int>(*hours * 60 + *minutes) * (is_west ? -1 : 1);
}

std::string OffsetText(int offset_min) {
  const int minutes = std::abs(offset_min);
  return fmt::format("UTC{}{:02}:{:02}", offset_min < 0 ? '-' : '+', minutes / 60, minutes % 60);
}

}  // namespace muster
