// Which ticks have decisions, and which numbers these have.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <vector>

#include "base/random.h"
#include "model/scenario.h"

namespace muster {
namespace {

TEST(Rules, DecisionsAreNumberedInTheOrderOfTheirTicks) {
  Rules rules;  // ticks of 30 s, decisions every 10 min
  rules.limit_us = 35 * kMinuteUs;
  rules.DecideAt(25);  // 12.5 min
  rules.DecideAt(3);   // 1.5 min
  rules.DecideAt(20);  // 10 min: it has one
  rules.DecideAt(70);  // 35 min: the end
  rules.DecideAt(25);
  EXPECT_EQ(rules.extra_decisions, (std::vector<std::int64_t>{3, 25}));
  const std::map<std::int64_t, std::int32_t> expected = {{0, 0},  {3, 1},  {20, 2},
                                                         {25, 3}, {40, 4}, {60, 5}};
  for (std::int64_t tick = 0; tick <= rules.last_tick(); ++tick) {
    const auto found = expected.find(tick);
    EXPECT_EQ(rules.DecisionAt(tick), found == expected.end() ? -1 : found->second) << tick;
  }
  EXPECT_EQ(rules.TimeOfDecision(1), 90 * kSecondUs);
  EXPECT_EQ(rules.TimeOfDecision(3), 750 * kSecondUs);
  EXPECT_EQ(rules.TimeOfDecision(5), 30 * kMinuteUs);
  EXPECT_EQ(rules.TimeOfDecision(6), 40 * kMinuteUs) << "beyond the limit";
  EXPECT_EQ(rules.NextDecisionUs(750 * kSecondUs), 20 * kMinuteUs);
  EXPECT_EQ(rules.NextDecisionUs(20 * kMinuteUs), 30 * kMinuteUs);
}

TEST(Rules, NumbersAndTimesOfDecisionsAgree) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Random random(seed, Stream::kTest);
    Rules rules;
    rules.tick_us = (1 + random.Below(4)) * 15 * kSecondUs;
    rules.interval_us = (1 + random.Below(8)) * rules.tick_us;
    rules.limit_us = (1 + random.Below(3000)) * kSecondUs;
    const auto n_ticks = static_cast<std::uint32_t>(rules.last_tick() + 2);
    std::set<std::int64_t> asked;
    for (std::uint32_t n = random.Below(12); n > 0; --n) {
      asked.insert(random.Below(n_ticks));
      rules.DecideAt(*asked.rbegin());
      rules.DecideAt(*asked.begin());
    }
    for (const std::int64_t tick : asked) rules.DecideAt(tick);
    std::int32_t next = 0;
    for (std::int64_t tick = 0; tick <= rules.last_tick(); ++tick) {
      const TimeUs t = rules.TimeOf(tick);
      EXPECT_EQ(rules.LastDecisionBefore(t), next - 1) << "seed " << seed << ", tick " << tick;
      const bool decides =
          t < rules.limit_us && (t % rules.interval_us == 0 || asked.contains(tick));
      ASSERT_EQ(rules.DecisionAt(tick), decides ? next : -1)
          << "seed " << seed << ", tick " << tick;
      EXPECT_TRUE(rules.MayDecide(tick, rules.DecisionAt(tick)));
      if (!decides) continue;
      EXPECT_EQ(rules.TimeOfDecision(next), t) << "seed " << seed;
      ++next;
    }
    Scenario scenario;
    scenario.rules = rules;
    EXPECT_EQ(scenario.decisions(), next) << "seed " << seed;
  }
}

}  // namespace
}  // namespace muster
