#include "world/mission_clock.h"

#include <gtest/gtest.h>

namespace muster::world {
namespace {

using Phase = MissionClock::Phase;

/// Decisions every second tick; the last tick is a short one.
const Rules kRules = [] {
  Rules rules;
  rules.tick_us = 30 * kSecondUs;
  rules.interval_us = 60 * kSecondUs;
  rules.limit_us = 100 * kSecondUs;
  return rules;
}();

TEST(MissionClock, CountsTicksAndDecisionsToTheLimit) {
  MissionClock clock(kRules, 0);
  EXPECT_EQ(clock.phase(), Phase::kReady);
  clock.Start(5);
  std::vector<std::int32_t> decisions;
  for (; !clock.is_last(); clock.Advance()) {
    EXPECT_EQ(clock.NextTickUs(), 0);  // at once
    EXPECT_EQ(clock.awaits_decision(), clock.decision() >= 0);
    decisions.push_back(clock.decision());
  }
  EXPECT_EQ(decisions, (std::vector<std::int32_t>{0, -1, 1, -1}));
  EXPECT_EQ(clock.sim_us(), 100 * kSecondUs);
  EXPECT_FALSE(clock.awaits_decision());
  clock.Require(1);
  clock.End();
  const clock_t wire = clock.ToWire();
  EXPECT_EQ(wire.tick, 4);
  EXPECT_EQ(wire.tick_us, 100 * kSecondUs);
  EXPECT_EQ(wire.limit_us, 100 * kSecondUs);
  EXPECT_EQ(wire.decision, -1);
  EXPECT_EQ(wire.required_decision, 1);
  EXPECT_EQ(wire.phase, 2);
}

TEST(MissionClock, KeepsItsRate) {
  MissionClock clock(kRules, 10);
  clock.Start(7);
  EXPECT_EQ(clock.NextTickUs(), 7 + 3 * kSecondUs);
  clock.Advance();
  EXPECT_EQ(clock.NextTickUs(), 7 + 6 * kSecondUs);
}

TEST(MissionClock, GoesOnAtItsRateWhenItStartsAgain) {
  MissionClock clock(kRules, 10);
  clock.Restore(2, 0, std::nullopt, 100 * kSecondUs);
  EXPECT_EQ(clock.phase(), Phase::kRunning);
  EXPECT_EQ(clock.tick(), 2);
  EXPECT_EQ(clock.required_decision(), 0);
  EXPECT_TRUE(clock.awaits_decision());
  EXPECT_EQ(clock.NextTickUs(), 103 * kSecondUs);
}

TEST(MissionClock, DoesNotAwaitADecisionThatAnEarlierStartDidWithout) {
  MissionClock clock(kRules, 0);
  clock.Restore(2, 0, 1, 0);  // decision 1 is in force one tick later
  EXPECT_TRUE(clock.awaits_decision());
  clock.Restore(2, 0, 0, 0);
  EXPECT_EQ(clock.decision(), 1);
  EXPECT_FALSE(clock.awaits_decision());
}

}  // namespace
}  // namespace muster::world
