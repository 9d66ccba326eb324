#include "tests/lcmtypes/datagrams.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

namespace muster {
namespace {

constexpr std::size_t kShortest = 8, kFragmentHeader = 20;
constexpr std::size_t kMostBytes = 65507;  // of UDP over IPv4
constexpr std::size_t kMostBody = 65487, kMostShortBody = 65499;

void Append(std::uint32_t value, int bytes, Datagram* datagram) {
  for (int i = bytes - 1; i >= 0; --i) {
    datagram->push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
}
std::uint64_t Number(const Datagram& datagram, std::size_t at, int bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) value = value << 8 | datagram[at + static_cast<std::size_t>(i)];
  return value;
}

/// Bytes of channel and NUL from `at` on; 0 when there is none that LCM can take.
std::size_t NameBytes(const Datagram& datagram, std::size_t at) {
  const auto begin = datagram.begin() + static_cast<std::ptrdiff_t>(at);
  const auto end = std::find(begin, datagram.end(), 0);
  const auto length = end - begin;
  const bool readable = std::all_of(begin, end, [](std::uint8_t c) { return c > ' ' && c <= '~'; });
  if (end == datagram.end() || length == 0 || length > 63 || !readable) return 0;
  return static_cast<std::size_t>(length) + 1;
}

}  // namespace

Datagram Fragment(const FragmentHeader& header, const Datagram& body) {
  Datagram datagram{'L', 'C', '0', '3'};
  for (const std::uint32_t value : {header.number, header.size, header.offset}) {
    Append(value, 4, &datagram);
  }
  Append(header.fragment, 2, &datagram);
  Append(header.fragments, 2, &datagram);
  datagram.insert(datagram.end(), body.begin(), body.end());
  return datagram;
}

std::vector<Datagram> DatagramsOf(std::string_view channel, const Datagram& message,
                                  std::uint32_t number) {
  Datagram body(channel.begin(), channel.end());
  body.push_back(0);
  const std::size_t name_bytes = body.size();
  body.insert(body.end(), message.begin(), message.end());
  if (body.size() <= kMostShortBody) {
    Datagram datagram{'L', 'C', '0', '2'};
    Append(number, 4, &datagram);
    datagram.insert(datagram.end(), body.begin(), body.end());
    return {datagram};
  }
  std::vector<Datagram> datagrams;
  const std::size_t count = (body.size() + kMostBody - 1) / kMostBody;
  for (std::size_t i = 0; i < count; ++i) {
    const auto first = body.begin() + static_cast<std::ptrdiff_t>(i * kMostBody);
    const auto last =
        body.begin() + static_cast<std::ptrdiff_t>(std::min(body.size(), (i + 1) * kMostBody));
    const std::size_t offset = i == 0 ? 0 : i * kMostBody - name_bytes;
    datagrams.push_back(Fragment(
        {number, static_cast<std::uint32_t>(message.size()), static_cast<std::uint32_t>(offset),
         static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(count)},
        Datagram(first, last)));
  }
  return datagrams;
}

bool IsSafeForLcm(const Datagram& datagram) {
  if (datagram.size() < kShortest) return false;
  if (std::memcmp(datagram.data(), "LC02", 4) == 0) return NameBytes(datagram, kShortest) > 0;
  if (std::memcmp(datagram.data(), "LC03", 4) != 0) return false;
  if (datagram.size() <= kFragmentHeader) return false;
  const std::uint64_t size = Number(datagram, 8, 4);
  const std::uint64_t offset = Number(datagram, 12, 4);
  const std::uint64_t fragment = Number(datagram, 16, 2);
  const std::uint64_t fragments = Number(datagram, 18, 2);
  if (fragment >= fragments || size == 0 || size > 64 << 20) return false;
  const std::uint64_t body = datagram.size() - kFragmentHeader;
  std::uint64_t payload = body;
  if (fragment == 0) {
    const std::size_t name_bytes = NameBytes(datagram, kFragmentHeader);
    if (name_bytes == 0 || offset != 0) return false;
    payload -= name_bytes;
  }
  if (fragment + 1 == fragments) return offset + payload == size;
  return offset + payload <= size && body * fragments >= size;
}

void Damage(Random* random, std::size_t most, Datagram* datagram) {
  const auto below = [random](std::size_t n) {
    return random->Below(static_cast<std::uint32_t>(n));
  };
  if (below(4) == 0) datagram->resize(below(datagram->size() + 1));
  if (below(16) == 0) datagram->resize(datagram->size() + below(100), 'x');
  datagram->resize(std::min(datagram->size(), kMostBytes));
  if (datagram->empty()) return;
  const std::size_t within = std::min(most, datagram->size());
  for (std::uint32_t n = below(4); n > 0; --n) {
    constexpr std::uint8_t kTelling[] = {0, 1, 0x7f, 0x80, 0xff};
    std::uint8_t& byte = (*datagram)[below(within)];
    byte = below(2) == 0 ? kTelling[below(5)] : static_cast<std::uint8_t>(below(256));
  }
}

RawSender::RawSender(std::uint16_t port, const char* address)
    : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)), port_(htons(port)), address_(0) {
  inet_pton(AF_INET, address, &address_);
  const unsigned char ttl = 0;
  setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
}

RawSender::~RawSender() { close(fd_); }

void RawSender::Send(const Datagram& datagram) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = port_;
  to.sin_addr.s_addr = address_;
  sendto(fd_, datagram.data(), datagram.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&to),
         sizeof to);
}

}  // namespace muster
