#include "protocol/drive.h"

#include <algorithm>

namespace muster {
namespace {

constexpr TimeUs kHeartbeatUs = 1'000'000;
constexpr TimeUs kLongestWaitUs = 200'000;

}  // namespace

Drive::Drive(Process* process, LossyBus* bus)
    : process_(process),
      bus_(bus),
      faults_(process->identity().run_id, process->identity().name, bus,
              [process] { return process->rejected(); }) {}

bool Drive::Turn(const std::vector<Packet>& arrived, const Now& now,
                 const std::function<Usage()>& usage) {
  if (heartbeat_us_ == kNever) heartbeat_us_ = now.monotonic_us + kHeartbeatUs;
  for (const Packet& packet : arrived) {
    if (std::optional<event_t> event = faults_.Take(packet)) process_->Announce(*event, now);
  }
  process_->NoteRefused(bus_->refused());
  process_->Step(arrived, now, &out_);
  const bool changed = process_->state() != reported_;
  const bool beats = now.monotonic_us >= heartbeat_us_ && process_->state() != ProcessState::kEnded;
  if (changed || beats) {
    reported_ = process_->state();
    heartbeat_us_ = now.monotonic_us + kHeartbeatUs;
    process_->ReportStatus(usage(), now);
    process_->Step({}, now, &out_);
  }
  for (const Packet& packet : out_) bus_->Publish(packet);
  out_.clear();
  return changed;
}

TimeUs Drive::wake_us(TimeUs now_us) const {
  const bool beats = process_->state() != ProcessState::kEnded;
  return std::min({process_->wake_us(), beats ? heartbeat_us_ : kNever, now_us + kLongestWaitUs});
}

}  // namespace muster
