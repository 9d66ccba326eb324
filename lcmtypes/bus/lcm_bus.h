#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/datagram_guard.h"
#include "lcmtypes/bus/multicast.h"
#include "lcmtypes/bus/udpm_receiver.h"

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
  std::int64_t not_sent = 0;  ///< the kernel's buffers were full, or the network was gone: lost
};

/// For a recorder: every message of every channel, ours or not, in order of arrival. What the bus
/// hands out besides are the channels in `heard`; Receive returns after each burst.
struct LcmTap {
  std::vector<std::string> heard;
  std::function<void(const Packet&)> on_message;
  /// After all that came in at once.
  std::function<void()> on_burst;
};

/// The bus over LCM's UDP multicast. A process hears its own packets, too. One thread uses it. It
/// reads the socket itself (UdpmReceiver) where the kernel gives a large buffer; else LCM does so
/// in a thread of its own, which takes no signals, into an unlimited queue.
///
/// An outage begins when the kernel finds no way for a packet (no route, no link; full buffers for
/// a second), or when none has come in for a second of waiting though some were sent: the socket is
/// a member of the group on an interface that is no more. It ends when a packet of ours comes back;
/// until then one is sent every 20 ms, and the group is joined anew while none comes.
class LcmBus : public Bus {
 public:
  /// The code that reads the socket.
  enum class Reader { kOwnIfItCan, kLcm };

  /// Joins the multicast group of `url` and sees that a packet comes back. Throws InputError for a
  /// bad URL, SystemError, saying what to do, when the host does not carry multicast.
  /// `tag_bytes`: how much longer than the channel table says a packet may be, both ways. What
  /// `tap` throws ends Receive. `channels`: what is handed out; with a tap every channel comes in.
  explicit LcmBus(const std::string& url, std::size_t tag_bytes = 0, std::optional<LcmTap> tap = {},
                  Reader reader = Reader::kOwnIfItCan,
                  GuardedChannels channels = GuardedChannels::kOurs);
  ~LcmBus() override;

  void Publish(const Packet& packet) override;
  std::vector<Packet> Receive(std::int64_t timeout_us) override;
  std::string Outage() const override { return outage_; }
  std::int64_t outage_us() const override;

  const LcmBusCounters& counters() const { return counters_; }

 private:
  struct Destroy {
    void operator()(_lcm_t* lcm) const;
  };

  static void OnLcmMessage(const _lcm_recv_buf_t* message, const char* channel, void* bus) noexcept;
  /// Lets LCM receive.
  void Subscribe();
  void Take(std::string_view channel, const std::uint8_t* data, std::size_t size);
  /// 0, or the errno of a send that failed.
  int Send(const std::string& channel, const void* data, std::size_t size);
  bool Ready(std::int64_t timeout_us) const;
  /// Takes what is there, after Ready; LCM's one message, or all that the socket holds.
  void Handle();
  void CheckRoundTrip();
  void NoteFailure(int error);
  void NoteWaited(std::int64_t waited_us);
  void BeginOutage(std::string reason);
  /// Sends a packet to see whether it comes back.
  void Probe();

  std::string url_;
  std::size_t tag_bytes_;
  MulticastUrl parts_;
  std::optional<LcmTap> tap_;
  GuardedChannels channels_;
  std::unique_ptr<_lcm_t, Destroy> lcm_;
  std::unique_ptr<UdpmReceiver> receiver_;  ///< none: LCM's thread receives
  int fd_ = -1;
  std::string round_trip_;              ///< what to send to oneself
  bool came_back_ = false;              ///< since it was last sent
  bool unanswered_ = false;             ///< something was sent since anything was heard
  std::int64_t waited_us_ = 0;          ///< for that
  std::int64_t failing_since_us_ = -1;  ///< full buffers
  std::string outage_;                  ///< why; "": none
  std::int64_t outage_since_us_ = 0, past_outages_us_ = 0, probed_us_ = 0;
  int probes_sent_ = 0;  ///< since anything came back
  std::vector<Packet> inbox_;
  std::exception_ptr callback_error_;  ///< thrown inside LCM's C frames, rethrown outside
  LcmBusCounters counters_;
};

}  // namespace muster
