// What a mission waits for before its beginning and after its end.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <optional>

#include "tools/launch/supervisor_state.h"

namespace muster::tools {
namespace {

constexpr TimeUs kStopUs = 20 * kSecondUs;       // a disk may stand still for a while
constexpr TimeUs kHeartbeatsUs = 3 * kSecondUs;  // three of a process that lives
constexpr TimeUs kLookAtHostsUs = kSecondUs;
/// Ten heartbeats of each of its processes have not come.
constexpr TimeUs kHostGoneUs = 10 * kSecondUs;

}  // namespace

std::string Supervisor::Open() const {
  std::vector<std::string> open;
  for (auto member = members_.begin() + 1; member != members_.end(); ++member) {
    if (member->gone || is_second(*member) ||
        logged_.StateOf(member->name) == ProcessState::kEnded) {
      continue;
    }
    open.push_back(fmt::format("{} to say that it has ended", member->name));
  }
  if (!logged_.end_announced() || recorder_.behind()) {
    open.push_back(fmt::format("{} to write what was said", members_.front().name));
  }
  if (!injector_.Settled(*this)) open.push_back("those hit by faults to say that these are over");
  return fmt::format("{}", fmt::join(open, ", "));
}

void Supervisor::SayWait(const Now& now) {
  const bool ended = stall_watch_.ended() || logged_.end_announced();
  // A launcher that was held up itself has heard no messages meanwhile.
  const bool was_held_up = now.monotonic_us > turned_us_ + kSecondUs;
  turned_us_ = now.monotonic_us;
  if (ended && (end_heard_us_ == kNever || was_held_up)) end_heard_us_ = now.monotonic_us;
  std::string what;
  if (stopping_) {
    what = stopping_whom_;
  } else if (ended) {
    what = "end";
  } else if (!stall_watch_.begun()) {
    what = "begin";
  }
  patience_.WaitFor(what, now.monotonic_us);
  if (!patience_.Due(now.monotonic_us)) return;
  const double waited_s = ToSeconds(patience_.waited_us(now.monotonic_us));
  if (stopping_) {
    Say(fmt::format("waiting for {} to end, for {:.0f} s now", stopping_whom_, waited_s));
  } else if (ended) {
    // Of the others, and of gaps, the end watch speaks.
    if (logged_.end_announced() && injector_.Settled(*this)) return;
    Say(fmt::format("the mission has ended, and for {:.0f} s now it waits for {}", waited_s,
                    Open()));
  } else {
    std::vector<std::string> silent;
    for (auto member = members_.begin() + 1; member != members_.end(); ++member) {
      if (!is_second(*member) && logged_.StateOf(member->name) == ProcessState::kStarting)
        silent.push_back(member->name);
    }
    Say(fmt::format("the mission has not begun after {:.0f} s: it waits for {}", waited_s,
                    !silent.empty()
                        ? fmt::format("the first word of {} in the log", fmt::join(silent, ", "))
                    : recorder_.behind() ? fmt::format("{} to write", members_.front().name)
                                         : "agents that no process reports yet"));
  }
}

void Supervisor::MoveToStandby(const std::string& name) {
  const std::vector<std::string> moved = host_->OnHostWithStandby(name);
  Say(host_->MoveToStandby(name));
  for (const std::string& process : moved) {
    Member* member = Find(process);
    if (process == name || member->down || member->gone || has_ended(*member)) continue;
    member->moved = true;
    host_->Signal(process, SIGKILL);
  }
}

void Supervisor::SeeToHosts(const Now& now) {
  if (now.monotonic_us < looked_at_hosts_us_ + kLookAtHostsUs) return;
  // A launcher that was held up, or has no network, has heard nobody meanwhile.
  const bool is_deaf =
      now.monotonic_us > looked_at_hosts_us_ + 2 * kLookAtHostsUs || !network_.reason().empty();
  looked_at_hosts_us_ = now.monotonic_us;
  if (is_deaf) awake_since_us_ = now.monotonic_us;
  for (const Member& member : members_) {
    const std::vector<std::string> on_host = host_->OnHostWithStandby(member.name);
    const auto is_silent = [&](const std::string& name) {
      return !host_->IsStopped(name) && heard_.StateOf(name) != ProcessState::kStarting &&
             heard_.StateOf(name) != ProcessState::kEnded &&
             stall_watch_.SilentUs(name, now.monotonic_us) >= kHostGoneUs;
    };
    if (on_host.empty() || now.monotonic_us < awake_since_us_ + kHostGoneUs ||
        !std::all_of(on_host.begin(), on_host.end(), is_silent)) {
      continue;
    }
    MoveToStandby(member.name);
    Member* first = Find(member.name);
    if (first->down || has_ended(*first)) continue;
    first->moved = true;
    host_->Signal(first->name, SIGKILL);
  }
}

void Supervisor::LeaveBehind(const Now& now) {
  const TimeUs silent_us = std::max(plan_.lost_after_us, kHeartbeatsUs);
  if (end_heard_us_ == kNever || now.monotonic_us < end_heard_us_ + silent_us) return;
  for (auto member = members_.begin() + 1; member != members_.end(); ++member) {
    if (member->gone || is_second(*member) || !CanDoWithout(*member) ||
        logged_.StateOf(member->name) == ProcessState::kEnded ||
        stall_watch_.SilentUs(member->name, now.monotonic_us) < silent_us) {
      continue;
    }
    // The recorder publishes in its place what it has said and the log does not hold.
    recorder_.OnEnd(member->name, member->starts - 1, now);
    if (heard_.StateOf(member->name) == ProcessState::kEnded) continue;
    member->gone = true;
    Say(fmt::format("{} has been silent for {:.0f} s and does not end: the mission ends without it",
                    member->name,
                    ToSeconds(stall_watch_.SilentUs(member->name, now.monotonic_us))));
    Announce(EventKind::kProcessLost, fmt::format("{} did not end", member->name), now);
  }
}

void Supervisor::Stop(const std::vector<Member*>& members) {
  std::vector<Member*> alive;
  stopping_whom_.clear();
  for (Member* member : members) {
    if (has_ended(*member)) continue;
    host_->AskToEnd(member->name);
    alive.push_back(member);
    stopping_whom_ += (stopping_whom_.empty() ? "" : ", ") + member->name;
  }
  TurnUntil(
      [&] {
        return std::all_of(alive.begin(), alive.end(),
                           [this](Member* member) { return has_ended(*member); });
      },
      kStopUs);
  for (Member* member : alive) {
    if (const std::optional<ChildEnd> end = host_->EndOf(member->name)) {
      if (!end->clean()) problems_.push_back(Obituary(*member, *end));
    } else if (!killed()) {
      std::string text = fmt::format("{} did not end within {} s and was killed", member->name,
                                     kStopUs / kSecondUs);
      member->gone ? Say(text) : problems_.push_back(std::move(text));
    }
  }
  stopping_whom_.clear();
  for (Member* member : members) host_->Kill(member->name);
}

}  // namespace muster::tools
