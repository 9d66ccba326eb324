#include "scheduler/policies/rollout/forward_model.h"

#include <gtest/gtest.h>

#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::SituationBuilder;

constexpr TimeUs kInterval = 600 * kSecondUs;

// UAVs go 10 m/s, workers 5 m/s.
TEST(ForwardModel, SensingEndsWhenTheRuleBookSays) {
  const Situation situation = SituationBuilder()
                                  .Uav({1000, 1000}, 20e3)
                                  .Worker({3000, 5000})
                                  .Task({3000, 1000}, 3000)
                                  .Charge({1000, 1000})
                                  .Build();
  Action action;
  action.kind = ActionKind::kSense;
  action.uav = UavId(0);
  action.worker = WorkerId(0);
  action.task = TaskId(0);
  action.to = {3000, 1000};
  ForwardModel model(situation);
  model.Step({action});
  // The worker arrives at 800 s, sensing takes 300 s.
  EXPECT_EQ(model.situation().now_us, kInterval);
  EXPECT_EQ(model.situation().decision, 1);
  EXPECT_EQ(model.situation().task_status[0], TaskStatus::kReserved);
  EXPECT_EQ(model.situation().uavs[0].busy_until_us, 1100 * kSecondUs);
  EXPECT_FALSE(model.situation().uavs[0].idle(kInterval));
  EXPECT_TRUE(model.done().empty());
  model.Step({});
  EXPECT_EQ(model.situation().task_status[0], TaskStatus::kDone);
  ASSERT_EQ(model.done().size(), 1u);
  EXPECT_EQ(model.done()[0].end_us, 1100 * kSecondUs);
  const AgentState& uav = model.situation().uavs[0];
  EXPECT_TRUE(uav.idle(model.situation().now_us));
  EXPECT_EQ(uav.to, (Point{3000, 1000}));
  EXPECT_NEAR(model.situation().range_m(uav), 20e3 - 2000 - 3000, 1e-6);
}

TEST(ForwardModel, ChargingHoldsItsPlaceUntilTheUavIsFull) {
  const Situation situation =
      SituationBuilder().Uav({1000, 1000}, 10e3).Vehicle({1000, 9000}).Charge({1000, 2000}).Build();
  Action action;
  action.kind = ActionKind::kCharge;
  action.uav = UavId(0);
  action.vehicle = VehicleId(0);
  action.charge = ChargeId(0);
  action.to = {1000, 2000};
  ForwardModel model(situation);
  model.Step({action});  // the vehicle arrives at 700 s, 21 km at 100 m/s take 210 s
  EXPECT_EQ(model.situation().free_places(ChargeId(0)), 0);
  EXPECT_EQ(model.situation().vehicles[0].busy_until_us, 910 * kSecondUs);
  model.Step({});
  EXPECT_EQ(model.situation().free_places(ChargeId(0)), 1);
  EXPECT_EQ(model.situation().range_m(model.situation().uavs[0]), 30e3);
  EXPECT_TRUE(model.done().empty());
}

TEST(ForwardModel, AgentsLeaveAtTheirDowntimeAndNothingHappensAfterTheLimit) {
  SituationBuilder builder;
  builder.Uav({1000, 1000}).Worker({1000, 1000}).Task({1000, 1000}, 6000).Charge({1000, 1000});
  builder.scenario().rules.limit_us = 900 * kSecondUs;
  builder.scenario().rules.availability = Availability::kOverrun;
  builder.scenario().workers[0].online_until_us = 500 * kSecondUs;
  builder.Worker({2000, 1000});
  builder.scenario().workers[1].online_until_us = 300 * kSecondUs;
  const Situation situation = builder.Build();
  Action action;
  action.kind = ActionKind::kSense;
  action.uav = UavId(0);
  action.worker = WorkerId(0);
  action.task = TaskId(0);
  action.to = {1000, 1000};
  {
    ForwardModel model(situation);
    model.Step({action});  // 600 s
    EXPECT_EQ(model.situation().workers.size(), 0u) << "one is done, the other offline";
    EXPECT_EQ(model.done().size(), 1u);
    model.Step({});
    EXPECT_TRUE(model.over());
    EXPECT_EQ(model.situation().now_us, 900 * kSecondUs);
  }
  ForwardModel late(situation);
  late.Step({});
  EXPECT_EQ(late.situation().workers.size(), 0u);
  EXPECT_TRUE(late.anybody());  // the UAV
}

}  // namespace
}  // namespace muster::scheduler
