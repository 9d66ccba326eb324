#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/seal.h"
#include "lcmtypes/channels.h"

namespace muster {

inline constexpr std::uint32_t kMostChannelBytes = 63;  ///< LCM_MAX_CHANNEL_NAME_LENGTH

/// Bytes of the largest message of any channel, with its tag.
constexpr std::uint32_t LargestMessage() {
  std::int64_t most = 0;
  for (const Channel& row : kChannels) most = std::max(most, row.max_bytes);
  return static_cast<std::uint32_t>(most) + kMostTagBytes;
}

/// Whether a received packet is worth looking at: a channel of the table, not larger than its
/// maximum.
bool Acceptable(const Packet& packet);

/// Throws SystemError, naming channel, size and limit, when receivers would not accept the packet,
/// `tag_bytes` of which are behind the message.
void RequireAcceptable(const Packet& packet, std::size_t tag_bytes = 0);

}  // namespace muster
