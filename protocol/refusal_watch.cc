#include "protocol/refusal_watch.h"

#include <fmt/format.h>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

constexpr TimeUs kAgainUs = 10 * kSecondUs;

/// "says that it is world (pid 7 on host)", as far as the packet tells.
std::string Claim(Packet packet) {
  CutTag(&packet);
  const std::optional<header_t> header = DecodeHeader(packet);
  if (!header) return "is no message";
  std::string text = fmt::format("says that it is of {}", header->sender);
  const auto status = packet.channel == channel::kProcess
                          ? DecodeValid<process_status_t>(packet.bytes)
                          : std::nullopt;
  if (status) text += fmt::format(", pid {} on {}", status->pid, status->host);
  return text;
}

}  // namespace

std::optional<std::string> RefusalWatch::Line(const LossyBus& bus, TimeUs now_us) {
  const std::int64_t news = bus.refused() - said_;
  if (news == 0 || (said_us_ != kNever && now_us < said_us_ + kAgainUs)) return {};
  said_ = bus.refused();
  said_us_ = now_us;
  return fmt::format(
      "{} packet{} without the mission's tag refused, of somebody without its key, or damaged; the "
      "newest, on {}, {}",
      news, news == 1 ? "" : "s", bus.newest_refused().channel, Claim(bus.newest_refused()));
}

}  // namespace muster
