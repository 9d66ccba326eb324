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

/// The recorder that writes the log itself. It is a member of the mission and tells the others what
/// the log holds, from what it has written: the log need not be read for that, and no message has
/// to be repeated to have it written.
class RecorderProcess : public Process {
 public:
  /// `window`: own messages that may be out and not in the log. `seal`: of a sealed mission.
  RecorderProcess(const Identity& identity, int window, std::optional<Seal> seal);

  /// The log holds that message, as it came over the wire, when this process steps next.
  void OnLogged(const Packet& packet);

  /// Says that it ends.
  void End() { set_state(ProcessState::kEnded); }
  /// All that it has said is in the log.
  bool finished() const { return sender().drained(); }
  const LogFollower& log() const { return follower_; }

 private:
  void OnMessage(const Message& message, const Packet& packet, const Now& now) override;
  void OnStep(const Now& now) override;
  TimeUs OwnWakeUs() const override;
  std::int64_t tick() const override { return tick_; }
  std::int64_t lost() const override { return follower_.missing(); }

  /// When to say the marks again.
  TimeUs AgainUs() const;

  const int window_;
  std::optional<Seal> seal_;
  LogFollower follower_;
  std::int64_t tick_ = -1;
  TimeUs sim_us_ = 0;
  SentPacket marks_;         ///< the newest log_status_t
  bool news_ = true;         ///< the log has grown since
  TimeUs news_us_ = kNever;  ///< when that was seen first
  bool has_room_ = true;     ///< in its window
  bool is_urgent_ = true;    ///< and a sender may have to wait soon
  /// What the log holds of a start beyond what the marks say.
  struct Unsaid {
    int messages = 0;
    std::size_t bytes = 0;
  };
  std::map<std::pair<std::string, std::int64_t>, Unsaid> unsaid_;
  bool answer_wanted_ = false;  ///< a sender has not heard the marks
  TimeUs said_us_ = 0;          ///< the marks, at last
  BackOff idle_;
};

}  // namespace muster::recorder
