#pragma once

#include <cstdint>

#include "lcmtypes/bus/bus.h"

namespace muster::tools {

/// The n-th of an endless row of packets that are none of run `run_id`'s business, each of which a
/// process must reject: another run's word that the mission has ended, garbage, a message cut
/// short, a message of another type than its channel's. A function of (run_id, n).
Packet ForeignPacket(std::int64_t run_id, std::uint64_t n);

}  // namespace muster::tools
