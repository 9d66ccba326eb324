#include "lcmtypes/bus/udpm_receiver.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "base/check.h"
#include "lcmtypes/bus/limits.h"
#include "lcmtypes/bus/seal.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

constexpr std::size_t kDatagramBytes = 65536;
constexpr std::size_t kShortHeader = 8;
constexpr std::size_t kLongHeader = 20;
/// A mission has some tens of senders; more at a time are none.
constexpr std::size_t kMostPartial = 64;
constexpr int kMostBatches = 32;

std::uint32_t Big32(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
         std::uint32_t{bytes[2]} << 8 | bytes[3];
}
std::uint32_t Big16(const std::uint8_t* bytes) { return std::uint32_t{bytes[0]} << 8 | bytes[1]; }

/// The name that the bytes begin with, up to its NUL; empty: none.
std::string_view NameIn(const std::uint8_t* bytes, std::size_t size) {
  const auto* end = static_cast<const std::uint8_t*>(
      std::memchr(bytes, 0, std::min<std::size_t>(size, kMostChannelBytes + 1)));
  if (end == nullptr) return {};
  return {reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(end - bytes)};
}

}  // namespace

void UdpmAssembler::Take(std::uint64_t sender, const std::uint8_t* datagram, std::size_t size,
                         const OnMessage& on_message) {
  if (size < kShortHeader) return;
  if (std::memcmp(datagram, "LC03", 4) == 0) {
    return TakeFragment(sender, datagram, size, on_message);
  }
  if (std::memcmp(datagram, "LC02", 4) != 0) return;
  const std::uint8_t* body = datagram + kShortHeader;
  const std::string_view channel = NameIn(body, size - kShortHeader);
  if (channel.empty()) return;
  const std::size_t begin = kShortHeader + channel.size() + 1;
  on_message(channel, datagram + begin, size - begin);
}

void UdpmAssembler::TakeFragment(std::uint64_t sender, const std::uint8_t* datagram,
                                 std::size_t size, const OnMessage& on_message) {
  if (size < kLongHeader) return;
  const std::uint32_t number = Big32(datagram + 4);
  const std::uint32_t message_size = Big32(datagram + 8);
  const std::uint32_t offset = Big32(datagram + 12);
  const std::uint32_t fragment = Big16(datagram + 16);
  const std::uint32_t fragments = Big16(datagram + 18);
  constexpr std::uint32_t largest = LargestMessage();
  if (message_size == 0 || message_size > largest || fragment >= fragments) return;
  const std::uint8_t* data = datagram + kLongHeader;
  std::size_t bytes = size - kLongHeader;

  auto known = partial_.find(sender);
  if (known != partial_.end() &&
      (known->second.number != number || known->second.size != message_size ||
       known->second.has.size() != fragments)) {
    partial_.erase(known);
    known = partial_.end();
  }
  if (fragment == 0) {
    const std::string_view channel = NameIn(data, bytes);
    if (channel.empty()) return;
    data += channel.size() + 1;
    bytes -= channel.size() + 1;
    if (known == partial_.end()) {
      if (partial_.size() >= kMostPartial) partial_.erase(partial_.begin());
      Partial& begun = partial_[sender];
      begun = {number,
               message_size,
               std::string(channel),
               std::vector<bool>(fragments),
               fragments,
               message_size,
               std::unique_ptr<std::uint8_t[]>(new std::uint8_t[message_size])};
      known = partial_.find(sender);
    }
  }
  if (known == partial_.end()) return;
  Partial& partial = known->second;
  if (partial.has[fragment]) return;
  if (offset > message_size || bytes > message_size - offset || bytes > partial.missing_bytes) {
    partial_.erase(known);
    return;
  }
  std::copy_n(data, bytes, partial.bytes.get() + offset);
  partial.has[fragment] = true;
  partial.missing_bytes -= bytes;
  if (--partial.missing > 0) return;
  const Partial whole = std::move(partial);
  partial_.erase(known);
  // Fragments that overlap leave a hole.
  if (whole.missing_bytes == 0) on_message(whole.channel, whole.bytes.get(), whole.size);
}

std::unique_ptr<UdpmReceiver> UdpmReceiver::Open(const MulticastUrl& url,
                                                 GuardedChannels channels) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return nullptr;
  std::unique_ptr<UdpmReceiver> receiver(new UdpmReceiver(fd));
  const int bytes = kBufferBytes, yes = 1;
  if (setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes) != 0) {
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  }
  int given = 0;
  socklen_t length = sizeof given;
  if (getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &given, &length) != 0 || given < kLeastBufferBytes ||
      GuardSocket(fd, channels)) {
    return nullptr;
  }
  sockaddr_in local{};
  local.sin_family = AF_INET;
  local.sin_port = htons(url.port);
  local.sin_addr.s_addr = htonl(INADDR_ANY);
  ip_mreq membership{};
  membership.imr_interface.s_addr = htonl(INADDR_ANY);
  if (setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
      bind(fd, reinterpret_cast<const sockaddr*>(&local), sizeof local) != 0 ||
      inet_pton(AF_INET, url.address.c_str(), &membership.imr_multiaddr) != 1 ||
      setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0) {
    return nullptr;
  }
  return receiver;
}

UdpmReceiver::UdpmReceiver(int fd)
    : fd_(fd),
      // Touched, and so taken from the system, only as far as datagrams reach.
      buffer_(std::make_unique_for_overwrite<std::uint8_t[]>(kBatch * kDatagramBytes)),
      headers_(kBatch),
      parts_(kBatch),
      senders_(kBatch) {
  for (std::size_t i = 0; i < kBatch; ++i) {
    parts_[i] = {buffer_.get() + i * kDatagramBytes, kDatagramBytes};
    headers_[i].msg_hdr.msg_iov = &parts_[i];
    headers_[i].msg_hdr.msg_iovlen = 1;
    headers_[i].msg_hdr.msg_name = &senders_[i];
  }
}

UdpmReceiver::~UdpmReceiver() { close(fd_); }

bool UdpmReceiver::Receive(const UdpmAssembler::OnMessage& on_message) {
  for (int batch = 0; batch < kMostBatches; ++batch) {
    for (mmsghdr& header : headers_) header.msg_hdr.msg_namelen = sizeof(sockaddr_in);
    const int got = recvmmsg(fd_, headers_.data(), kBatch, MSG_DONTWAIT, nullptr);
    if (got < 0) {
      // What a network that is gone has to say is heard when something is sent.
      if (errno == EAGAIN || errno == EINTR || errno == ENETDOWN || errno == ECONNREFUSED) {
        return batch > 0;
      }
      throw SystemError(fmt::format("cannot receive: {}", std::strerror(errno)));
    }
    for (int i = 0; i < got; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const std::uint64_t sender =
          std::uint64_t{senders_[at].sin_addr.s_addr} << 16 | senders_[at].sin_port;
      assembler_.Take(sender, buffer_.get() + at * kDatagramBytes, headers_[at].msg_len,
                      on_message);
    }
    if (static_cast<std::size_t>(got) < kBatch) return true;
  }
  return true;
}

}  // namespace muster
