#include "protocol/outage_watch.h"

#include <fmt/format.h>

namespace muster {

std::optional<std::string> OutageWatch::Line(const std::string& outage, TimeUs now_us) {
  if (outage.empty() == reason_.empty()) return {};
  if (!outage.empty()) {
    reason_ = outage;
    begun_us_ = now_us;
    return fmt::format("the network is gone ({}): waiting until it is back", outage);
  }
  const TimeUs lasted_us = lasts_us(now_us);
  reason_.clear();
  begun_us_ = kNever;
  return fmt::format("the network is back after {:.1f} s", ToSeconds(lasted_us));
}

}  // namespace muster
