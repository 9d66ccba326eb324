#include "tools/launch/end_watch.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace muster::tools {
namespace {

/// Twenty times the longest pause between two repairs of a sender.
constexpr TimeUs kGapUs = 10 * kSecondUs;

}  // namespace

std::optional<std::string> EndWatch::Line(const Waiting& waiting, TimeUs now_us) {
  if (waiting.gaps == 0) {
    gaps_since_us_ = kNever;
  } else if (gaps_since_us_ == kNever || waiting.gaps < least_gaps_ || waiting.may_be_filled) {
    gaps_since_us_ = now_us;
    least_gaps_ = waiting.gaps;
  }

  patience_.WaitFor(waiting.for_whom.empty() ? "" : "end", now_us);
  if (!patience_.Due(now_us)) return {};
  return fmt::format("the mission has been over for {:.0f} s: it waits for {}",
                     ToSeconds(patience_.waited_us(now_us)), fmt::join(waiting.for_whom, ", "));
}

EndWatch::Waiting WaitingAtEnd(const std::vector<Member>& members, const MissionView& logged,
                               const recorder::Recorder& recorder, const MissionHost& host) {
  EndWatch::Waiting waiting;
  for (const Member& member : members) {
    const bool stopped = !member.gone && !member.down && host.IsStopped(member.name);
    waiting.may_be_filled |= stopped || member.down;
    const bool ended = &member == &members.front() || member.gone ||
                       logged.StateOf(member.name) == ProcessState::kEnded;
    if (stopped) {
      waiting.for_whom.push_back(member.name + " (stopped by a signal)");
    } else if (!ended) {
      waiting.for_whom.push_back(member.name);
    }
  }
  for (const recorder::Recorder::Gap& gap : recorder.gaps()) {
    waiting.gaps += gap.messages;
    waiting.for_whom.push_back(TextOf(gap) + " in the log");
  }
  if (waiting.for_whom.empty() && recorder.behind()) waiting.for_whom.emplace_back("the log");
  return waiting;
}

std::string TextOf(const recorder::Recorder::Gap& gap) {
  return fmt::format("{} messages of {} (start {})", gap.messages, gap.sender, gap.boot_id);
}

bool EndWatch::hopeless(TimeUs now_us) const {
  return gaps_since_us_ != kNever && now_us - gaps_since_us_ >= kGapUs;
}

}  // namespace muster::tools
