#include "tools/faults/random_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "model/generator.h"
#include "protocol/fault_kinds.h"
#include "tests/model/block.h"

namespace muster::tools {
namespace {

const std::vector<std::string> kAllProcesses = {"recorder", "world",   "uav",
                                                "worker",   "vehicle", "scheduler"};

TEST(RandomPlan, IsAFunctionOfItsSeedAndAlwaysAGoodPlan) {
  const Scenario scenario = Generate(PresetByName("Random_1"), 1);
  std::set<std::string> texts;
  std::set<FaultKind> kinds;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    for (const bool goes_on : {false, true}) {
      RandomPlanSettings settings{
          .seed = seed, .rate_per_hour = 4, .kinds = AllSurvivableKinds(), .goes_on = goes_on};
      const FaultPlan plan = DrawPlan(scenario, settings);
      const std::string text = ToJson(plan);
      EXPECT_EQ(text, ToJson(DrawPlan(scenario, settings)));
      texts.insert(text);
      FaultPlan read = ParseFaultPlan(text, "drawn");
      ASSERT_NO_THROW(CheckFaultPlan(&read, kAllProcesses, scenario, goes_on)) << text;
      EXPECT_EQ(ToJson(read), text);
      for (const PlannedFault& fault : plan) kinds.insert(fault.kind);
    }
  }
  EXPECT_EQ(kinds.size(), AllSurvivableKinds().size());
  EXPECT_GT(texts.size(), 190u);
}

TEST(RandomPlan, HoldsNobodyWhosePacketsHaveJustBegunToSuffer) {
  const Scenario scenario = Generate(PresetByName("Random_10"), 1);
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(seed);
    const FaultPlan plan = DrawPlan(
        scenario,
        {.seed = seed, .rate_per_hour = 6, .kinds = AllSurvivableKinds(), .goes_on = true});
    for (std::size_t i = 0; i < plan.size(); ++i) {
      if (plan[i].kind != FaultKind::kProcessKilled) continue;
      for (std::size_t j = 0; j < i; ++j) {
        if (!RowOf(plan[j].kind).of_packets() || plan[j].target != plan[i].target) continue;
        EXPECT_GE(plan[i].at_us - plan[j].at_us, 3 * kMinuteUs);
      }
    }
  }
}

TEST(RandomPlan, DrawsWhatAPlanFileMayHold) {
  const Scenario scenario = Generate(PresetByName("Random_1"), 1);
  Scenario with_roads = testing::OnTheBlock();
  with_roads.rules.limit_us = scenario.rules.limit_us;
  Scenario with_air = scenario;
  UseAir({}, &with_air);
  for (std::size_t i = 0; i < kNames<FaultKind>.size(); ++i) {
    const auto kind = static_cast<FaultKind>(i);
    const Scenario& of = kind == FaultKind::kRoadClosed    ? with_roads
                         : kind == FaultKind::kZoneUnknown ? with_air
                                                           : scenario;
    FaultPlan plan =
        DrawPlan(of, {.seed = 3, .rate_per_hour = 30, .kinds = {kind}, .goes_on = true});
    EXPECT_FALSE(plan.empty()) << ToString(kind);
    EXPECT_EQ(ParseFaultPlan(ToJson(plan), "plan").size(), plan.size()) << ToString(kind);
    if (RowOf(kind).of_ways()) {
      EXPECT_NO_THROW(CheckFaultPlan(&plan, {}, of, true));
    }
  }
}

TEST(RandomPlan, HoldsNobodyWhileTheSchedulerMayStillBeHeld) {
  // Held for moments of real time, it is not missed before the next decision.
  const Scenario scenario = Generate(PresetByName("Random_10"), 1);
  int scheduler_held = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(seed);
    const FaultPlan plan =
        DrawPlan(scenario, {.seed = seed, .rate_per_hour = 12, .kinds = AllSurvivableKinds()});
    TimeUs held_until_us = 0;
    for (const PlannedFault& fault : plan) {
      const bool holds = fault.for_real_us > 0 || fault.kind == FaultKind::kProcessKilled;
      if (!holds) continue;
      EXPECT_GE(fault.at_us, held_until_us) << fault.id;
      if (!fault.target.starts_with("scheduler")) continue;
      ++scheduler_held;
      const TimeUs interval_us = scenario.rules.interval_us;
      held_until_us = (fault.at_us / interval_us + 1) * interval_us;
    }
  }
  EXPECT_GT(scheduler_held, 100);
}

TEST(RandomPlan, DrawsAboutAsManyAsAskedFor) {
  const Scenario scenario = Generate(PresetByName("Random_1"), 1);  // 3 h
  std::size_t n = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    n +=
        DrawPlan(scenario, {.seed = seed, .rate_per_hour = 10, .kinds = {FaultKind::kLoss}}).size();
  }
  EXPECT_NEAR(static_cast<double>(n) / 100, 27, 3) << "10 an hour in the first nine tenths of 3 h";
}

TEST(DropPlan, TakesTheShareOfEachClassAndLargerOnesContainSmallerOnes) {
  const Scenario scenario = Generate(PresetByName("Random_1"), 1);
  std::set<std::string> before;
  for (const double share : {0.0, 0.1, 0.3, 0.5, 1.0}) {
    std::set<std::string> now;
    for (const PlannedFault& fault : DropPlan(scenario, share, 90 * kMinuteUs, 7)) {
      EXPECT_TRUE(now.insert(fault.target).second);
      EXPECT_EQ(fault.at_us, 90 * kMinuteUs);
    }
    const auto of = [&](std::size_t n) {
      return static_cast<std::size_t>(std::lround(share * static_cast<double>(n)));
    };
    EXPECT_EQ(now.size(), of(scenario.uavs.size()) + of(scenario.workers.size()) +
                              of(scenario.vehicles.size()));
    EXPECT_TRUE(std::includes(now.begin(), now.end(), before.begin(), before.end()));
    before = now;
  }
}

}  // namespace
}  // namespace muster::tools
