#include "tools/faults/foreign_packets.h"

#include "base/random.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::tools {

Packet ForeignPacket(std::int64_t run_id, std::uint64_t n) {
  clock_t clock{};
  clock.header.run_id = run_id + 1;
  clock.header.sender = process_name::kWorld;
  clock.header.seq = static_cast<std::int64_t>(n);
  clock.tick = 1'000'000;
  clock.phase = NumberOf(ClockPhase::kEnded);
  switch (n % 4) {
    case 0:
      return {std::string(channel::kClock), Encode(clock)};
    case 1: {
      Random random(static_cast<std::uint64_t>(run_id), Stream::kPacketFault, n);
      Packet garbage{std::string(channel::kWorld), {}};
      for (int i = 0; i < 200; ++i) {
        garbage.bytes.push_back(static_cast<std::uint8_t>(random.Below(256)));
      }
      return garbage;
    }
    case 2: {
      Packet cut{std::string(channel::kClock), Encode(clock)};
      cut.bytes.resize(cut.bytes.size() - 1 - n / 4 % 8);
      return cut;
    }
    default:
      return {std::string(channel::kSchedule), Encode(clock)};
  }
}

}  // namespace muster::tools
