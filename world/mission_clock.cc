#include "world/mission_clock.h"

namespace muster::world {

void MissionClock::Start(TimeUs now_us) {
  phase_ = Phase::kRunning;
  started_us_ = now_us;
}

void MissionClock::Restore(std::int64_t tick, std::int32_t required,
                           std::optional<std::int32_t> next, TimeUs now_us) {
  tick_ = tick;
  Start(now_us - WallUs(tick));
  required_decision_ = required;
  if (next && *next < decision()) passed_over_ = decision();
}

TimeUs MissionClock::WallUs(std::int64_t tick) const {
  return rate_ > 0 ? ToUs(ToSeconds(TimeOf(tick)) / rate_) : 0;
}

TimeUs MissionClock::NextTickUs() const { return rate_ > 0 ? started_us_ + WallUs(tick_ + 1) : 0; }

clock_t MissionClock::ToWire() const {
  clock_t clock{};
  clock.tick = tick_;
  clock.tick_us = sim_us();
  clock.limit_us = rules_.limit_us;
  clock.decision = decision();
  clock.required_decision = required_decision_;
  clock.phase = NumberOf(phase_);
  return clock;
}

}  // namespace muster::world
