#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "lcmtypes/bus/seal.h"
#include "protocol/process.h"
#include "recorder/log_follower.h"

namespace muster::recorder {

/// How the recorders of a mission share their work.
enum class Part {
  kOnly,    ///< there is one
  kFirst,   ///< of two: it tells the others what both logs hold
  kSecond,  ///< of two: it tells the first one what its own log holds
};

/// The recorder that writes the log itself. It is a member of the mission and tells the others what
/// the log holds, from what it has written: the log need not be read for that, and no message has
/// to be repeated to have it written.
class RecorderProcess : public Process {
 public:
  /// `window`: own messages that may be out and not in the log. `seal`: of a sealed mission.
  /// `patience_us`: for so long the first of two waits for marks of the second, also of one that
  /// has ended while the mission goes on; without them it goes on alone, for good.
  RecorderProcess(const Identity& identity, int window, std::optional<Seal> seal,
                  Part part = Part::kOnly, TimeUs patience_us = 0);

  /// Starts below `boot` are an earlier launcher's, and those from kLauncherApart above it on a
  /// later one's.
  void SetFirstBoot(std::int64_t boot) { first_boot_ = boot; }
  /// Whether that message belongs into the log: it is of no earlier launcher's start.
  bool Wants(const Packet& packet) const;
  /// The log holds that message, as it came over the wire, when this process steps next.
  void OnLogged(const Packet& packet);

  /// Says that it ends.
  void End() { set_state(ProcessState::kEnded); }
  /// The second log counts no more: it has holes that no sender can fill.
  bool goes_on_alone() const { return part_ == Part::kFirst && second_.gone; }
  /// All that it has said is in the log.
  bool finished() const { return sender().drained(); }
  const LogFollower& log() const { return follower_; }

 private:
  void OnMessage(const Message& message, const Packet& packet, const Now& now) override;
  void OnStep(const Now& now) override;
  void SayUnlogged(const Now& now, std::vector<Packet>* out) override;
  TimeUs OwnWakeUs() const override;
  std::int64_t tick() const override { return tick_; }
  std::int64_t lost() const override { return follower_.missing(); }

  using Start = std::pair<std::string, std::int64_t>;  // sender, boot_id

  /// When to say the marks again.
  TimeUs AgainUs() const;
  /// Whether to say new marks.
  bool IsNewsDue(TimeUs now_us) const;
  void NoteSaid(TimeUs now_us);
  void HearSecond(const log_status_t& status, const Now& now);
  /// Notes what the senders have been told is in the logs: they have forgotten it.
  void NoteTold(const Packet& packet);
  /// Whether the second log lacks something of that.
  bool SecondLacksTold() const;
  /// Waits no more for a second recorder that says nothing.
  void SeeToSecond(const Now& now);
  /// The second ends when the host of the first and of the launcher is gone, so that a launcher can
  /// take over its log. Throws SystemError.
  void SeeToFirst(const Now& now);
  bool counts_second() const { return part_ == Part::kFirst && !second_.gone; }
  std::int64_t NextSeqInAll(const std::string& sender, std::int64_t boot_id) const;
  log_status_t Marks() const;
  /// The same of all but its own messages.
  std::map<Start, std::int64_t> MarksOfOthers() const;
  /// What the logs hold of its own messages.
  void AcknowledgeOwn();

  const int window_;
  const Part part_;
  const TimeUs patience_us_;
  /// The second recorder, for the first.
  struct Second {
    std::map<Start, std::int64_t> marks;  ///< next_seq
    TimeUs until_us = kNever;             ///< for so long its next marks are waited for
    bool has_ended = false;               ///< as it says: it may be started again
    bool gone = false;
  };
  Second second_;
  std::map<Start, std::int64_t> said_marks_;  ///< by the first of two: MarksOfOthers() at that time
  std::map<Start, std::int64_t> told_marks_;  ///< the same with what its earlier starts said
  bool mission_ended_ = false;                ///< the world has, or says that the mission has
  TimeUs first_heard_us_ = kNever;  ///< by the second: the first, or the launcher; kNever: not yet
  std::optional<Seal> seal_;
  LogFollower follower_;
  std::int64_t tick_ = -1;
  TimeUs sim_us_ = 0;
  SentPacket marks_;    ///< the newest log_status_t, but for the second of two
  Sender copy_sender_;  ///< of the second's marks, with numbers of their own
  std::int64_t first_boot_ = 0;
  bool has_successor_ = false;  ///< what its log holds is of no use to the mission any more
  bool news_ = true;            ///< the log has grown since
  TimeUs news_us_ = kNever;     ///< when that was seen first
  bool has_room_ = true;        ///< in its window
  bool is_urgent_ = true;       ///< and a sender may have to wait soon
  /// What the log holds of a start beyond what the marks say.
  struct Unsaid {
    int messages = 0;
    std::size_t bytes = 0;
  };
  std::map<Start, Unsaid> unsaid_;
  bool answer_wanted_ = false;  ///< a sender has not heard the marks
  TimeUs said_us_ = 0;          ///< the marks, at last
  BackOff idle_;
};

}  // namespace muster::recorder
