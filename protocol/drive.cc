#include "protocol/drive.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

constexpr TimeUs kHeartbeatUs = 1'000'000;
constexpr TimeUs kLongestWaitUs = 200'000;
/// A process gives way to an older one of its name only for so long after its start. Later it
/// stays, so that no forged message can end it.
constexpr TimeUs kNewUs = 5'000'000;
constexpr TimeUs kMeetAgainUs = 100'000;
/// Time for a process that has the name already to answer.
constexpr TimeUs kListenUs = 300'000;

}  // namespace

Drive::Drive(Process* process, LossyBus* bus)
    : process_(process),
      bus_(bus),
      faults_(process->identity().run_id, process->identity().name, bus,
              [process] { return process->rejected(); }) {}

bool Drive::Turn(const std::vector<Packet>& arrived, const Now& now,
                 const std::function<Usage()>& usage) {
  if (heartbeat_us_ == kNever) {
    heartbeat_us_ = now.monotonic_us + kHeartbeatUs;
    begun_us_ = now.monotonic_us;
  }
  for (const Packet& packet : arrived) {
    if (packet.channel == channel::kProcess) {
      const auto status = DecodeValid<process_status_t>(packet.bytes);
      if (status && status->header.sender == process_->identity().name) {
        MeetNamesake(*status, usage(), now);
      }
    }
    if (!has_joined_ && packet.channel == channel::kClock) LookForMission(packet, now);
    if (std::optional<event_t> event = faults_.Take(packet)) process_->Announce(*event, now);
  }
  process_->NoteRefused(bus_->refused());
  process_->NoteDropped(bus_->counters().lost);
  process_->Step(arrived, now, &out_);
  const bool changed = process_->state() != reported_;
  const bool beats =
      (now.monotonic_us >= heartbeat_us_ || beaten_) && process_->state() != ProcessState::kEnded;
  beaten_ = false;
  if (changed || beats) {
    reported_ = process_->state();
    heartbeat_us_ = now.monotonic_us + kHeartbeatUs;
    process_->ReportStatus(usage(), now);
    process_->Step({}, now, &out_);
  }
  Publish(now);
  if (!refused_.empty()) throw SystemError(refused_);  // and everybody has heard who it was
  return changed;
}

void Drive::Beat(std::vector<Packet>* arrived, const Now& now,
                 const std::function<Usage()>& usage) {
  process_->Beat(arrived, usage(), now, &out_);
  beaten_ = true;  // the turn's end says how it is then
  Publish(now);
}

void Drive::LookForMission(const Packet& packet, const Now& now) {
  const auto clock = DecodeValid<clock_t>(packet.bytes);
  const Identity& identity = process_->identity();
  // A world hears its own clocks, too.
  if (!clock || clock->header.run_id != identity.run_id || clock->header.sender == identity.name) {
    return;
  }
  has_joined_ = true;
  if (clock->tick > 0 && identity.boot_id == 0) listens_until_us_ = now.monotonic_us + kListenUs;
}

void Drive::Publish(const Now& now) {
  if (now.monotonic_us >= listens_until_us_ && refused_.empty()) {
    for (const Packet& packet : held_) bus_->Publish(packet);
    held_.clear();
  }
  const bool listens = now.monotonic_us < listens_until_us_ || !refused_.empty();
  for (Packet& packet : out_) {
    const bool asks = packet.channel == channel::kProcess || packet.channel == channel::kRequest;
    if (listens && !asks) {
      held_.push_back(std::move(packet));
    } else {
      bus_->Publish(packet);
    }
  }
  out_.clear();
}

void Drive::MeetNamesake(const process_status_t& status, const Usage& own, const Now& now) {
  const header_t& header = status.header;
  const Identity& identity = process_->identity();
  // Its host was cut off and taken for gone: another start has its place. Only the mission's key
  // can say so, and two messages.
  if (bus_->sealed() && header.run_id == identity.run_id && header.boot_id > identity.boot_id) {
    if (later_seq_ >= 0 && later_seq_ != header.seq) {
      refused_ = fmt::format("{} has been started again, pid {} on {}: this one, pid {}, ends",
                             identity.name, status.pid, status.host, own.pid);
    }
    later_seq_ = header.seq;
    return;
  }
  if (header.run_id != identity.run_id || header.boot_id != identity.boot_id ||
      (status.pid == own.pid && status.host == own.host)) {
    return;
  }
  // The process that has heard more is the older one. Two messages must say so: one may be damaged.
  if (now.monotonic_us < begun_us_ + kNewUs && status.received > process_->counters().received) {
    if (older_ && older_->pid == status.pid && older_->host == status.host &&
        older_->header.seq != header.seq) {
      refused_ = fmt::format("{} speaks already, pid {} on {}: this one, pid {}, ends",
                             identity.name, status.pid, status.host, own.pid);
    }
    older_ = status;
    listens_until_us_ = now.monotonic_us + 2 * kHeartbeatUs;
  }
  if (met_us_ != kNever && now.monotonic_us < met_us_ + kMeetAgainUs) {
    heartbeat_us_ = std::min(heartbeat_us_, met_us_ + kMeetAgainUs);
    return;
  }
  met_us_ = now.monotonic_us;
  heartbeat_us_ = now.monotonic_us;
}

TimeUs Drive::wake_us(TimeUs now_us) const {
  const bool beats = process_->state() != ProcessState::kEnded;
  const TimeUs listens_us = held_.empty() ? kNever : listens_until_us_;
  return std::min(
      {process_->wake_us(), beats ? heartbeat_us_ : kNever, listens_us, now_us + kLongestWaitUs});
}

}  // namespace muster
