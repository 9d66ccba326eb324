#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/seal.h"

namespace muster {

/// What happens to packets on their way in. Shares are probabilities per packet, in [0, 1].
struct PacketFaults {
  double loss = 0;
  double duplication = 0;  ///< arrives twice
  double reorder = 0;      ///< arrives behind the packet that follows it, if one does
  double corrupt = 0;      ///< one bit of its bytes is flipped
  std::int64_t delay_us = 0;
  std::int64_t jitter_us = 0;          ///< further delay, uniform in [0, jitter_us)
  bool partition = false;              ///< neither hears nor is heard
  std::set<std::string> unheard = {};  ///< senders whose packets do not arrive

  bool operator==(const PacketFaults&) const = default;
};

struct PacketFaultCounters {
  std::int64_t lost = 0;     ///< a partition's, both ways, included
  std::int64_t unheard = 0;  ///< of senders that are not heard
  std::int64_t duplicated = 0;
  std::int64_t reordered = 0;
  std::int64_t corrupted = 0;
  std::int64_t delayed = 0;
};

/// A bus that mistreats what it receives. What happens to the n-th packet that arrives is a
/// function of (seed, name, n) and the faults set at that time: for the same order of arrival the
/// same packets are lost, doubled, held back or damaged, and damaged in the same place. Orders
/// about faults always pass, because they begin and end the faults.
class LossyBus : public Bus {
 public:
  /// `name` keeps processes with the same seed from losing the same packets. `now_us`: monotonic
  /// microseconds, by which delays run.
  LossyBus(std::unique_ptr<Bus> bus, std::uint64_t seed, std::string_view name,
           std::function<std::int64_t()> now_us);

  /// From now on what is sent has a tag, and of what arrives only that comes through which has the
  /// right one. A network's faults come before: what they damage is refused.
  void SetSeal(Seal seal) { seal_ = std::move(seal); }
  bool sealed() const { return seal_.has_value(); }
  /// Of what arrives it is known which member has sent it.
  bool proves_senders() const { return seal_ && seal_->members() != nullptr; }
  /// Packets that came without the right tag.
  std::int64_t refused() const { return refused_; }
  /// The newest of them.
  const Packet& newest_refused() const { return newest_refused_; }

  /// From now on Receive returns when anything has arrived, even where nothing of it comes through.
  void ReturnOnArrival() { returns_on_arrival_ = true; }

  /// From now on; shares outside [0, 1] or negative times are a broken invariant. What is being
  /// delayed stays so.
  void SetFaults(const PacketFaults& faults);
  const PacketFaults& faults() const { return faults_; }
  const PacketFaultCounters& counters() const { return counters_; }
  /// When a delayed packet is due next; the largest value when none is on its way.
  std::int64_t due_us() const;

  void Publish(const Packet& packet) override;
  std::vector<Packet> Receive(std::int64_t timeout_us) override;
  std::string Outage() const override { return bus_->Outage(); }
  std::int64_t outage_us() const override { return bus_->outage_us(); }

 private:
  /// (due, order): packets with the same delay keep their order.
  using Key = std::pair<std::int64_t, std::uint64_t>;

  void Admit(Packet packet, std::int64_t now_us);
  void Release(std::int64_t now_us);
  bool IsUnheard(const Packet& packet) const;
  Packet Closed(const Packet& packet) const;
  /// Takes tags off, and out what has none.
  void Open(std::vector<Packet>* packets);
  std::vector<Packet> TakeDue(std::int64_t now_us);

  std::unique_ptr<Bus> bus_;
  std::uint64_t seed_;
  std::function<std::int64_t()> now_us_;
  PacketFaults faults_;
  PacketFaultCounters counters_;
  std::uint64_t arrivals_ = 0;
  std::uint64_t released_ = 0;
  std::vector<std::pair<Packet, std::int64_t>> held_back_;  ///< with their delay
  std::map<Key, Packet> in_flight_;
  std::optional<Seal> seal_;
  /// Signatures of what was heard lately and may be sent on as it is, by a hash of the packet.
  std::deque<std::pair<std::uint64_t, Tag>> signatures_;
  bool returns_on_arrival_ = false;
  std::int64_t refused_ = 0;
  Packet newest_refused_;
};

}  // namespace muster
