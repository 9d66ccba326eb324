#include "lcmtypes/protocol/inbox.h"

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

template <class T>
std::optional<Message> DecodeAs(const Packet& packet) {
  std::optional<T> message = Decode<T>(packet.bytes);
  if (!message || !Valid(*message)) return std::nullopt;
  return Message(std::move(*message));
}

std::optional<Message> DecodePacket(const Packet& packet) {
  const std::string_view name = packet.channel;
  if (name == channel::kClock) return DecodeAs<clock_t>(packet);
  if (name == channel::kWorld) return DecodeAs<world_state_t>(packet);
  if (name == channel::kRulings) return DecodeAs<rulings_t>(packet);
  if (name == channel::kUavs || name == channel::kWorkers || name == channel::kVehicles) {
    return DecodeAs<agent_states_t>(packet);
  }
  if (name == channel::kSchedule) return DecodeAs<schedule_t>(packet);
  if (name == channel::kEvent) return DecodeAs<event_t>(packet);
  if (name == channel::kProcess) return DecodeAs<process_status_t>(packet);
  if (name == channel::kLog) return DecodeAs<log_status_t>(packet);
  if (name == channel::kRequest) return DecodeAs<request_t>(packet);
  if (name == channel::kRestore) return DecodeAs<restore_t>(packet);
  if (name == channel::kScenario) return DecodeAs<scenario_t>(packet);
  if (name == channel::kFault) return DecodeAs<fault_t>(packet);
  return std::nullopt;
}

}  // namespace

bool SeqCoverage::Add(std::int64_t seq) {
  if (seq < next_ || !ahead_.insert(seq).second) return false;
  while (!ahead_.empty() && *ahead_.begin() == next_) {
    ahead_.erase(ahead_.begin());
    ++next_;
  }
  return true;
}

Inbox::Inbox(std::int64_t run_id, std::string own_name)
    : run_id_(run_id), own_name_(std::move(own_name)) {}

std::optional<Message> Inbox::Open(const Packet& packet) {
  std::optional<Message> message = DecodePacket(packet);
  if (!message) {
    ++counters_.rejected;
    return std::nullopt;
  }
  const header_t& header =
      std::visit([](const auto& m) -> const header_t& { return m.header; }, *message);
  if (header.sender == own_name_) return std::nullopt;
  if (header.run_id != run_id_) {
    ++counters_.rejected;
    return std::nullopt;
  }
  ++counters_.received;
  seen_[{header.sender, header.boot_id}].Add(header.seq);
  return message;
}

std::int64_t Inbox::lost() const {
  std::int64_t lost = 0;
  for (const auto& [sender, coverage] : seen_) lost += coverage.missing();
  return lost;
}

}  // namespace muster
