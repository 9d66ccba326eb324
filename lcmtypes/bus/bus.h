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

/// What every process of a mission talks through. One thread uses it. Nothing sent is assumed to
/// arrive; whatever arrives may be old, doubled or garbage.
class Bus {
 public:
  virtual ~Bus() = default;
  /// Sends once. Throws SystemError when the host refuses (no multicast route, say).
  virtual void Publish(const Packet& packet) = 0;
  /// Waits until something arrives or `timeout_us` has passed (0: only looks), then takes all that
  /// is there, in order of arrival. Returns at once when a signal arrives.
  virtual std::vector<Packet> Receive(std::int64_t timeout_us) = 0;
};

}  // namespace muster
