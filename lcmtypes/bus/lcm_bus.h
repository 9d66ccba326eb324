#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/multicast.h"

struct _lcm_t;
struct _lcm_recv_buf_t;

namespace muster {

/// Of the LCM that this was built with, "1.3.1".
std::string LcmVersion();

/// Packets that an LcmBus has counted since it was made.
struct LcmBusCounters {
  std::int64_t published = 0;
  std::int64_t received = 0;  ///< handed out by Receive
  std::int64_t rejected = 0;  ///< of an unknown MUSTER_ channel or too large: dropped
  std::int64_t not_sent = 0;  ///< the kernel's buffers were full; lost like any other packet
};

/// The bus over LCM's UDP multicast. A process hears its own packets, too. One thread uses it; LCM
/// reads the socket in a thread of its own, which takes no signals, into an unlimited queue.
class LcmBus : public Bus {
 public:
  /// Joins the multicast group of `url` and sees that a packet comes back. Throws InputError for a
  /// bad URL, SystemError, saying what to do, when the host does not carry multicast.
  explicit LcmBus(const std::string& url);
  ~LcmBus() override;

  void Publish(const Packet& packet) override;
  std::vector<Packet> Receive(std::int64_t timeout_us) override;

  const LcmBusCounters& counters() const { return counters_; }

 private:
  struct Destroy {
    void operator()(_lcm_t* lcm) const;
  };

  static void OnMessage(const _lcm_recv_buf_t* message, const char* channel, void* bus) noexcept;
  bool Ready(std::int64_t timeout_us) const;
  void HandleOne();
  void CheckRoundTrip();

  std::string url_;
  std::unique_ptr<_lcm_t, Destroy> lcm_;
  int fd_ = -1;
  std::vector<Packet> inbox_;
  std::exception_ptr callback_error_;  ///< thrown inside LCM's C frames, rethrown outside
  LcmBusCounters counters_;
};

}  // namespace muster
