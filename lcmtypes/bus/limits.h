#pragma once

#include <cstddef>

#include "lcmtypes/bus/bus.h"

namespace muster {

/// Whether a received packet is worth looking at: a channel of the table, not larger than its
/// maximum.
bool Acceptable(const Packet& packet);

/// Throws SystemError, naming channel, size and limit, when receivers would not accept the packet,
/// `tag_bytes` of which are behind the message.
void RequireAcceptable(const Packet& packet, std::size_t tag_bytes = 0);

}  // namespace muster
