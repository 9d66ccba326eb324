#include "tools/launch/stall_watch.h"

#include <fmt/format.h>

#include <algorithm>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::tools {
namespace {

constexpr TimeUs kPatienceUs = 3 * kSecondUs;
constexpr TimeUs kLateUs = 5 * kSecondUs;

}  // namespace

void Patience::WaitFor(const std::string& what, TimeUs now_us) {
  if (what == what_) return;
  what_ = what;
  since_us_ = now_us;
  said_after_us_ = 0;
}

bool Patience::Due(TimeUs now_us) {
  const TimeUs waited = waited_us(now_us);
  if (what_.empty() || waited < std::max(kPatienceUs, 2 * said_after_us_)) return false;
  said_after_us_ = waited;
  return true;
}

TimeUs StallWatch::SilentUs(const std::string& process, TimeUs now_us) {
  Peer& peer = peers_[process];
  if (peer.heard_us < 0) peer.heard_us = now_us;
  return now_us - peer.heard_us;
}

StallWatch::StallWatch(std::vector<std::string> processes, TimeUs tick_us, double rate)
    : processes_(std::move(processes)),
      rate_(rate),
      patience_us_(kPatienceUs + (rate > 0 ? ToUs(ToSeconds(tick_us) / rate) : 0)) {}

void StallWatch::OnHeard(const Packet& packet, TimeUs now_us) {
  const std::optional<header_t> header = DecodeHeader(packet);
  if (!header) return;
  Peer& peer = peers_[header->sender];
  peer.heard_us = now_us;
  const std::string& name = packet.channel;
  if (IsReports(name)) {
    peer.role = Role::kAgents;
    peer.answered_us = std::max(peer.answered_us, header->sim_us);
  } else if (name == channel::kProcess) {
    const auto status = DecodeValid<process_status_t>(packet.bytes);
    const bool decides = status && status->state == ProcessState::kDeciding;
    if (!decides) peer.decides_us = -1;
    if (decides) peer.role = Role::kScheduler;  // at its first decision it has said nothing else
    if (decides && peer.decides_us < 0) peer.decides_us = now_us;
  } else if (process_name::IsScheduler(header->sender) &&
             (name == channel::kSchedule || name == channel::kProposal)) {
    peer.role = Role::kScheduler;
    peer.answered_us = std::max(peer.answered_us, header->sim_us);
  } else if (name == channel::kClock) {
    peer.role = Role::kOther;
    const auto clock = DecodeValid<clock_t>(packet.bytes);
    if (!clock || clock->phase == ClockPhase::kReady) return;
    ended_ |= clock->phase == ClockPhase::kEnded;
    if (clock->tick_us <= clock_us_) return;
    clock_us_ = clock->tick_us;
    decision_due_ = clock->decision >= 0;
    moved_us_ = now_us;
    if (begin_wall_us_ < 0) {
      begin_wall_us_ = now_us;
      begin_clock_us_ = clock_us_;
    }
  }
}

std::vector<std::string> StallWatch::Missing() const {
  std::vector<std::string> agents, schedulers;
  for (const std::string& name : processes_) {
    const auto peer = peers_.find(name);
    if (peer == peers_.end()) {
      agents.push_back(name);
    } else if (peer->second.answered_us < clock_us_) {
      if (peer->second.role == Role::kAgents) agents.push_back(name);
      if (peer->second.role == Role::kScheduler && decision_due_) schedulers.push_back(name);
    }
  }
  return agents.empty() ? schedulers : agents;  // a decision needs all agents
}

std::optional<std::string> StallWatch::LateLine() {
  if (rate_ <= 0) return {};
  const TimeUs late_us =
      moved_us_ - begin_wall_us_ - ToUs(ToSeconds(clock_us_ - begin_clock_us_) / rate_);
  if (late_us < std::max(kLateUs, 2 * said_late_us_)) return {};
  said_late_us_ = late_us;
  return fmt::format("the mission is {:.0f} s behind its rate at {:.1f} min: this host is too slow",
                     ToSeconds(late_us), ToMinutes(clock_us_));
}

std::optional<std::string> StallWatch::Line(TimeUs now_us) {
  if (moved_us_ < 0 || ended_) return {};
  const TimeUs stands_us = now_us - moved_us_;
  if (stands_us < patience_us_) {
    if (said_after_us_ == 0) return LateLine();
    said_after_us_ = 0;
    return fmt::format("the mission goes on at {:.1f} min", ToMinutes(clock_us_));
  }
  if (said_after_us_ > 0 && stands_us < 2 * said_after_us_) return {};
  said_after_us_ = stands_us;
  std::string whom;
  for (const std::string& name : Missing()) {
    const auto peer = peers_.find(name);
    const auto how = [&]() -> std::string {
      if (peer == peers_.end()) return "never heard";
      const Peer& known = peer->second;
      const bool decides = known.decides_us >= 0;
      return fmt::format("{} for {:.0f} s", decides ? "deciding" : "silent",
                         ToSeconds(now_us - (decides ? known.decides_us : known.heard_us)));
    };
    whom += fmt::format("{}{} ({})", whom.empty() ? "" : ", ", name, how());
  }
  return fmt::format("the mission has stood at {:.1f} min for {:.0f} s: it waits for {}",
                     ToMinutes(clock_us_), ToSeconds(stands_us),
                     whom.empty() ? "the world or the log" : whom);
}

}  // namespace muster::tools
