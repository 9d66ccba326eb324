#include "scheduler/policies/baselines/greedy.h"

#include <gtest/gtest.h>

#include "base/random.h"
#include "model/generator.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::SituationBuilder;
using Aim = GreedyPolicy::Aim;

/// One row of five 1 km cells, centres at 500, 1500, ... m; tasks at cells 0, 0 and 3.
///   cell          0  1  2  3  4
///   sum of km     3  4  5  6  9     (to 0, 0, 3: 0+0+3, 1+1+2, 2+2+1, 3+3+0, 4+4+1)
///   nearest km    0  1  1  0  1
SituationBuilder Row() {
  SituationBuilder builder;
  builder.scenario().width_m = 5000;
  builder.scenario().height_m = 1000;
  builder.scenario().rules.interval_us = 200 * kSecondUs;  // UAV, vehicle 2 km, worker 1 km
  builder.Task({500, 500}).Task({500, 500}).Task({3500, 500});
  return builder;
}

/// East of the only agent's destination, or of where it stays; with its kind.
std::pair<ActionKind, double> Move(const SituationBuilder& builder, Aim aim,
                                   std::size_t action = 0) {
  const Decision decision = GreedyPolicy(aim).Decide(builder.Build());
  return {decision.actions.at(action).kind, decision.actions.at(action).to.x_m};
}

TEST(Greedy, SumGoesToTheMiddleNearestToTheNextTask) {
  // From cell 2 a UAV reaches all five cells.
  EXPECT_EQ(Move(Row().Uav({2500, 500}), Aim::kSum), std::pair(ActionKind::kGoTo, 500.0));
  EXPECT_EQ(Move(Row().Uav({2500, 500}), Aim::kNearest), std::pair(ActionKind::kGoTo, 500.0));
  // From cell 4 it reaches 2, 3, 4.
  EXPECT_EQ(Move(Row().Uav({4500, 500}), Aim::kSum), std::pair(ActionKind::kGoTo, 2500.0));
  EXPECT_EQ(Move(Row().Uav({4500, 500}), Aim::kNearest), std::pair(ActionKind::kGoTo, 3500.0));
  // A worker reaches 1, 2, 3 from cell 2.
  EXPECT_EQ(Move(Row().Worker({2500, 500}), Aim::kSum), std::pair(ActionKind::kGoTo, 1500.0));
  EXPECT_EQ(Move(Row().Worker({2500, 500}), Aim::kNearest), std::pair(ActionKind::kGoTo, 3500.0));
}

/// What is out of reach is not looked at: the largest area has 4 * 10^8 cells.
TEST(Greedy, LooksAtNoMoreOfALargeAreaThanCanBeReached) {
  SituationBuilder builder = Row().Uav({19'000'000 - 500, 500});
  builder.scenario().width_m = builder.scenario().height_m = 2e7;
  const Decision decision = GreedyPolicy(Aim::kNearest).Decide(builder.Build());
  // West: 2 km off are reached, and nearer to the tasks.
  EXPECT_EQ(decision.actions.at(0).to, (Point{18'997'500, 500}));
  // Centres within 2 km in the rows 0, 1 and 2: 5, 3 and 1.
  EXPECT_EQ(decision.candidates, 9);
}

TEST(Greedy, WhoIsThereStays) {
  EXPECT_EQ(Move(Row().Uav({500, 500}), Aim::kSum), std::pair(ActionKind::kUavStays, 500.0));
}

TEST(Greedy, RangeAndDowntimeLimitTheMove) {
  EXPECT_EQ(Move(Row().Uav({4500, 500}, 1000), Aim::kSum), std::pair(ActionKind::kGoTo, 3500.0));
  EXPECT_EQ(Move(Row().Uav({4600, 500}, 50), Aim::kSum), std::pair(ActionKind::kUavStays, 4600.0));
  SituationBuilder builder = Row().Uav({4500, 500});
  builder.scenario().uavs[0].online_until_us = 100 * kSecondUs;  // 1 km
  EXPECT_EQ(Move(builder, Aim::kSum), std::pair(ActionKind::kGoTo, 3500.0));
  builder.scenario().rules.availability = Availability::kOverrun;
  EXPECT_EQ(Move(builder, Aim::kSum), std::pair(ActionKind::kGoTo, 2500.0));
}

TEST(Greedy, VehiclesFollowWhereUavsAreBoundFor) {
  // The UAV goes from cell 4 to 2 (sum) or 3 (nearest); a vehicle at cell 4 goes to that cell.
  const SituationBuilder builder = Row().Uav({4500, 500}).Vehicle({4500, 500});
  EXPECT_EQ(Move(builder, Aim::kSum, 1), std::pair(ActionKind::kGoTo, 2500.0));
  EXPECT_EQ(Move(builder, Aim::kNearest, 1), std::pair(ActionKind::kGoTo, 3500.0));
  // A busy UAV counts with its destination.
  Situation situation = builder.Build();
  situation.uavs[0].busy_until_us = kMinuteUs;
  situation.uavs[0].to = {4500, 500};
  const Decision decision = GreedyPolicy(Aim::kSum).Decide(situation);
  ASSERT_EQ(decision.actions.size(), 1u);
  EXPECT_EQ(decision.actions[0].kind, ActionKind::kVehicleStays);
}

/// With many tasks the least sum is found by bounds of it. The area's last row and column are half
/// cells.
TEST(Greedy, AmongManyTasksTheLeastSumIsThatOfATrial) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SituationBuilder builder;
    builder.scenario().width_m = builder.scenario().height_m = 39'500;
    Random random(seed, Stream::kTest);
    const auto place = [&] {
      const double x_m = 39'500 * random.Uniform();
      return Point{x_m, 39'500 * random.Uniform()};
    };
    for (int i = 0; i < 600; ++i) builder.Task(place());
    for (int i = 0; i < 40; ++i) builder.Worker(place());
    const Situation situation = builder.Build();
    const double reach_m =
        situation.workers[0].speed_m_s * ToSeconds(situation.site->rules.interval_us);
    const Decision decision = GreedyPolicy(Aim::kSum).Decide(situation);
    std::int64_t candidates = 0;
    for (std::size_t i = 0; i < 40; ++i) {
      const Point from = situation.workers[i].to;
      Point best = from;
      double least = 1e18;
      for (int row = 0; row < 40; ++row) {
        for (int column = 0; column < 40; ++column) {
          const Point centre = CellCentre(column, row, 39'500, 39'500);
          if (Distance(from, centre) > reach_m) continue;
          ++candidates;
          double sum = 0;
          for (const muster::Task& task : situation.site->tasks) sum += Distance(centre, task.at);
          if (sum < least) {
            least = sum;
            best = centre;
          }
        }
      }
      EXPECT_EQ(decision.actions.at(i).to, best) << "worker " << i;
    }
    EXPECT_EQ(decision.candidates, candidates);
  }
}

TEST(Greedy, OnlyOpenTasksAttract) {
  Situation situation = Row().Uav({2500, 500}).Build();
  situation.task_status = {TaskStatus::kDone, TaskStatus::kSensing, TaskStatus::kOpen};
  EXPECT_EQ(GreedyPolicy(Aim::kSum).Decide(situation).actions.at(0).to, (Point{3500, 500}));
  situation.task_status[2] = TaskStatus::kReserved;
  EXPECT_EQ(GreedyPolicy(Aim::kSum).Decide(situation).actions.at(0).kind, ActionKind::kUavStays);
}

}  // namespace
}  // namespace muster::scheduler
