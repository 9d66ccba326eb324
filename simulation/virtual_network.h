#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "base/random.h"
#include "base/units.h"
#include "lcmtypes/bus/bus.h"
#include "protocol/sender.h"

namespace muster::simulation {

/// A participant of a virtual network.
class Participant {
 public:
  virtual ~Participant() = default;
  /// A packet has arrived, one's own included, as with multicast.
  virtual void OnArrival(const SentPacket& packet) = 0;
  /// When it wants to be woken; kNever: when something arrives.
  virtual TimeUs wake_us() const = 0;
  virtual void Wake() = 0;
};

/// How long packets travel: drawn for each packet and receiver, uniform in [shortest, longest]
/// microseconds; no packet overtakes an earlier one of its sender. (On loopback 29 us is the median
/// and 95 us the 95th percentile.)
struct Latency {
  TimeUs shortest_us = 20;
  TimeUs longest_us = 100;
};

/// Virtual time, and a network in it over which everybody hears everybody. Time passes only from
/// one arrival or wake to the next, and nothing that happens in it depends on anything but the
/// seed. One thread uses it.
class VirtualNetwork {
 public:
  explicit VirtualNetwork(std::uint64_t seed = 1, const Latency& latency = {});

  TimeUs now_us() const { return now_us_; }

  /// Takes part until it leaves; not owned.
  void Join(Participant* participant);
  void Leave(Participant* participant);
  void Send(const Participant& sender, Packet packet);

  /// `tap` is called with each packet once, when it is sent.
  void set_tap(std::function<void(const Participant& sender, const Packet&)> tap) {
    tap_ = std::move(tap);
  }

  /// Lets the next thing happen, unless it would be after `until_us`: then it becomes that time,
  /// and the answer is false.
  bool Advance(TimeUs until_us);

 private:
  struct Arrival {
    Participant* receiver;
    SentPacket packet;
  };
  using Way = std::pair<const Participant*, const Participant*>;  ///< sender, receiver

  Latency latency_;
  Random random_;
  TimeUs now_us_ = 0;
  std::uint64_t serial_ = 0;
  std::function<void(const Participant&, const Packet&)> tap_;
  std::vector<Participant*> participants_;                        ///< in order of joining
  std::map<std::pair<TimeUs, std::uint64_t>, Arrival> arrivals_;  ///< by time, then as sent
  std::map<Way, TimeUs> last_arrival_us_;  ///< never iterated: order of addresses
};

/// A participant's queue, as bounded as a socket's buffer: what does not fit is lost. Publishes on
/// the network.
class VirtualSocket : public Bus {
 public:
  VirtualSocket(VirtualNetwork* network, const Participant* owner)
      : network_(network), owner_(owner) {}

  void Publish(const Packet& packet) override;
  /// Only looks; it never waits, because virtual time passes elsewhere.
  std::vector<Packet> Receive(std::int64_t timeout_us) override;

  void Enqueue(const SentPacket& packet);
  bool empty() const { return queue_.empty(); }
  /// Packets that found no room.
  std::int64_t overflowed() const { return overflowed_; }

 private:
  VirtualNetwork* network_;
  const Participant* owner_;
  std::vector<SentPacket> queue_;
  std::size_t bytes_ = 0;
  std::int64_t overflowed_ = 0;
};

/// The bus of a caller that drives virtual time from outside: while it waits to receive, everything
/// else happens.
class VirtualBus : public Bus, private Participant {
 public:
  explicit VirtualBus(VirtualNetwork* network);
  ~VirtualBus() override;
  VirtualBus(const VirtualBus&) = delete;
  VirtualBus& operator=(const VirtualBus&) = delete;

  void Publish(const Packet& packet) override { socket_.Publish(packet); }
  std::vector<Packet> Receive(std::int64_t timeout_us) override;

 private:
  void OnArrival(const SentPacket& packet) override { socket_.Enqueue(packet); }
  TimeUs wake_us() const override { return kNever; }
  void Wake() override {}

  VirtualNetwork* network_;
  VirtualSocket socket_;
};

}  // namespace muster::simulation
