#include "lcmtypes/bus/lossy_bus.h"

#include <algorithm>
#include <limits>

#include "base/check.h"
#include "base/random.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

/// FNV-1a, 64 bit.
std::uint64_t HashOf(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

std::uint64_t HashOf(const Packet& packet) {
  return HashOf(packet.channel) ^
         HashOf({reinterpret_cast<const char*>(packet.bytes.data()), packet.bytes.size()});
}

/// The world repeats a scheduler's decision as it came.
bool IsSentOn(const Packet& packet) {
  return packet.channel == channel::kSchedule || packet.channel == channel::kClearances;
}
/// A decision may have many clearances.
constexpr std::size_t kMostSignatures = 1000;

bool IsShare(double value) { return value >= 0 && value <= 1; }

}  // namespace

LossyBus::LossyBus(std::unique_ptr<Bus> bus, std::uint64_t seed, std::string_view name,
                   std::function<std::int64_t()> now_us)
    : bus_(std::move(bus)), seed_(seed ^ HashOf(name)), now_us_(std::move(now_us)) {}

void LossyBus::SetFaults(const PacketFaults& faults) {
  MUSTER_CHECK(IsShare(faults.loss) && IsShare(faults.duplication) && IsShare(faults.reorder) &&
                   IsShare(faults.corrupt),
               "loss {}, duplication {}, reorder {}, corrupt {}", faults.loss, faults.duplication,
               faults.reorder, faults.corrupt);
  MUSTER_CHECK(faults.delay_us >= 0 && faults.jitter_us >= 0, "delay {} us, jitter {} us",
               faults.delay_us, faults.jitter_us);
  faults_ = faults;
}

bool LossyBus::IsUnheard(const Packet& packet) const {
  if (faults_.unheard.empty()) return false;
  Packet message = packet;
  CutTag(&message);
  const std::optional<header_t> header = DecodeHeader(message);
  return header && faults_.unheard.count(header->sender) > 0;
}

void LossyBus::Publish(const Packet& packet) {
  if (faults_.partition) {
    ++counters_.lost;
    return;
  }
  bus_->Publish(seal_ ? Closed(packet) : packet);
}

Packet LossyBus::Closed(const Packet& packet) const {
  Tag tag = seal_->TagOf(packet);
  if (tag.empty()) {
    const auto heard =
        std::find_if(signatures_.begin(), signatures_.end(),
                     [hash = HashOf(packet)](const auto& one) { return one.first == hash; });
    if (heard != signatures_.end()) tag = heard->second;
  }
  return WithTag(packet, tag);
}

void LossyBus::Open(std::vector<Packet>* packets) {
  if (!seal_) return;
  std::vector<Packet> opened;
  opened.reserve(packets->size());
  for (Packet& packet : *packets) {
    const std::size_t tag_bytes = std::min(packet.bytes.size(), seal_->tag_bytes());
    Tag tag(packet.bytes.end() - static_cast<std::ptrdiff_t>(tag_bytes), packet.bytes.end());
    if (seal_->Open(&packet)) {
      if (proves_senders() && IsSentOn(packet)) {
        signatures_.emplace_front(HashOf(packet), std::move(tag));
        if (signatures_.size() > kMostSignatures) signatures_.pop_back();
      }
      opened.push_back(std::move(packet));
    } else {
      ++refused_;
      newest_refused_ = std::move(packet);
    }
  }
  *packets = std::move(opened);
}

void LossyBus::Admit(Packet packet, std::int64_t now_us) {
  // Every draw is made whatever the faults are: raising one share changes no other's victims.
  Random random(seed_, Stream::kPacketFault, arrivals_++);
  const bool lost = random.Uniform() < faults_.loss;
  const bool doubled = random.Uniform() < faults_.duplication;
  const bool reordered = random.Uniform() < faults_.reorder;
  const bool corrupted = random.Uniform() < faults_.corrupt;
  const std::int64_t delay_us =
      faults_.delay_us +
      static_cast<std::int64_t>(random.Uniform() * static_cast<double>(faults_.jitter_us));
  if (packet.channel == channel::kFault && !faults_.partition) {
    in_flight_.emplace(Key{now_us, released_++}, std::move(packet));
    return Release(now_us);
  }
  if (lost || faults_.partition) {
    ++counters_.lost;
    return;
  }
  if (IsUnheard(packet)) {
    ++counters_.unheard;
    return;
  }
  counters_.delayed += delay_us > 0;
  if (corrupted && !packet.bytes.empty()) {
    const std::uint32_t at = random.Below(static_cast<std::uint32_t>(packet.bytes.size()));
    packet.bytes[at] = static_cast<std::uint8_t>(packet.bytes[at] ^ (1u << random.Below(8)));
    ++counters_.corrupted;
  }
  if (reordered) {
    held_back_.insert(held_back_.end(), doubled ? 2 : 1, {std::move(packet), delay_us});
    ++counters_.reordered;
    counters_.duplicated += doubled;
    return;
  }
  if (doubled) {
    in_flight_.emplace(Key{now_us + delay_us, released_++}, packet);
    ++counters_.duplicated;
  }
  in_flight_.emplace(Key{now_us + delay_us, released_++}, std::move(packet));
  Release(now_us);
}

/// Sends on what waited for another packet to pass.
void LossyBus::Release(std::int64_t now_us) {
  for (auto& [packet, delay_us] : held_back_) {
    in_flight_.emplace(Key{now_us + delay_us, released_++}, std::move(packet));
  }
  held_back_.clear();
}

std::int64_t LossyBus::due_us() const {
  return in_flight_.empty() ? std::numeric_limits<std::int64_t>::max()
                            : in_flight_.begin()->first.first;
}

std::vector<Packet> LossyBus::TakeDue(std::int64_t now_us) {
  std::vector<Packet> due;
  auto next = in_flight_.begin();
  while (next != in_flight_.end() && next->first.first <= now_us) {
    due.push_back(std::move(next->second));
    next = in_flight_.erase(next);
  }
  return due;
}

std::vector<Packet> LossyBus::Receive(std::int64_t timeout_us) {
  std::int64_t now_us = now_us_();
  const std::int64_t deadline_us = now_us + std::max<std::int64_t>(timeout_us, 0);
  for (;;) {
    const std::int64_t wake_us = std::min(deadline_us, due_us());
    std::vector<Packet> arrived = bus_->Receive(std::max<std::int64_t>(wake_us - now_us, 0));
    now_us = now_us_();
    for (Packet& packet : arrived) Admit(std::move(packet), now_us);
    if (arrived.empty()) Release(now_us);  // nothing came that could pass
    std::vector<Packet> due = TakeDue(now_us);
    Open(&due);
    // Empty-handed before its time: a signal came, which ends the wait.
    const bool interrupted = arrived.empty() ? now_us < wake_us : returns_on_arrival_;
    if (!due.empty() || interrupted || now_us >= deadline_us) return due;
  }
}

}  // namespace muster
