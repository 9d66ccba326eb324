#include "tools/launch/mission_view.h"

#include <algorithm>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::tools {

void MissionView::Add(const Packet& packet) {
  if (packet.channel == channel::kClock) {
    const auto clock = DecodeValid<clock_t>(packet.bytes);
    if (!clock) return;
    if (clock->phase == 2) end_announced_ = true;
    if (clock->phase == 0 || clock->tick < tick_) return;
    tick_ = clock->tick;
    tick_us_ = clock->tick_us;
    limit_us_ = clock->limit_us;
  } else if (packet.channel == channel::kWorld) {
    const auto world = DecodeValid<world_state_t>(packet.bytes);
    if (!world || world->tick < world_tick_) return;
    world_tick_ = world->tick;
    done_ = world->done;
    tasks_ = world->n_tasks;
  } else if (packet.channel == channel::kSchedule) {
    const auto schedule = DecodeValid<schedule_t>(packet.bytes);
    if (schedule) decisions_ = std::max(decisions_, schedule->decision + 1);
  } else if (packet.channel == channel::kProcess) {
    const auto status = DecodeValid<process_status_t>(packet.bytes);
    if (!status) return;
    ProcessState& state = states_[status->header.sender];
    state = std::max(state, static_cast<ProcessState>(status->state));
  }
}

ProcessState MissionView::StateOf(const std::string& name) const {
  const auto state = states_.find(name);
  return state == states_.end() ? ProcessState::kStarting : state->second;
}

}  // namespace muster::tools
