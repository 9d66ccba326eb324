#include "scheduler/policies/baselines/kwta.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::SituationBuilder;

/// The pair actions of a decision, as text.
std::vector<std::string> Pairs(const Situation& situation, int winners) {
  std::vector<std::string> pairs;
  for (const Action& action : KwtaPolicy(winners).Decide(situation).actions) {
    if (IsPair(action.kind)) pairs.push_back(ToString(action));
  }
  return pairs;
}
using Names = std::vector<std::string>;

/// An interval is 6 km for a UAV and a vehicle, 3 km for a worker.
///   u0 at 0: T0 (3 km) 1 interval, T1 (9 km) 2, T2 (15 km) 3
///   w0 at 9 km: T1 1, then T0 and T2 with 2 each and 6 km each: T0 by its index
SituationBuilder Line() {
  SituationBuilder builder;
  builder.Uav({0, 0})
      .Worker({9000, 0})
      .Task({3000, 0})
      .Task({9000, 0})
      .Task({15000, 0})
      .Charge({0, 0});
  return builder;
}

TEST(Kwta, WinnersMustMeet) {
  // K = 1: {T0} and {T1} do not meet; rank 2 of the UAV is T1, and the worker's list {T1, T0} has
  // it.
  EXPECT_EQ(Pairs(Line().Build(), 1), Names{"UiTxWj uav:0 worker:0 task:1"});
  // K = 2: the UAV's best, T0, is among the worker's winners {T1, T0}.
  EXPECT_EQ(Pairs(Line().Build(), 2), Names{"UiTxWj uav:0 worker:0 task:0"});
}

TEST(Kwta, TheBestScoredUavChoosesFirst) {
  // u1 has 20 km: E_tL(2/3) = 0.77 against 1 of u0; both are 1 interval from T0. u0 takes T0 and
  // w0, the nearer worker; u1 finds w1 at its next best task that satisfies (6): T1 (9 + 3 + 6 km).
  SituationBuilder builder;
  builder.Uav({0, 0})
      .Uav({0, 0}, 20e3)
      .Worker({3000, 0})
      .Worker({4000, 0})
      .Task({3000, 0})
      .Task({9000, 0})
      .Charge({3000, 0});
  EXPECT_EQ(Pairs(builder.Build(), 3),
            (Names{"UiTxWj uav:0 worker:0 task:0", "UiTxWj uav:1 worker:1 task:1"}));
}

TEST(Kwta, UavsShortOfRangeCharge) {
  SituationBuilder builder = Line();
  builder.Uav({0, 0}, 14.9e3).Vehicle({6000, 0}).Charge({6000, 0});
  EXPECT_EQ(Pairs(builder.Build(), 3),
            (Names{"UiTxWj uav:0 worker:0 task:0", "UiCyVk uav:1 vehicle:0 charge:0"}));
  // From half on it looks for tasks, and u0 has taken the only worker.
  builder.scenario().uavs[1].range_m = 15e3;
  EXPECT_EQ(Pairs(builder.Build(), 3), Names{"UiTxWj uav:0 worker:0 task:0"});
  // Unless none satisfies constraint (6).
  for (Task& task : builder.scenario().tasks) task.cost_m = 20e3;
  builder.scenario().uavs[0].range_m = 14e3;  // more in need: it chooses first
  EXPECT_EQ(Pairs(builder.Build(), 3), Names{"UiCyVk uav:0 vehicle:0 charge:0"});
}

TEST(Kwta, AVehicleTakesOneUavAndAPointAsManyAsItHasPlaces) {
  SituationBuilder builder;
  builder.Uav({0, 0}, 5e3).Uav({0, 0}, 6e3).Vehicle({0, 0}).Charge({0, 0});
  EXPECT_EQ(Pairs(builder.Build(), 3), Names{"UiCyVk uav:0 vehicle:0 charge:0"});
  builder.Vehicle({0, 0});
  EXPECT_EQ(Pairs(builder.Build(), 3), Names{"UiCyVk uav:0 vehicle:0 charge:0"});
  builder.scenario().charging_points[0].capacity = 2;
  EXPECT_EQ(Pairs(builder.Build(), 3),
            (Names{"UiCyVk uav:0 vehicle:0 charge:0", "UiCyVk uav:1 vehicle:1 charge:0"}));
}

TEST(Kwta, PairsThatCannotEndInTimeArePassedOver) {
  SituationBuilder builder = Line();
  // T0: the worker arrives after 1200 s, sensing takes 300 s. T1: the UAV after 900 s: 1200 s.
  builder.scenario().workers[0].online_until_us = 1499 * kSecondUs;
  EXPECT_EQ(Pairs(builder.Build(), 3), Names{"UiTxWj uav:0 worker:0 task:1"});
}

TEST(Kwta, TheOthersStay) {
  const Situation situation = Line().Vehicle({1, 1}).Build();
  const Decision decision = KwtaPolicy(3).Decide(situation);
  ASSERT_EQ(decision.actions.size(), 2u);
  EXPECT_EQ(decision.actions[0].kind, ActionKind::kVehicleStays);
  EXPECT_EQ(decision.actions[1].kind, ActionKind::kSense);
}

}  // namespace
}  // namespace muster::scheduler
