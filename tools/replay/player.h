#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/units.h"
#include "tools/log/log_source.h"

namespace muster::tools {

struct PlayerOptions {
  double rate = 1;  ///< mission seconds per second; 0: as fast as it goes
  TimeUs start_offset_us = 0;
  bool paused = false;
  bool loop = false;
  /// Whether messages of a channel are played; empty: all.
  std::function<bool(const std::string& channel)> plays = {};
};

/// Plays a log back: gives each message when its mission time has come. A message is due at its
/// header's sim_us, never before an earlier one of the log; messages without a header go with the
/// one before. No clock and no bus of its own: `now_us` is monotonic time.
class Player {
 public:
  enum class Key { kPause, kNextDecision, kFaster, kSlower };

  /// `source` must outlive the player. With a start offset, what comes before it is passed over,
  /// but for the scenario.
  Player(MessageSource* source, PlayerOptions options);

  void Press(Key key, TimeUs now_us);
  /// What is due now, at most kBatch messages.
  std::vector<Packet> Step(TimeUs now_us);
  /// When Step has something to do again; kNever while paused and after the end.
  TimeUs WakeUs(TimeUs now_us) const;

  bool ended() const { return ended_; }
  bool paused() const { return paused_; }
  double rate() const { return rate_; }  ///< 0: as fast as it goes
  TimeUs position_us(TimeUs now_us) const;
  /// Mission time until the next message.
  TimeUs ToNextUs(TimeUs now_us) const;
  std::int32_t decision() const { return decision_; }  ///< last one played, -1 before the first
  std::int64_t played() const { return played_; }

  static constexpr std::size_t kBatch = 64;
  static constexpr TimeUs kBatchPauseUs = 1000;  ///< between full batches: receivers' buffers

 private:
  struct Due {
    LoggedMessage message;
    TimeUs at_us = 0;
  };
  void Fetch();
  void Restart();
  void Anchor(TimeUs position_us, TimeUs now_us);
  bool Plays(const std::string& channel) const {
    return !options_.plays || options_.plays(channel);
  }

  MessageSource* source_;
  PlayerOptions options_;
  double rate_;
  bool paused_;
  bool to_decision_ = false;  ///< play on at once until a decision has been played
  bool ended_ = false;
  bool full_ = false;  ///< the last batch was full
  std::optional<Due> next_;
  TimeUs log_us_ = 0;  ///< latest mission time read so far
  TimeUs anchor_position_us_ = 0;
  std::optional<TimeUs> anchor_now_us_;  ///< none: not started
  std::int32_t decision_ = -1;
  std::int64_t played_ = 0;
};

}  // namespace muster::tools
