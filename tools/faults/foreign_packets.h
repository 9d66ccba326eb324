#pragma once

#include <cstdint>

#include "lcmtypes/bus/bus.h"

namespace muster::tools {

/// The n-th packet of an endless sequence that every process of run `run_id` must reject: another
/// run's message that its mission has ended, garbage, a message cut short, a message of another
/// type than its channel's. A function of (run_id, n).
Packet ForeignPacket(std::int64_t run_id, std::uint64_t n);

}  // namespace muster::tools
