#pragma once

#include <muster/clock_t.hpp>
#include <optional>

#include "model/scenario.h"

namespace muster::world {

/// Where a mission stands: its phase, its tick, the decision in force.
class MissionClock {
 public:
  using Phase = ClockPhase;

  /// `rate` is mission seconds per wall second, 0: as fast as it goes. `rules` must outlive this
  /// object.
  MissionClock(const Rules& rules, double rate) : rules_(rules), rate_(rate) {}

  Phase phase() const { return phase_; }
  std::int64_t tick() const { return tick_; }
  /// Mission time of a tick.
  TimeUs TimeOf(std::int64_t tick) const { return rules_.TimeOf(tick); }
  TimeUs sim_us() const { return TimeOf(tick_); }
  bool is_last() const { return tick_ == rules_.last_tick(); }
  /// The decision due at this tick; -1: none.
  std::int32_t decision() const { return rules_.DecisionAt(tick_); }
  /// Whether the tick awaits it: an earlier start may have gone on without it.
  bool awaits_decision() const { return decision() > passed_over_; }
  /// The newest decision in force; -1: none yet.
  std::int32_t required_decision() const { return required_decision_; }

  /// `now_us` is monotonic, here and below.
  void Start(TimeUs now_us);
  void Advance() { ++tick_; }
  void End() { phase_ = Phase::kEnded; }
  void Require(std::int32_t decision) { required_decision_ = decision; }
  /// Goes on at `tick` (above 0) with `required` in force; `next` will be one tick later, if that
  /// is known.
  void Restore(std::int64_t tick, std::int32_t required, std::optional<std::int32_t> next,
               TimeUs now_us);
  /// When the next tick is due; 0: at once.
  TimeUs NextTickUs() const;

  clock_t ToWire() const;

 private:
  /// How long the mission takes to get to a tick, on the wall.
  TimeUs WallUs(std::int64_t tick) const;

  const Rules& rules_;
  const double rate_;
  Phase phase_ = Phase::kReady;
  std::int64_t tick_ = 0;
  std::int32_t required_decision_ = -1;
  std::int32_t passed_over_ = -1;  ///< a decision that an earlier start did without
  TimeUs started_us_ = 0;
};

}  // namespace muster::world
