#pragma once

#include <cstdint>
#include <map>
#include <muster/header_t.hpp>
#include <muster/log_status_t.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/interval_set.h"
#include "base/units.h"
#include "lcmtypes/bus/bus.h"

namespace muster::recorder {

/// The marks are repeated after so long even without a reason, in case a packet was lost unseen.
inline constexpr TimeUs kMarksIdleUs = 200'000;
/// For a sender that shows that it has not heard them, the marks are repeated no sooner than this.
/// Senders repair the log after 20 ms; what they repeat sooner is meant for other processes.
inline constexpr TimeUs kMarksAgainUs = 10'000;

/// How much of each sender's messages a growing log holds. Senders repeat themselves and the
/// network may reorder, so the log has doubles and holes that close later.
class LogFollower {
 public:
  /// Low enough that a count of what is missing below a seq, over all senders, does not overflow.
  static constexpr std::int64_t kMostSeq = std::int64_t{1} << 40;

  /// Messages of other runs, and those numbered kMostSeq or higher, are counted and left out.
  explicit LogFollower(std::int64_t run_id) : run_id_(run_id) {}

  /// Takes the log's next event. Returns its header when it is a message of this run that the log
  /// did not hold before.
  std::optional<header_t> Add(const Packet& event);

  /// Every seq of that start of that sender below it is in the log.
  std::int64_t next_seq(const std::string& sender, std::int64_t boot_id) const;
  bool Contains(const header_t& header) const;
  /// How many seqs below `seq` are not.
  std::int64_t missing_below(const std::string& sender, std::int64_t boot_id,
                             std::int64_t seq) const;
  /// Seqs that are missing below the highest one that the log holds, over all senders.
  std::int64_t missing() const;

  std::int64_t messages() const { return messages_; }  ///< of this run, each once
  std::int64_t doubles() const { return doubles_; }
  std::int64_t message_bytes() const { return message_bytes_; }  ///< of messages()
  std::int64_t double_bytes() const { return double_bytes_; }    ///< of doubles()
  std::int64_t strangers() const {
    return strangers_;
  }  ///< of other runs, or unreadable; channels MUSTER_* only

  /// The marks, by sender and boot_id; the header is left for the sender to fill.
  log_status_t Status() const;

 private:
  using Start = std::pair<std::string, std::int64_t>;  // sender, boot_id

  std::int64_t run_id_;
  std::map<Start, IntervalSet> starts_;
  std::int64_t messages_ = 0;
  std::int64_t doubles_ = 0;
  std::int64_t message_bytes_ = 0, double_bytes_ = 0;
  std::int64_t strangers_ = 0;
};

}  // namespace muster::recorder
