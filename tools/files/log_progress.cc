#include "tools/files/log_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

namespace muster::tools {
namespace {

constexpr TimeUs kQuietUs = 2 * kSecondUs;
constexpr std::int64_t kLookBytes = 1 << 20;  ///< between two looks at the clock
constexpr std::size_t kHeadBytes = 28;        ///< of an event, before channel and data

/// The mission's processes have a clock of their own, which knows the model; the audit does not.
TimeUs SteadyUs() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

LogProgress::LogProgress(std::string what, const std::vector<std::string>& files)
    : what_(std::move(what)), start_us_(SteadyUs()), printer_(stderr, StyleFor(stderr, false)) {
  for (const std::string& file : files) {
    std::error_code gone;
    const auto bytes = std::filesystem::file_size(file, gone);
    if (!gone) all_bytes_ += static_cast<std::int64_t>(bytes);
  }
}

std::string LogProgress::Line(const std::string& what, std::int64_t read_bytes,
                              std::int64_t all_bytes) {
  const double share =
      all_bytes > 0 ? static_cast<double>(read_bytes) / static_cast<double>(all_bytes) : 1;
  const double all = static_cast<double>(all_bytes);
  return fmt::format(
      "{}: {:.0f} % of {} read", what, 100 * std::min(1.0, share),
      all >= 1e9 ? fmt::format("{:.1f} GB", all / 1e9) : fmt::format("{:.1f} MB", all / 1e6));
}

void LogProgress::Add(const LogEvent& event) {
  read_bytes_ += static_cast<std::int64_t>(kHeadBytes + event.packet.channel.size() +
                                           event.packet.bytes.size() + event.tag.size());
  if (std::abs(read_bytes_ - looked_bytes_) < kLookBytes) return;
  looked_bytes_ = read_bytes_;
  const TimeUs now_us = SteadyUs();
  if (now_us - start_us_ < kQuietUs || !printer_.due(now_us)) return;
  printer_.Show(Line(what_, read_bytes_, all_bytes_), now_us);
}

}  // namespace muster::tools
