#include "scheduler/policies/rollout/rollout.h"

#include <gtest/gtest.h>

#include <string>

#include "scheduler/policies/horizon/horizon.h"
#include "scheduler/policies/rollout/forward_model.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::SituationBuilder;

/// Tasks that are done when a policy decides to the end of the known agents' time.
std::size_t Done(const Situation& situation, Policy&& policy) {
  ForwardModel model(situation);
  while (!model.over()) model.Step(policy.Decide(model.situation()).actions);
  return model.done().size();
}

TEST(Rollout, AnswersDependNeitherOnThreadsNorOnEarlierCalls) {
  RolloutSettings one;
  one.threads = 1;
  RolloutPolicy single(one), two;
  for (std::uint64_t seed = 0; seed < 15; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {6, 8, 4, 15, 3, 15});
    const Decision decision = two.Decide(situation);
    EXPECT_EQ(single.Decide(situation).actions, decision.actions);
    EXPECT_EQ(RolloutPolicy().Decide(situation).actions, decision.actions);
  }
}

TEST(Rollout, TakesTheVariantThatGetsMoreDone) {
  HorizonSettings never;
  never.uav_way = 100;  // no way is worth a task
  never.send_ahead = false;
  const Situation situation = SituationBuilder()
                                  .Uav({1000, 1000})
                                  .Worker({4000, 1000})
                                  .Task({4000, 1000}, 500)
                                  .Charge({1000, 1000})
                                  .Build();
  RolloutSettings settings;
  settings.variants = {never, HorizonSettings()};
  EXPECT_TRUE(HorizonPolicy(never).Decide(situation).actions.empty());
  EXPECT_EQ(RolloutPolicy(settings).Decide(situation).actions.size(), 1u);
  settings.variants = {HorizonSettings(), never};
  EXPECT_EQ(RolloutPolicy(settings).Decide(situation).actions.size(), 1u);
}

TEST(Rollout, GetsMoreDoneThanHorizonOnKnownAgents) {
  RolloutSettings without_draws;
  without_draws.draws = 0;
  std::size_t horizon = 0, variants = 0, rollout = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Situation situation = RandomSituation(seed, {6, 8, 4, 30, 3, 15});
    horizon += Done(situation, HorizonPolicy());
    variants += Done(situation, RolloutPolicy(without_draws));
    rollout += Done(situation, RolloutPolicy());
  }
  EXPECT_GT(variants, horizon);
  EXPECT_GT(rollout, variants);
  EXPECT_GT(horizon, 20u);
}

TEST(Rollout, APassedDeadlineStillGivesTheFirstVariantsDecision) {
  RolloutSettings settings;
  settings.deadline = std::chrono::steady_clock::duration::zero();
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {6, 8, 4, 15, 3, 15});
    EXPECT_EQ(RolloutPolicy(settings).Decide(situation).actions,
              HorizonPolicy(settings.variants[0]).Decide(situation).actions);
  }
}

TEST(Rollout, FollowsAVariantNoFartherThanTheWorkAllows) {
  // With one simulated decision for each variant only what is done within an interval counts.
  RolloutSettings settings;
  settings.draws = 0;
  settings.work = 1;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Situation situation = RandomSituation(seed, {6, 8, 4, 15, 3, 15});
    const Decision decision = RolloutPolicy(settings).Decide(situation);
    const auto done = [&](const Decision& d) {
      ForwardModel model(situation);
      model.Step(d.actions);
      return model.done().size();
    };
    for (const HorizonSettings& variant : settings.variants) {
      EXPECT_GE(done(decision), done(HorizonPolicy(variant).Decide(situation)));
    }
  }
}

TEST(Rollout, WhereALotCanBePairedFewerAreFollowedAndAtLastNobody) {
  RolloutSettings none, few, plenty;
  none.pairs = 1;  // not even one simulated decision
  plenty.pairs = 1'000'000'000;
  std::size_t followed_changes = 0;
  for (std::uint64_t seed = 0; seed < 15; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {6, 8, 4, 15, 3, 15});
    const Decision first = HorizonPolicy(none.variants[0]).Decide(situation);
    EXPECT_EQ(RolloutPolicy(plenty).Decide(situation).actions,
              RolloutPolicy().Decide(situation).actions);
    if (first.candidates < 2) continue;
    EXPECT_EQ(RolloutPolicy(none).Decide(situation).actions, first.actions);
    // Two variants to the end, in 18 decisions at most: no worse than the first in the forecast.
    few.pairs =
        first.candidates * 2 * situation.site->rules.limit_us / situation.site->rules.interval_us;
    few.threads = 1;
    const Decision one = RolloutPolicy(few).Decide(situation);
    few.threads = 2;
    EXPECT_EQ(RolloutPolicy(few).Decide(situation).actions, one.actions);
    if (one.actions != first.actions) ++followed_changes;
  }
  EXPECT_GT(followed_changes, 0u);
}

}  // namespace
}  // namespace muster::scheduler
