#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/random.h"

namespace muster {

/// A UDP datagram's payload.
using Datagram = std::vector<std::uint8_t>;

/// What LCM sends of a message: one datagram, or its fragments.
std::vector<Datagram> DatagramsOf(std::string_view channel, const Datagram& message,
                                  std::uint32_t number = 1);

/// A fragment with that header. Any bytes may follow it.
struct FragmentHeader {
  std::uint32_t number = 1;
  std::uint32_t size = 0;
  std::uint32_t offset = 0;
  std::uint16_t fragment = 0;
  std::uint16_t fragments = 1;
};
Datagram Fragment(const FragmentHeader& header, const Datagram& body);

/// Whether liblcm 1.3.1 takes it without reading or writing out of bounds, and the message may be
/// one of a mission; written anew from its source, not from the guard.
bool IsSafeForLcm(const Datagram& datagram);

/// Changes a few bytes of its first `most` ones, cuts it short or lengthens it.
void Damage(Random* random, std::size_t most, Datagram* datagram);

/// Sends datagrams to a multicast address on this host (ttl 0).
class RawSender {
 public:
  explicit RawSender(std::uint16_t port, const char* address = "239.255.76.67");
  ~RawSender();
  RawSender(const RawSender&) = delete;
  RawSender& operator=(const RawSender&) = delete;
  /// What the kernel does not take now is lost.
  void Send(const Datagram& datagram);

 private:
  int fd_;
  std::uint16_t port_;
  std::uint32_t address_;
};

}  // namespace muster
