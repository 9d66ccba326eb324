#include "scheduler/checker.h"

#include <gtest/gtest.h>

#include <limits>

#include "model/road_ways.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::SituationBuilder;

/// Two of each; u0 with 15 km: T0 is exactly within constraint (6) (6 + 3 + 6), T1 is not.
SituationBuilder Base() {
  SituationBuilder builder;
  builder.Uav({0, 0}, 15e3)
      .Uav({0, 0}, 30e3)
      .Worker({3000, 0})
      .Worker({3000, 0})
      .Vehicle({0, 6000})
      .Vehicle({0, 6000})
      .Task({6000, 0})
      .Task({12000, 0})
      .Charge({0, 0})
      .Charge({9000, 0}, 2);
  builder.scenario().tasks[0].cost_m = 3000;
  // T1 is 3 km from C1, T0 too: constraint (6) needs 12 for T0, 18 for T1.
  return builder;
}

Action Make(ActionKind kind, Point to, int uav, int worker, int vehicle, int task, int charge) {
  Action action;
  action.kind = kind;
  action.to = to;
  action.uav = UavId(uav);
  action.worker = WorkerId(worker);
  action.vehicle = VehicleId(vehicle);
  action.task = TaskId(task);
  action.charge = ChargeId(charge);
  action.weight = 1;
  return action;
}
Action Sense(int u = 0, int w = 0, int x = 0) {
  return Make(ActionKind::kSense, x == 0 ? Point{6000, 0} : Point{12000, 0}, u, w, -1, x, -1);
}
Action Charge(int u = 0, int v = 0, int y = 0) {
  return Make(ActionKind::kCharge, y == 0 ? Point{0, 0} : Point{9000, 0}, u, -1, v, -1, y);
}
Action WorkerToTask(int w, int x) {
  return Make(ActionKind::kWorkerToTask, x == 0 ? Point{6000, 0} : Point{12000, 0}, -1, w, -1, x,
              -1);
}
Action GoTo(int uav, int worker, Point to) {
  return Make(ActionKind::kGoTo, to, uav, worker, -1, -1, -1);
}

std::vector<Rule> Broken(const Situation& situation, const std::vector<Action>& actions) {
  std::vector<Rule> rules;
  for (const Violation& violation : CheckActions(situation, actions)) {
    rules.push_back(violation.rule);
  }
  return rules;
}
using Rules_ = std::vector<Rule>;

TEST(Checker, AcceptsEveryKind) {
  const Situation s = Base().Build();
  EXPECT_EQ(Broken(s, {}), Rules_{});
  EXPECT_EQ(Broken(s, {Sense(0, 0, 0), Charge(1, 0, 0), WorkerToTask(1, 1),
                       Make(ActionKind::kVehicleToCharge, {9000, 0}, -1, -1, 1, -1, 1)}),
            Rules_{});
  EXPECT_EQ(
      Broken(s, {Make(ActionKind::kUavStays, {0, 0}, 0, -1, -1, -1, -1),
                 Make(ActionKind::kWorkerStays, {3000, 0}, -1, 0, -1, -1, -1),
                 Make(ActionKind::kVehicleStays, {0, 6000}, -1, -1, 0, -1, -1),
                 Make(ActionKind::kUavToTask, {6000, 0}, 1, -1, -1, 0, -1), GoTo(-1, 1, {1, 2})}),
      Rules_{});
  EXPECT_EQ(Broken(s, {Make(ActionKind::kUavToCharge, {0, 0}, 1, -1, -1, -1, 0)}), Rules_{});
}

TEST(Checker, MessageNamesIdsAndValues) {
  const auto violations = CheckActions(Base().Build(), std::vector<Action>{Sense(0, 1, 1)});
  ASSERT_EQ(violations.size(), 1u);
  EXPECT_EQ(violations[0].message,
            "action 0 (UiTxWj uav:0 worker:1 task:1): constraint (6): way 12000 + sensing 3000 + "
            "to charging 3000 > range 15000 m");
}

TEST(Checker, Agents) {
  Situation s = Base().Build();
  EXPECT_EQ(Broken(s, {Sense(7, 0, 0)}), Rules_{Rule::kUnknownAgent});
  EXPECT_EQ(Broken(s, {Sense(0, 0, 0), WorkerToTask(0, 1)}), Rules_{Rule::kAgentTwice});
  s.workers[0].busy_until_us = 1;
  EXPECT_EQ(Broken(s, {Sense()}), Rules_{Rule::kNotIdle});
  s.workers[0].busy_until_us = 0;
  EXPECT_EQ(Broken(s, {Sense()}), Rules_{});
  s.uavs[0].failed = true;
  EXPECT_EQ(Broken(s, {Sense()}), Rules_{Rule::kNotIdle});
  s.uavs[0].failed = false;
  s.uavs[0].online_until_us = 0;  // online in [from, until): gone now
  EXPECT_EQ(Broken(s, {Sense()}), Rules_{Rule::kNotIdle});
  s.uavs[0].online_until_us = kMinuteUs * 180;
  s.uavs[0].online_from_us = 1;
  EXPECT_EQ(Broken(s, {Sense()}), Rules_{Rule::kNotIdle});
}

TEST(Checker, Tasks) {
  Situation s = Base().Build();
  EXPECT_EQ(Broken(s, {Sense(0, 0, 0), WorkerToTask(1, 0)}), Rules_{Rule::kTaskTwice});
  for (const TaskStatus status : {TaskStatus::kReserved, TaskStatus::kSensing, TaskStatus::kDone,
                                  TaskStatus::kUnreported, TaskStatus::kExpired}) {
    s.task_status[0] = status;
    EXPECT_EQ(Broken(s, {Sense()}), Rules_{Rule::kTaskNotOpen});
    EXPECT_EQ(Broken(s, {WorkerToTask(0, 0)}), Rules_{Rule::kTaskNotOpen});
  }
}

TEST(Checker, Constraint5) {
  SituationBuilder builder = Base();
  builder.scenario().uavs[0].range_m = 9000;
  EXPECT_EQ(Broken(builder.Build(), {Charge(0, 0, 1)}), Rules_{});
  builder.scenario().uavs[0].range_m = 8999;
  EXPECT_EQ(Broken(builder.Build(), {Charge(0, 0, 1)}), Rules_{Rule::kConstraint5});
  EXPECT_EQ(Broken(builder.Build(), {Make(ActionKind::kUavToCharge, {9000, 0}, 0, -1, -1, -1, 1)}),
            Rules_{Rule::kConstraint5});
}

TEST(Checker, Constraint6) {
  SituationBuilder builder = Base();
  builder.scenario().uavs[0].range_m = 12000;  // 6 + 3 + 3
  EXPECT_EQ(Broken(builder.Build(), {Sense()}), Rules_{});
  builder.scenario().uavs[0].range_m = 11999;
  EXPECT_EQ(Broken(builder.Build(), {Sense()}), Rules_{Rule::kConstraint6});
  EXPECT_EQ(Broken(builder.Build(), {Make(ActionKind::kUavToTask, {6000, 0}, 0, -1, -1, 0, -1)}),
            Rules_{Rule::kConstraint6});
}

TEST(Checker, Capacity) {
  Situation s = Base().Build();
  EXPECT_EQ(Broken(s, {Charge(0, 0, 0), Charge(1, 1, 0)}), Rules_{Rule::kCapacity});
  EXPECT_EQ(
      Broken(s, {Charge(0, 0, 0), Make(ActionKind::kVehicleToCharge, {0, 0}, -1, -1, 1, -1, 0)}),
      Rules_{Rule::kCapacity});
  EXPECT_EQ(Broken(s, {Charge(0, 0, 1), Charge(1, 1, 1)}), Rules_{});  // two places
  s.charging_load[1] = 1;
  EXPECT_EQ(Broken(s, {Charge(0, 0, 1)}), Rules_{});
  EXPECT_EQ(Broken(s, {Charge(0, 0, 1), Charge(1, 1, 1)}), Rules_{Rule::kCapacity});
  SituationBuilder unlimited = Base();
  unlimited.scenario().charging_points[0].capacity = std::nullopt;
  EXPECT_EQ(Broken(unlimited.Build(), {Charge(0, 0, 0), Charge(1, 1, 0)}), Rules_{});
}

TEST(Checker, Availability) {
  // Sensing ends at 900 s, charging of u0 at 750 s (150 s after the vehicle's arrival), w1 is at T1
  // at 1800 s, w0 at (3000, 3000) at 600 s.
  const auto with = [](auto list, TimeUs until) {
    SituationBuilder builder = Base();
    (builder.scenario().*list)[0].online_until_us = until;
    return builder;
  };
  const auto check = [&](auto list, TimeUs end, const Action& action) {
    EXPECT_EQ(Broken(with(list, end).Build(), {action}), Rules_{});
    EXPECT_EQ(Broken(with(list, end - 1).Build(), {action}), Rules_{Rule::kAvailability});
    SituationBuilder overrun = with(list, end - 1);
    overrun.scenario().rules.availability = Availability::kOverrun;
    EXPECT_EQ(Broken(overrun.Build(), {action}), Rules_{});
  };
  check(&Scenario::uavs, 900 * kSecondUs, Sense());
  check(&Scenario::workers, 900 * kSecondUs, Sense());
  check(&Scenario::uavs, 750 * kSecondUs, Charge());
  check(&Scenario::vehicles, 750 * kSecondUs, Charge());
  check(&Scenario::workers, 1800 * kSecondUs, WorkerToTask(0, 1));
  check(&Scenario::workers, 600 * kSecondUs, GoTo(-1, 0, {3000, 3000}));
  SituationBuilder late = Base();
  late.scenario().rules.limit_us = 900 * kSecondUs - 1;
  EXPECT_EQ(Broken(late.Build(), {Sense()}), Rules_{Rule::kAvailability});
}

TEST(Checker, NobodyIsSentWhereNoWayLeads) {
  Roads roads;  // two streets that do not meet
  roads.classes = {{"street", {0, 100, 100}, false}};
  roads.points = {{0, 0}, {400'000, 0}, {5'000'000, 0}, {5'400'000, 0}};
  roads.roads = {{1, 0, {0, 1}}, {2, 0, {2, 3}}};
  SituationBuilder builder;
  builder.scenario().ways = std::make_shared<const RoadWays>(
      std::make_shared<const Roads>(roads), PerKind<OpenGround>{{}, {50, 200}, {50, 200}},
      std::vector<Point>{});
  const Situation situation = builder.Worker({0, 0}).Task({5200, 0}).Build();
  EXPECT_EQ(Broken(situation, {GoTo(-1, 0, {350, 0})}), Rules_{});
  EXPECT_EQ(Broken(situation, {GoTo(-1, 0, {5200, 0})}), Rules_{Rule::kAvailability});
  // Too far from any road, though a stop that can be reached is nearest.
  EXPECT_EQ(Broken(situation, {GoTo(-1, 0, {350, 900})}), Rules_{Rule::kAvailability});
  const Action to_task = Make(ActionKind::kWorkerToTask, {5200, 0}, -1, 0, -1, 0, -1);
  EXPECT_EQ(Broken(situation, {to_task}), (Rules_{Rule::kExpiry, Rule::kAvailability}));
}

TEST(Checker, Destination) {
  const Situation s = Base().Build();
  Action action = Sense();
  action.to.x_m += 1;
  EXPECT_EQ(Broken(s, {action}), Rules_{Rule::kDestination});
  action = Charge();
  action.to.y_m += 1;
  EXPECT_EQ(Broken(s, {action}), Rules_{Rule::kDestination});
  EXPECT_EQ(Broken(s, {Make(ActionKind::kWorkerStays, {3000, 1}, -1, 0, -1, -1, -1)}),
            Rules_{Rule::kDestination});
  EXPECT_EQ(Broken(s, {GoTo(-1, 0, {0, 30e3})}), Rules_{});
  EXPECT_EQ(Broken(s, {GoTo(-1, 0, {0, 30e3 + 1})}), Rules_{Rule::kDestination});
  EXPECT_EQ(Broken(s, {GoTo(-1, 0, {-1, 0})}), Rules_{Rule::kDestination});
  EXPECT_EQ(Broken(s, {GoTo(-1, 0, {std::numeric_limits<double>::quiet_NaN(), 0})}),
            Rules_{Rule::kDestination});
}

TEST(Checker, RangeOfAFreeMove) {
  SituationBuilder builder = Base();
  builder.scenario().uavs[0].range_m = 5000;
  EXPECT_EQ(Broken(builder.Build(), {GoTo(0, -1, {5000, 0})}), Rules_{});
  EXPECT_EQ(Broken(builder.Build(), {GoTo(0, -1, {5001, 0})}), Rules_{Rule::kRange});
}

TEST(Checker, Ids) {
  const Situation s = Base().Build();
  const Rules_ ids{Rule::kIds};
  EXPECT_EQ(Broken(s, {Make(ActionKind::kSense, {6000, 0}, 0, -1, -1, 0, -1)}), ids);
  EXPECT_EQ(Broken(s, {Make(ActionKind::kSense, {6000, 0}, 0, 0, 0, 0, -1)}), ids);
  EXPECT_EQ(Broken(s, {Make(ActionKind::kUavStays, {0, 0}, 0, -1, -1, 0, -1)}), ids);
  EXPECT_EQ(Broken(s, {Make(ActionKind::kSense, {6000, 0}, 0, 0, -1, 2, -1)}), ids);
  EXPECT_EQ(Broken(s, {Make(ActionKind::kCharge, {0, 0}, 0, -1, 0, -1, 2)}), ids);
  EXPECT_EQ(Broken(s, {Make(ActionKind::kNone, {0, 0}, -1, -1, -1, -1, -1)}), ids);
  EXPECT_EQ(Broken(s, {Make(static_cast<ActionKind>(10), {0, 0}, 0, -1, -1, -1, -1)}), ids);
  EXPECT_EQ(Broken(s, {Make(ActionKind::kUavStays, {0, 0}, 0, -2, -1, -1, -1)}), ids);
  EXPECT_EQ(Broken(s, {GoTo(0, 0, {0, 0})}), ids);
  EXPECT_EQ(Broken(s, {GoTo(-1, -1, {0, 0})}), ids);
}

TEST(Checker, Weight) {
  const Situation s = Base().Build();
  Action action = Sense();
  action.weight = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Broken(s, {action}), Rules_{Rule::kWeight});
  action.weight = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Broken(s, {action}), Rules_{Rule::kWeight});
}

TEST(Checker, NamesEveryBrokenRule) {
  Situation s = Base().Build();
  s.task_status[1] = TaskStatus::kDone;
  EXPECT_EQ(Broken(s, {Sense(0, 0, 1), Sense(0, 7, 1)}),
            (Rules_{Rule::kTaskNotOpen, Rule::kConstraint6, Rule::kAgentTwice, Rule::kUnknownAgent,
                    Rule::kTaskTwice, Rule::kTaskNotOpen}));
}

}  // namespace
}  // namespace muster::scheduler
