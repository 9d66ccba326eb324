#include "simulation/virtual_network.h"

#include <algorithm>

#include "lcmtypes/bus/limits.h"

namespace muster::simulation {
namespace {

/// Linux' usual net.core.rmem_default, and about what it counts for a packet beside its bytes.
constexpr std::size_t kSocketBytes = 212'992;
constexpr std::size_t kPacketBytes = 768;

}  // namespace

VirtualNetwork::VirtualNetwork(std::uint64_t seed, const Latency& latency)
    : latency_(latency), random_(seed, Stream::kLatency) {}

void VirtualNetwork::Join(Participant* participant) { participants_.push_back(participant); }

void VirtualNetwork::Leave(Participant* participant) {
  std::erase(participants_, participant);
  std::erase_if(arrivals_, [&](const auto& a) { return a.second.receiver == participant; });
  std::erase_if(last_arrival_us_, [&](const auto& way) {
    return way.first.first == participant || way.first.second == participant;
  });
}

void VirtualNetwork::Send(const Participant& sender, Packet packet) {
  RequireAcceptable(packet);
  if (tap_) tap_(sender, packet);
  const auto sent = std::make_shared<const Packet>(std::move(packet));
  const auto span = static_cast<std::uint32_t>(latency_.longest_us - latency_.shortest_us) + 1;
  for (Participant* receiver : participants_) {
    TimeUs& last_us = last_arrival_us_[{&sender, receiver}];
    last_us = std::max(last_us, now_us_ + latency_.shortest_us + random_.Below(span));
    arrivals_.emplace_hint(arrivals_.end(), std::pair(last_us, serial_++), Arrival{receiver, sent});
  }
}

bool VirtualNetwork::Advance(TimeUs until_us) {
  TimeUs next_us = arrivals_.empty() ? kNever : arrivals_.begin()->first.first;
  Participant* waker = nullptr;
  for (Participant* participant : participants_) {
    const TimeUs wake_us = participant->wake_us();
    if (wake_us < next_us) {
      next_us = wake_us;
      waker = participant;
    }
  }
  if (next_us > until_us) {
    now_us_ = std::max(now_us_, until_us);
    return false;
  }
  now_us_ = std::max(now_us_, next_us);
  if (waker != nullptr) {
    waker->Wake();
  } else {
    const auto arrival = arrivals_.extract(arrivals_.begin());
    arrival.mapped().receiver->OnArrival(arrival.mapped().packet);
  }
  return true;
}

void VirtualSocket::Publish(const Packet& packet) { network_->Send(*owner_, packet); }

std::vector<Packet> VirtualSocket::Receive(std::int64_t /*timeout_us*/) {
  std::vector<Packet> packets;
  packets.reserve(queue_.size());
  for (const SentPacket& packet : queue_) packets.push_back(*packet);
  queue_.clear();
  bytes_ = 0;
  return packets;
}

void VirtualSocket::Enqueue(const SentPacket& packet) {
  const std::size_t size = packet->bytes.size() + kPacketBytes;
  // As in a socket, what is there first decides: one packet always fits.
  if (!queue_.empty() && bytes_ + size > kSocketBytes) {
    ++overflowed_;
    return;
  }
  bytes_ += size;
  queue_.push_back(packet);
}

VirtualBus::VirtualBus(VirtualNetwork* network) : network_(network), socket_(network, this) {
  network_->Join(this);
}

VirtualBus::~VirtualBus() { network_->Leave(this); }

std::vector<Packet> VirtualBus::Receive(std::int64_t timeout_us) {
  const TimeUs until_us = network_->now_us() + timeout_us;
  while (socket_.empty() && network_->Advance(until_us)) {
  }
  return socket_.Receive(0);
}

}  // namespace muster::simulation
