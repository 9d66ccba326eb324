#include "protocol/inbox.h"

#include <algorithm>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "protocol/sender.h"

namespace muster {
namespace {

/// Starts of senders that are told apart; a mission has some tens. Who floods a process with names
/// gets no more memory than this.
constexpr std::size_t kMostStarts = 10'000;
/// Messages in a row that contradict the newest time of their sender.
constexpr int kMostDoubts = 5;

template <class T>
std::optional<Message> DecodeAs(const Packet& packet) {
  std::optional<T> message = Decode<T>(packet.bytes);
  if (!message || !Valid(*message)) return std::nullopt;
  return Message(std::move(*message));
}

/// As the alternative of Message that has this name.
template <std::size_t kIndex = 0>
std::optional<Message> DecodeNamed(std::string_view type, const Packet& packet) {
  if constexpr (kIndex < std::variant_size_v<Message>) {
    using T = std::variant_alternative_t<kIndex, Message>;
    if (type == T::getTypeName()) return DecodeAs<T>(packet);
    return DecodeNamed<kIndex + 1>(type, packet);
  }
  return std::nullopt;
}

}  // namespace

std::optional<Message> DecodeMessage(const Packet& packet) {
  const Channel* row = FindChannel(packet.channel);
  return row == nullptr ? std::nullopt : DecodeNamed(row->type, packet);
}

std::int64_t GapsIn(const IntervalSet& seqs) {
  constexpr std::int64_t kMost = 1'000'000'000'000;
  return seqs.max() < 0 ? 0 : std::min(kMost, seqs.max() - seqs.size() + 1);
}

const header_t& HeaderOf(const Message& message) {
  return std::visit([](const auto& m) -> const header_t& { return m.header; }, message);
}

Inbox::Inbox(std::int64_t run_id, std::string own_name, std::int64_t own_boot_id)
    : run_id_(run_id), own_name_(std::move(own_name)), own_boot_id_(own_boot_id) {}

std::optional<Message> Inbox::Open(const Packet& packet) {
  std::optional<Message> message = DecodeMessage(packet);
  if (!Admit(packet, message)) message.reset();
  return message;
}

bool Inbox::Admit(const Packet& packet, const std::optional<Message>& message) {
  if (!message) {
    ++counters_.rejected;
    return false;
  }
  const header_t& header = HeaderOf(*message);
  if (header.sender == own_name_) return false;
  // An earlier launcher's processes, back behind a cut, go on with what the mission has left.
  if (header.run_id != run_id_ || IsOfEarlierLauncher(header.boot_id, own_boot_id_) ||
      !FindChannel(packet.channel)->AcceptsFrom(header.sender) || !Count(*message)) {
    ++counters_.rejected;
    return false;
  }
  ++counters_.received;
  return true;
}

bool Inbox::Count(const Message& message) {
  const header_t& header = HeaderOf(message);
  const std::pair key(header.sender, header.boot_id);
  if (starts_.size() == kMostStarts && !starts_.contains(key)) return false;
  Start& start = starts_[key];
  // A heartbeat bears the time of the last clock heard, and a world that starts again may go back
  // behind that; what its sender does was not undone.
  if (header.seq > start.newest_seq && !std::holds_alternative<process_status_t>(message)) {
    // When nobody confirms what seemed newest, it was damaged or forged.
    if (header.sim_us < start.newest_sim_us && ++start.doubts < kMostDoubts) return false;
    start.newest_sim_us = header.sim_us;
    start.doubts = 0;
  }
  start.newest_seq = std::max(start.newest_seq, header.seq);
  return true;
}

}  // namespace muster
