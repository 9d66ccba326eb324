#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <muster/header_t.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "base/units.h"
#include "lcmtypes/bus/bus.h"

namespace muster::tools {

/// Notices two senders with the same name: two living processes by the host and pid that each
/// reports about once a second, other senders by sequence numbers that cannot come from one sender.
class Namesakes {
 public:
  /// A sender goes on only when the log has all but a few of its messages; numbers that are so far
  /// ahead of the log, or apart, are not one sender's. (A window of 64 kB holds 770 events.)
  static constexpr std::int64_t kFar = 1000;
  /// What can be known of the sender otherwise.
  struct Known {
    std::int64_t logged = kNever;  ///< every number of that start below has been read in the log
    std::int64_t starts = kNever;  ///< how often it was started
  };

  /// Takes a message of the mission as it is heard. Returns a line that names the sender if two
  /// processes use its name; once for each sender.
  std::optional<std::string> OnHeard(const Packet& packet, const header_t& header,
                                     const Known& known);

 private:
  /// A few suffice: a mission has some tens of processes and starts.
  static constexpr std::size_t kMost = 1000;
  static constexpr std::size_t kRecent = 64;
  struct Self {
    std::string host;
    std::int32_t pid = 0;
    auto operator<=>(const Self&) const = default;
  };
  struct Start {
    std::optional<Self> self;
    std::map<std::int64_t, std::size_t> recent;  ///< by number: hash of the message
    std::int64_t newest_seq = -1, newest_wall_us = 0;
    std::int64_t logged = 0;  ///< as the recorder says: a reader of the log may be behind
  };
  void NoteMarks(const Packet& packet);
  /// What is wrong with the message, in words; "": nothing.
  static std::string Contradiction(const Packet& packet, const header_t& header, const Known& known,
                                   Start* start);

  std::map<std::pair<std::string, std::int64_t>, Start> starts_;  ///< by sender, boot_id
  std::set<std::string> said_, said_pids_;
};

}  // namespace muster::tools
