// Arbitrary bytes as every type of the channel table: no crash, no read out of bounds, no memory
// that the input does not justify, and what is accepted encodes to the same bytes.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

template <class T>
void Check(const std::vector<std::uint8_t>& bytes, const char* channel) {
  const std::optional<T> message = Decode<T>(bytes);
  const std::optional<header_t> header = DecodeHeader({channel, bytes});
  if (!message) {
    MUSTER_CHECK(!header);
    return;
  }
  MUSTER_CHECK(Encode(*message) == bytes);
  MUSTER_CHECK(header.has_value() == Valid(message->header));
  if (Valid(*message)) MUSTER_CHECK(header.has_value());
}

}  // namespace
}  // namespace muster

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  const std::vector<std::uint8_t> bytes(data, data + size);
  Check<agent_changes_t>(bytes, "MUSTER_UAV_CHANGES");
  Check<agent_states_t>(bytes, "MUSTER_UAVS");
  Check<muster::clock_t>(bytes, "MUSTER_CLOCK");
  Check<clearances_t>(bytes, "MUSTER_CLEARANCES");
  Check<proposal_t>(bytes, "MUSTER_PROPOSAL");
  Check<event_t>(bytes, "MUSTER_EVENT");
  Check<fault_t>(bytes, "MUSTER_FAULT");
  Check<log_status_t>(bytes, "MUSTER_LOG");
  Check<order_t>(bytes, "MUSTER_ORDER");
  Check<orders_t>(bytes, "MUSTER_ORDERS");
  Check<process_status_t>(bytes, "MUSTER_PROCESS");
  Check<request_t>(bytes, "MUSTER_REQUEST");
  Check<restore_t>(bytes, "MUSTER_RESTORE");
  Check<answer_t>(bytes, "MUSTER_ANSWER");
  Check<roads_t>(bytes, "MUSTER_ROADS");
  Check<rulings_t>(bytes, "MUSTER_RULINGS");
  Check<scenario_t>(bytes, "MUSTER_SCENARIO");
  Check<schedule_t>(bytes, "MUSTER_SCHEDULE");
  Check<world_state_t>(bytes, "MUSTER_WORLD");
  return 0;
}
