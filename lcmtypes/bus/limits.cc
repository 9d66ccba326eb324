#include "lcmtypes/bus/limits.h"

#include <fmt/format.h>

#include "base/check.h"
#include "lcmtypes/channels.h"

namespace muster {

bool Acceptable(const Packet& packet) {
  const Channel* channel = FindChannel(packet.channel);
  return channel != nullptr && packet.bytes.size() <= static_cast<std::size_t>(channel->max_bytes);
}

void RequireAcceptable(const Packet& packet, std::size_t tag_bytes) {
  const Channel* channel = FindChannel(packet.channel);
  if (channel == nullptr) {
    throw SystemError(fmt::format("cannot publish: no channel '{}'", packet.channel));
  }
  if (packet.bytes.size() > static_cast<std::size_t>(channel->max_bytes) + tag_bytes) {
    throw SystemError(fmt::format("cannot publish on {}: message of {} bytes, at most {} allowed",
                                  packet.channel, packet.bytes.size(), channel->max_bytes));
  }
}

}  // namespace muster
