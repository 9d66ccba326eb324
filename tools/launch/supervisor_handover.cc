// Launchers before and after this one, and the second log that another may go on from.
#include <fmt/format.h>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "tools/launch/supervisor_state.h"

namespace muster::tools {
namespace {

/// Living processes say something each second.
constexpr TimeUs kSilentUs = 2 * kSecondUs;
constexpr TimeUs kEndEarlierUs = 10 * kSecondUs;
constexpr TimeUs kSayAgainUs = 200'000;

}  // namespace

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

void Supervisor::EndEarlier() {
  std::vector<Sender> successors;
  for (const Member& member : members_) {
    successors.emplace_back(Identity{plan_.run_id, member.name, plan_.first_boot}, 0);
  }
  const TimeUs begun_us = host_->now().monotonic_us;
  TimeUs last_heard_us = begun_us;
  for (Now now = host_->now();
       now.monotonic_us < begun_us + kEndEarlierUs &&
       now.monotonic_us < last_heard_us + kSilentUs && host_->stops_asked() == 0;
       now = host_->now()) {
    for (Sender& successor : successors) {
      process_status_t status{};
      status.name = successor.identity().name;
      status.host = host_->usage().host;
      status.pid = host_->usage().pid;
      successor.Send(channel::kProcess, std::move(status), heard_us_, now);
      successor.Flush(now, &out_);
    }
    for (const Packet& packet : out_) host_->bus().Publish(packet);
    out_.clear();
    for (const Packet& packet : host_->bus().Receive(kSayAgainUs)) {
      const std::optional<header_t> header = DecodeHeader(packet);
      const bool is_earlier =
          header && header->run_id == plan_.run_id && header->boot_id < plan_.first_boot;
      if (is_earlier) last_heard_us = host_->now().monotonic_us;
    }
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
