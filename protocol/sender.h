#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <muster/header_t.hpp>
#include <muster/log_status_t.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/units.h"
#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/codec.h"

namespace muster {

/// The two clocks of a process, always passed in. Neither reaches a decision.
struct Now {
  TimeUs monotonic_us = 0;  ///< for deadlines and back-off
  TimeUs wall_us = 0;       ///< since the Unix epoch, for headers
};

struct Identity {
  std::int64_t run_id = 1;
  std::string name;
  std::int64_t boot_id = 0;
};

/// The starts of two launchers of a mission, one after the other, are apart by so much at least: no
/// launcher starts a process so often.
inline constexpr std::int64_t kLauncherApart = 1'000'000;
/// Whether a start is an earlier launcher's than the other one.
inline bool IsOfEarlierLauncher(std::int64_t boot_id, std::int64_t than) {
  return boot_id / kLauncherApart < than / kLauncherApart;
}

/// A published message: the bytes never change again, however often it is sent.
using SentPacket = std::shared_ptr<const Packet>;

/// When to send again: after first_us, then each time after twice as long, up to longest_us. A
/// message that has waited for long is sent less often: after an eighth of the time that it has
/// waited, up to rarest_us.
class BackOff {
 public:
  BackOff(TimeUs first_us, TimeUs longest_us) : BackOff(first_us, longest_us, longest_us) {}
  BackOff(TimeUs first_us, TimeUs longest_us, TimeUs rarest_us)
      : first_us_(first_us), longest_us_(longest_us), rarest_us_(rarest_us) {}
  void Start(TimeUs now_us) {
    start_us_ = now_us;
    wait_us_ = first_us_;
    due_us_ = now_us + wait_us_;
  }
  void Stop() { due_us_ = kNever; }
  TimeUs due_us() const { return due_us_; }
  /// True when due; then the next time is set.
  bool Fire(TimeUs now_us) {
    if (now_us < due_us_) return false;
    const TimeUs waited_us = now_us - start_us_;
    wait_us_ = std::min(2 * wait_us_, std::max(longest_us_, std::min(waited_us / 8, rarest_us_)));
    due_us_ = now_us + wait_us_;
    return true;
  }

 private:
  TimeUs first_us_, longest_us_, rarest_us_;
  TimeUs start_us_ = 0;
  TimeUs wait_us_ = 0;
  TimeUs due_us_ = kNever;
};

/// How much a sender may repeat: as many bytes as it has sent for the first time, and some more in
/// a burst and over time. Beyond that it may repeat one round a second, so that nothing is ever
/// stuck. New messages fill the receivers' buffers, so nothing is repeated for the time that
/// reading them takes.
class RepeatBudget {
 public:
  void NoteFirst(std::size_t bytes, TimeUs now_us);
  /// Whether so many bytes may be repeated now; if so, counts them. `over_us`: when the caller was
  /// last allowed to although the budget was used up.
  bool Take(std::size_t bytes, TimeUs now_us, TimeUs* over_us);

 private:
  void Pass(TimeUs now_us);
  double left_bytes_ = 0;
  TimeUs passed_us_ = kNever;
  TimeUs quiet_until_us_ = 0;
};

/// How many messages of a process may be out without acknowledgement.
struct Window {
  /// Messages: stock lcm-logger queues 30 and drops the newest. 0: nothing is recorded, so no
  /// message waits and none is kept.
  int messages = 0;
  /// Or as many as are together no larger than this, if those are more. For our own recorder.
  std::size_t bytes = 0;

  Window(int most_messages, std::size_t most_bytes = 0)
      : messages(most_messages), bytes(most_bytes) {}
};

/// The windows in a mission that our own recorder writes, which says what the log holds before a
/// sender comes to the end of its window. kWorldWindow is the world's, also where lcm-logger
/// writes; kMemberWindow is that of all others.
inline constexpr int kWorldWindow = 10;
/// Events are many and small.
inline constexpr std::size_t kWorldWindowBytes = 64 * 1024;
inline constexpr int kMemberWindow = 8;

/// Numbers, keeps and sends one process's messages. With a recorder, a message is kept until the
/// recorder has it on disk and repeated with back-off until then, and no more messages than the
/// window are out without acknowledgement. A message that is still under way is not lost, so the
/// first repeat comes after some four times as long as acknowledgements have taken lately.
class Sender {
 public:
  Sender(Identity identity, Window window);

  /// Stamps the header with the next seq and queues the message. The caller may keep the packet to
  /// send it again by Resend().
  template <class T>
  SentPacket Send(std::string_view channel, T message, TimeUs sim_us, const Now& now) {
    message.header = NextHeader(sim_us, now);
    return Queue(std::make_shared<const Packet>(Packet{std::string(channel), Encode(message)}));
  }

  /// Sends a packet again, byte for byte, unless it still waits for its first sending.
  void Resend(const SentPacket& packet);

  /// Takes what the recorder says is on disk.
  void Acknowledge(const log_status_t& status);

  /// Moves everything that may go out now to `out`: new messages within the window, and, as far as
  /// the budget allows, resends and repairs of the log that are due. Resends beyond the budget are
  /// dropped; a process that misses them asks again.
  void Flush(const Now& now, std::vector<Packet>* out);

  /// When Flush has something to do without further input, kNever when not.
  TimeUs wake_us() const { return repair_.due_us(); }

  const Identity& identity() const { return identity_; }
  std::int64_t next_seq() const { return next_seq_; }
  std::int64_t resent() const { return resent_; }
  /// For how long messages have been out without any acknowledgement: the log is held up.
  TimeUs HeldUs(const Now& now) const { return out_ == 0 ? 0 : now.monotonic_us - progress_us_; }
  /// All sent and, with a recorder, on disk.
  bool drained() const { return kept_.empty() && resend_.empty(); }
  /// Whether a message waits for its first sending.
  bool holds_back() const { return out_ < kept_.size(); }

 private:
  header_t NextHeader(TimeUs sim_us, const Now& now);
  SentPacket Queue(SentPacket packet);
  /// Appends those packets again, if the budget allows.
  void Repeat(const std::vector<SentPacket>& packets, TimeUs now_us, TimeUs* over_us,
              std::vector<Packet>* out);

  /// Whether the next message may go out.
  bool HasRoom() const;

  Identity identity_;
  Window window_;
  std::int64_t next_seq_ = 0;
  std::int64_t resent_ = 0;
  std::deque<SentPacket> kept_;  ///< unacknowledged, oldest first; the first out_ have been sent
  std::size_t out_ = 0;
  std::size_t out_bytes_ = 0;
  std::deque<TimeUs> sent_us_;       ///< of those that are out; -1: something was repeated since
  std::int64_t first_kept_seq_ = 0;  ///< of kept_.front()
  std::vector<SentPacket> resend_;
  bool progressed_ = false;  ///< since the last Flush
  TimeUs progress_us_ = 0;   ///< latest time that something was acknowledged, or nothing was out
  TimeUs acknowledged_sent_us_ = -1;  ///< when the newest message acknowledged since was sent
  TimeUs answer_us_ = 0;              ///< the longest that an acknowledgement has taken lately
  BackOff repair_{0, 0};
  RepeatBudget budget_;
  TimeUs resent_over_us_ = -kNever / 2, repaired_over_us_ = -kNever / 2;
};

}  // namespace muster
