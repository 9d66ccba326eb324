#include "scheduler/policies/rollout/plan_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "scheduler/checker.h"
#include "scheduler/policies/horizon/pairs.h"
#include "scheduler/policies/registry.h"
#include "scheduler/policies/rollout/rollout.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::SituationBuilder;

/// A UAV stands at the task, and the only worker comes online there half an hour later.
Situation WorkerComes() {
  SituationBuilder builder;
  builder.Uav({3000, 1000}).Worker({3000, 1000}).Task({3000, 1000}, 3000).Charge({1000, 1000});
  builder.scenario().workers[0].online_from_us = 30 * kMinuteUs;
  return builder.Build();
}

Future WithShifts(const Situation& situation) {
  Future future{situation};
  future.coming = ComingAgents(situation);
  return future;
}

// UAVs go 10 m/s; sensing for 3 km takes 300 s. The limit is 180 min.
TEST(PlanSearch, AForecastCountsWhatAComingAgentGetsDone) {
  const Situation situation = WorkerComes();
  ASSERT_TRUE(situation.workers.empty());
  const auto of = [](const Future& future) {
    return ForecastOf({future}, {}, HorizonSettings(), 18, 0.5);
  };
  EXPECT_EQ(of(Future{situation}).done, 0u);
  EXPECT_EQ(of(Future{situation}).worth, 0);
  const Forecast forecast = of(WithShifts(situation));
  EXPECT_EQ(forecast.done, 1u);
  // The pair is commanded at 30 min and done at 35 min.
  EXPECT_NEAR(forecast.worth, 1 + 0.5 * (1 - 35.0 / 180), 1e-12);
  const Forecast twice =
      ForecastOf({WithShifts(situation), WithShifts(situation)}, {}, HorizonSettings(), 18, 0.5);
  EXPECT_EQ(twice.done, 2u) << "the sum over the futures";
  EXPECT_EQ(ForecastOf({WithShifts(situation)}, {}, HorizonSettings(), 3, 0.5).done, 0u)
      << "three decisions are not enough";
}

TEST(PlanSearch, ShiftsThatAreOverOrHaveBegunDoNotCome) {
  SituationBuilder builder;
  builder.Uav({1000, 1000}).Uav({2000, 1000}).Uav({3000, 1000}).Worker({1, 1}).Task({500, 500});
  builder.Charge({1000, 1000}).Decision(3);
  std::vector<AgentSpec>& uavs = builder.scenario().uavs;
  uavs[0].online_from_us = 60 * kMinuteUs;
  uavs[1].online_from_us = 30 * kMinuteUs;  // the time of the decision
  uavs[2].online_from_us = 45 * kMinuteUs;
  uavs[2].online_until_us = 50 * kMinuteUs;  // between two decisions
  const Situation situation = builder.Build();
  ASSERT_EQ(situation.uavs.size(), 1u);
  ASSERT_EQ(situation.site->shifts.size(), 3u);
  EXPECT_EQ(situation.site->shifts.front().id, 1) << "in the order in which they begin";
  const auto coming = ComingAgents(situation);
  ASSERT_EQ(coming->size(), 2u);
  EXPECT_EQ(coming->front().id, 2);
  ForwardModel model(WithShifts(situation));
  std::vector<std::size_t> online;
  for (int i = 0; i < 4; ++i) {
    online.push_back(model.situation().uavs.size());
    model.Step({});
  }
  EXPECT_EQ(online, (std::vector<std::size_t>{1, 1, 1, 2})) << "at 30, 40, 50, 60 min";
  EXPECT_EQ(model.situation().uavs.front().id, 0) << "by id";
}

TEST(PlanSearch, ADrawOfATaskHoldsAtEveryDecision) {
  Situation situation = RandomSituation(1);
  HorizonSettings settings;
  auto draws = std::make_shared<TaskDraws>();
  draws->most = 0.3;
  draws->of = {0, 7, 8, 0, 0};
  settings.task_draws = draws;
  const double drawn = JitterOf(situation, settings, AgentKind::kUav, 2, 1);
  EXPECT_NE(drawn, 0);
  EXPECT_LE(std::abs(drawn), 0.3);
  EXPECT_NE(JitterOf(situation, settings, AgentKind::kUav, 2, 2), drawn);
  EXPECT_NE(JitterOf(situation, settings, AgentKind::kWorker, 2, 1), drawn);
  EXPECT_EQ(JitterOf(situation, settings, AgentKind::kUav, 2, 0), 0);
  EXPECT_EQ(JitterOf(situation, settings, AgentKind::kUav, 2, 100), 0) << "an imagined task";
  ++situation.decision;
  EXPECT_EQ(JitterOf(situation, settings, AgentKind::kUav, 2, 1), drawn);
}

TEST(PlanSearch, FindsNoWorseAndInAllMuchBetterPlansTheSameWithOneThread) {
  double begun = 0, found = 0, longer = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {6, 8, 4, 30, 3, 15});
    const std::vector<Future> futures = {WithShifts(situation)};
    SearchLimits limits;
    const SearchedPlan start = [&] {
      SearchedPlan plan{HorizonSettings(), {}};
      const auto first = HorizonPolicy(plan.settings).ActionsOf(situation);
      plan.forecast = ForecastOf(futures, first, plan.settings, 1000, limits.early);
      return plan;
    }();
    limits.forecasts = 30;
    const SearchedPlan two = SearchPlans(situation, futures, start.settings, limits);
    limits.threads = 1;
    const SearchedPlan one = SearchPlans(situation, futures, start.settings, limits);
    EXPECT_EQ(two.forecast.worth, one.forecast.worth);
    const auto actions = [&](const SearchedPlan& plan) {
      return HorizonPolicy(plan.settings).Decide(situation).actions;
    };
    EXPECT_EQ(actions(two), actions(one));
    EXPECT_GE(two.forecast.worth, start.forecast.worth - 1e-9);
    limits.forecasts = 120;
    const SearchedPlan more = SearchPlans(situation, futures, start.settings, limits);
    EXPECT_GE(more.forecast.worth, two.forecast.worth - 1e-6) << "it goes on from there";
    begun += start.forecast.worth;
    found += two.forecast.worth;
    longer += more.forecast.worth;
  }
  EXPECT_GT(found, begun + 1);
  EXPECT_GT(longer, found);
}

TEST(PlanSearch, NothingToDoAndNoTimeLeaveTheStart) {
  SituationBuilder builder;
  builder.Uav({1000, 1000}).Worker({1000, 1000}).Task({1000, 1000}).Charge({1000, 1000});
  Situation situation = builder.Build();
  SearchLimits limits;
  limits.forecasts = 10;
  limits.until = std::chrono::steady_clock::now();
  const auto found = [&] {
    return SearchPlans(situation, {Future{situation}}, HorizonSettings(), limits).settings;
  };
  EXPECT_EQ(found().task_draws, nullptr);
  limits.until.reset();
  situation.task_status[0] = TaskStatus::kDone;
  EXPECT_EQ(found().task_draws, nullptr);
}

TEST(PlanSearch, RolloutWithEffortGetsMoreDoneAndKeepsTheRules) {
  const auto done = [](const Situation& situation, const char* name) {
    const auto policy = MakePolicy(name);
    ForwardModel model(WithShifts(situation));
    while (!model.over()) {
      const Decision decision = policy->Decide(model.situation());
      EXPECT_TRUE(CheckActions(model.situation(), decision.actions).empty()) << name;
      model.Step(decision.actions);
    }
    return model.done().size();
  };
  std::size_t plain = 0, effort = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {6, 8, 4, 30, 3, 15});
    plain += done(situation, "rollout-steps");
    effort += done(situation, "rollout-steps:shifts=1:effort=4");
    const auto once = MakePolicy("rollout:effort=1:shifts=0")->Decide(situation);
    EXPECT_EQ(once.actions, MakePolicy("rollout")->Decide(situation).actions);
  }
  EXPECT_GT(effort, plain);
}

TEST(PlanSearch, SaysHowASearchedDecisionCameAbout) {
  std::size_t searched = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {6, 8, 4, 30, 3, 15});
    RolloutPolicy policy;
    ASSERT_TRUE(policy.Set("effort", 4));
    const Decision decision = policy.Decide(situation);
    const Deciding deciding = policy.Explain(situation, decision.actions);
    EXPECT_TRUE(deciding.how.again);
    EXPECT_EQ(deciding.how.tasks_drawn > 0, deciding.how.settings.task_draws != nullptr);
    if (deciding.how.tasks_drawn > 0) ++searched;
    ASSERT_TRUE(policy.Set("effort", 1e6));
    EXPECT_EQ(policy.Explain(situation, decision.actions).how.tasks_drawn, 0u)
        << "a search that long is not made again";
  }
  EXPECT_GT(searched, 0u);
}

}  // namespace
}  // namespace muster::scheduler
