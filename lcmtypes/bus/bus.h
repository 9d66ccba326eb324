#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace muster {

/// One message as it goes over the wire: channel and LCM-encoded bytes (fingerprint first).
struct Packet {
  std::string channel;
  std::vector<std::uint8_t> bytes;
  bool operator==(const Packet&) const = default;
};

/// What every process of a mission talks through. One thread uses it. Packets may be lost; those
/// that arrive may be old, doubled or garbage.
class Bus {
 public:
  virtual ~Bus() = default;
  /// Sends once; in an outage it is lost. Throws SystemError when the packet cannot be sent at all.
  virtual void Publish(const Packet& packet) = 0;
  /// Waits until something arrives or `timeout_us` has passed (0: only looks), then takes all that
  /// is there, in order of arrival. Returns at once when a signal arrives.
  virtual std::vector<Packet> Receive(std::int64_t timeout_us) = 0;
  /// Why the network takes nothing now (no route, no link); "": it does. Receive finds out when it
  /// is back, and returns only after a moment until then.
  virtual std::string Outage() const { return ""; }
  /// For how long in all the bus could not send, microseconds: answers were impossible meanwhile.
  virtual std::int64_t outage_us() const { return 0; }
};

}  // namespace muster
