// Launchers before and after this one, and the second log that another may go on from.
#include <fmt/format.h>

#include "tools/launch/supervisor_state.h"

namespace muster::tools {

void Supervisor::ReadEarlierLog() {
  const Now now = host_->now();
  reads_earlier_ = true;
  ReadLog(now);
  reads_earlier_ = false;
  logged_.ForgetProcesses();
  heard_tick_ = logged_.tick();
  heard_us_ = logged_.tick_us();
  for (const Member& member : members_) {
    if (member.starts == 0) continue;
    Announce(EventKind::kProcessLost, fmt::format("{} ended with the launcher", member.name), now);
    if (member.name != process_name::kLogger) TellRecorder(member, now);
  }
}

void Supervisor::LookForSuccessor(const header_t& header) {
  // Only the mission's key can say so, and two messages.
  const Identity own = LauncherOf(plan_);
  if (!host_->bus().sealed() || header.sender != own.name || header.boot_id <= own.boot_id) return;
  if (later_seq_ >= 0 && later_seq_ != header.seq && !is_succeeded_) {
    is_succeeded_ = true;
    problems_.emplace_back("the mission has gone on with another launcher: this one ends");
  }
  later_seq_ = header.seq;
}

void Supervisor::SeeToSecond(const Now& now) {
  if (!plan_.has_second_log || is_second_lost_ || !stall_watch_.begun() || stall_watch_.ended() ||
      stall_watch_.SilentUs(process_name::kSecondMarks, now.monotonic_us) < plan_.lost_after_us) {
    return;
  }
  is_second_lost_ = true;
  Say(fmt::format(
      "{} has been silent for {:.0f} s: the mission does not wait for the second log any "
      "more, which may have holes from here on",
      process_name::kSecondRecorder, ToSeconds(plan_.lost_after_us)));
}

}  // namespace muster::tools
