#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lcmtypes/bus/datagram_guard.h"
#include "lcmtypes/bus/multicast.h"

namespace muster {

/// Puts messages together from LCM's datagrams (LC02: a whole message, LC03: a fragment). It
/// trusts none of them: a datagram that contradicts itself or an earlier one is dropped.
///
/// Source: the wire format of liblcm 1.3.1, udpm_util.h. As there, a sender's message begins with
/// its first fragment, and the next message of that sender ends one that is not complete.
class UdpmAssembler {
 public:
  /// channel, bytes; valid during the call.
  using OnMessage =
      std::function<void(std::string_view channel, const std::uint8_t* data, std::size_t size)>;

  /// `sender`: any number that tells one sender of datagrams from another.
  void Take(std::uint64_t sender, const std::uint8_t* datagram, std::size_t size,
            const OnMessage& on_message);

 private:
  struct Partial {
    std::uint32_t number = 0;
    std::uint32_t size = 0;
    std::string channel = {};
    std::vector<bool> has = {};  ///< [fragments]
    std::size_t missing = 0;
    std::size_t missing_bytes = 0;
    std::unique_ptr<std::uint8_t[]> bytes = {};  ///< not touched before it is filled
  };
  void TakeFragment(std::uint64_t sender, const std::uint8_t* datagram, std::size_t size,
                    const OnMessage& on_message);

  std::map<std::uint64_t, Partial> partial_;  ///< by sender
};

/// A socket of LCM's multicast group that the process reads itself: all that has come in by one
/// call of the system, in the thread that waits for it. liblcm reads in a thread of its own and
/// hands each message over through a pipe, some six calls and two switches a message; it must,
/// since a buffer of the usual size is full before a process that is busy looks at it again.
class UdpmReceiver {
 public:
  /// Joins the group, guarded (datagram_guard.h) from before it can hear anything. None: the kernel
  /// gives no buffer that holds what comes in while a process is busy (kLeastBufferBytes).
  static std::unique_ptr<UdpmReceiver> Open(const MulticastUrl& url, GuardedChannels channels);
  ~UdpmReceiver();
  UdpmReceiver(const UdpmReceiver&) = delete;
  UdpmReceiver& operator=(const UdpmReceiver&) = delete;

  int fd() const { return fd_; }
  /// Hands out what is there now, at most some hundred datagrams; false: nothing was. Throws
  /// SystemError.
  bool Receive(const UdpmAssembler::OnMessage& on_message);

  static constexpr int kBufferBytes = 32 << 20;
  static constexpr int kLeastBufferBytes = 16 << 20;

 private:
  explicit UdpmReceiver(int fd);

  static constexpr std::size_t kBatch = 16;
  int fd_;
  UdpmAssembler assembler_;
  std::unique_ptr<std::uint8_t[]> buffer_;  ///< [kBatch] datagrams, not initialised
  std::vector<mmsghdr> headers_;
  std::vector<iovec> parts_;
  std::vector<sockaddr_in> senders_;
};

}  // namespace muster
