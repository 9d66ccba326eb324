#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/units.h"
#include "recorder/recorder.h"
#include "tools/launch/member.h"
#include "tools/launch/mission_host.h"
#include "tools/launch/mission_view.h"
#include "tools/launch/stall_watch.h"

namespace muster::tools {

/// Watches what a mission still waits for after its end was announced: members that have not ended,
/// and gaps in the log.
class EndWatch {
 public:
  struct Waiting {
    std::vector<std::string> for_whom;  ///< in words; empty: all is done
    std::int64_t gaps = 0;              ///< messages that exist but are not in the log
    bool may_be_filled = false;         ///< a process is stopped, or about to start again
  };

  /// Takes how things stand; a line to say now: after 3 s, 6 s, 12 s ...
  std::optional<std::string> Line(const Waiting& waiting, TimeUs now_us);
  /// Whether the gaps have not become fewer for 10 s, while all processes that could fill them ran.
  bool hopeless(TimeUs now_us) const;

 private:
  Patience patience_;
  /// The fewest so far. Each new message is a gap until it is in the log.
  std::int64_t least_gaps_ = 0;
  TimeUs gaps_since_us_ = kNever;
};

/// What a mission whose end is announced still waits for. `members`: the logger first.
EndWatch::Waiting WaitingAtEnd(const std::vector<Member>& members, const MissionView& logged,
                               const recorder::Recorder& recorder, const MissionHost& host);

/// "949 messages of world (start 0)"
std::string TextOf(const recorder::Recorder::Gap& gap);

}  // namespace muster::tools
