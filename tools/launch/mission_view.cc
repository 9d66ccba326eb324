#include "tools/launch/mission_view.h"

#include <fmt/format.h>

#include <algorithm>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "tools/host/progress.h"

namespace muster::tools {

void MissionView::Add(const Packet& packet) {
  if (packet.channel == channel::kClock) {
    const auto clock = DecodeValid<clock_t>(packet.bytes);
    if (!clock) return;
    if (clock->phase == ClockPhase::kEnded) end_announced_ = true;
    if (clock->phase == ClockPhase::kReady || clock->tick < tick_) return;
    tick_ = clock->tick;
    tick_us_ = clock->tick_us;
    limit_us_ = clock->limit_us;
  } else if (packet.channel == channel::kWorld) {
    const auto world = DecodeValid<world_state_t>(packet.bytes);
    if (!world || world->tick < world_tick_) return;
    world_tick_ = world->tick;
    done_ = world->done;
    tasks_ =
        static_cast<int>(std::count_if(world->task_status.begin(), world->task_status.end(),
                                       [](std::int8_t s) { return s != TaskStatus::kUnreported; }));
  } else if (packet.channel == channel::kSchedule) {
    const auto schedule = DecodeValid<schedule_t>(packet.bytes);
    if (schedule) decisions_ = std::max(decisions_, schedule->decision + 1);
  } else if (packet.channel == channel::kProcess) {
    const auto status = DecodeValid<process_status_t>(packet.bytes);
    if (!status) return;
    ProcessState& state = states_[status->header.sender];
    const auto said = static_cast<ProcessState>(status->state);
    state = std::max(state, said == ProcessState::kDeciding ? ProcessState::kRunning : said);
  }
}

ProcessState MissionView::StateOf(const std::string& name) const {
  const auto state = states_.find(name);
  return state == states_.end() ? ProcessState::kStarting : state->second;
}

std::string ProgressLine(const MissionView& mission, std::int64_t log_lag_ticks, TimeUs wall_us) {
  if (!mission.started()) return "waiting for all processes";
  return fmt::format(
      "{} of {}  tick {}  tasks {}/{}  decisions {}  log lag {}  speed {:.0f}x",
      ClockText(mission.tick_us()), ClockText(mission.limit_us()), mission.tick(), mission.done(),
      mission.tasks(), mission.decisions(), log_lag_ticks,
      static_cast<double>(mission.tick_us()) / static_cast<double>(std::max<TimeUs>(wall_us, 1)));
}

}  // namespace muster::tools
