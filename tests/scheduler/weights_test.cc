#include "scheduler/weights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/geometry.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::SituationBuilder;

Eigen::ArrayXd Array(std::initializer_list<double> values) {
  Eigen::ArrayXd array(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), array.data());
  return array;
}

TEST(Softplus, KnownValuesAndExtremes) {
  EXPECT_NEAR(Softplus(0), 0.6931471805599453, 1e-15);  // ln 2
  EXPECT_NEAR(Softplus(1), 1.3132616875182228, 1e-15);  // ln(1 + e) = ln 3.718281828
  EXPECT_EQ(Softplus(100), 100.0);                      // + e^-100 = 4e-44
  EXPECT_EQ(Softplus(1e300), 1e300);
  EXPECT_NEAR(Softplus(-50), std::exp(-50.0), 1e-35);
  EXPECT_EQ(Softplus(-1e300), 0.0);
}

TEST(IntervalCounts, RoundsUpOnWholeMicroseconds) {
  // 6000 m at 10 m/s are exactly one interval of 600 s; 1 mm more are 100 us more: two.
  const auto counts = IntervalCounts(Array({0, 1, 6000, 6000.001, 12000}), 10, 10 * kMinuteUs);
  EXPECT_TRUE((counts == Array({1, 1, 1, 2, 2})).all()) << counts.transpose();
  // 4 um more are 0.4 us, rounded away.
  EXPECT_EQ(IntervalCounts(Array({6000.000004}), 10, 10 * kMinuteUs)(0), 1);
}

TEST(IntervalCounts, EqualTheIntegerRuleEverywhere) {
  const std::uint64_t seed = 20;
  SCOPED_TRACE(seed);
  Random random(seed, Stream::kTest);
  for (int i = 0; i < 20000; ++i) {
    const double speed = random.Uniform(0.1, 30);
    const TimeUs unit = 1 + random.Below(1'800'000'000);
    // Half of them within a microsecond of a multiple of the unit.
    const double way =
        i % 2 == 0
            ? random.Uniform(0, 1e5)
            : speed * 1e-6 * (static_cast<double>(unit * random.Below(30)) + random.Uniform(-1, 1));
    if (way < 0) continue;
    const double count = IntervalCounts(Array({way}), speed, unit)(0);
    ASSERT_EQ(static_cast<std::int64_t>(count), Intervals(TravelUs(way, speed), unit))
        << way << " " << speed << " " << unit;
  }
}

// Eq. 4-1
TEST(TaskLikelihood, IsConcaveInTheShareOfRange) {
  // (1 - e^-0.5) / (1 - e^-1) = 0.3934693403 / 0.6321205588
  EXPECT_NEAR(TaskLikelihood(0.5), 0.6224593312018546, 1e-15);
  EXPECT_NEAR(TaskLikelihood(1), 1.0, 1e-15);
  EXPECT_EQ(TaskLikelihood(0), 1e-6);  // clamped
  // Eq. 4-2, 4-3: it rises, ever more slowly.
  for (double s = 0.1; s < 0.95; s += 0.05) {
    EXPECT_GT(TaskLikelihood(s + 0.05), TaskLikelihood(s));
    EXPECT_LT(TaskLikelihood(s + 0.05) - TaskLikelihood(s),
              TaskLikelihood(s) - TaskLikelihood(s - 0.05));
  }
}

// Eq. 4-4
TEST(ChargeLikelihood, MirrorsTheTaskLikelihood) {
  // (1 - e^-0.75) / (1 - e^-1) = 0.5276334473 / 0.6321205588
  EXPECT_NEAR(ChargeLikelihood(0.25), 0.8347038233, 1e-10);
  EXPECT_NEAR(ChargeLikelihood(0), 1.0, 1e-15);
  EXPECT_EQ(ChargeLikelihood(1), 1e-6);  // a full UAV hardly needs any: clamped
}

// Eq. 4-5 (4-7 is the same with the other likelihood)
TEST(UavMatchCost, AveragesOverTheFeasible) {
  Table<std::int32_t> intervals(2, 3);
  intervals << 1, 2, 5, 3, 4, 6;
  Table<bool> feasible(2, 3);
  feasible << true, true, false, true, false, false;
  const Eigen::ArrayXd likelihood = Array({0.5, 0.25});
  // site 0: (1 / 0.5 + 3 / 0.25) / 2 = (2 + 12) / 2; site 1: (2 / 0.5) / 1; site 2: none.
  EXPECT_TRUE(
      (UavMatchCost(intervals, likelihood, feasible, 18, false) == Array({7, 4, 18})).all());
  // As printed, all are divided by 2, and an empty sum is 0.
  EXPECT_TRUE((UavMatchCost(intervals, likelihood, feasible, 18, true) == Array({7, 2, 0})).all());
  // No UAVs: 0 for every site.
  EXPECT_TRUE((UavMatchCost(Table<std::int32_t>(0, 2), Array({}), Table<bool>(0, 2), 18, false) ==
               Array({0, 0}))
                  .all());
}

// Eq. 4-6, 4-8
TEST(PartnerMatchCost, IsTheMean) {
  Table<std::int32_t> intervals(2, 2);
  intervals << 1, 2, 3, 7;
  // (1 + 3) / 2, (2 + 7) / 2
  EXPECT_TRUE((PartnerMatchCost(intervals) == Array({2, 4.5})).all());
  EXPECT_TRUE((PartnerMatchCost(Table<std::int32_t>(0, 2)) == Array({0, 0})).all());
}

// Eq. 4-9, 4-11, 4-13, 4-16
TEST(ChoiceProbabilities, AreASoftmaxOfMinusTheCounts) {
  // 1 / (1 + e^-1) = 1 / 1.3678794412
  const Eigen::ArrayXd p = ChoiceProbabilities(Array({1, 2}));
  EXPECT_NEAR(p(0), 0.7310585786300049, 1e-15);
  EXPECT_NEAR(p(1), 0.2689414213699951, 1e-15);
  // Only differences matter, however large the counts are.
  const Eigen::ArrayXd far = ChoiceProbabilities(Array({1'000'001, 1'000'000, 3'000'000}));
  EXPECT_EQ(far(0), p(1));
  EXPECT_EQ(far(1), p(0));
  EXPECT_EQ(far(2), 0.0);
  EXPECT_EQ(ChoiceProbabilities(Array({})).size(), 0);
}

// Eq. 4-10, 4-12, 4-14, 4-17
TEST(MoveBenefit, IsTheRelativeGainPerInterval) {
  // Softplus((4 - 2) / 4) / 2 = ln(1 + e^0.5) / 2 = ln(2.6487212707) / 2
  EXPECT_NEAR(MoveBenefit(4, 2, 2), 0.48703849209005334, 1e-15);
  EXPECT_NEAR(MoveBenefit(4, 4, 1), std::log(2.0), 1e-15);      // as staying
  EXPECT_NEAR(MoveBenefit(0, 0, 3), std::log(2.0) / 3, 1e-15);  // 0 / 0 counts 0
  EXPECT_EQ(MoveBenefit(0, 1, 1), 0.0);                         // infinitely worse
}

// Eq. 4-15
TEST(UavBenefit, WeighsByTheRangeLeft) {
  EXPECT_NEAR(UavBenefit(5000, 20000, 0.8, 0.4), 0.5, 1e-15);  // 0.25 * 0.8 + 0.75 * 0.4
  EXPECT_EQ(UavBenefit(0, 0, 0.8, 0.4), 0.4);
}

// Eq. 4-18
TEST(PairWeight, AddsFoundationPerIntervalAndBenefits) {
  EXPECT_EQ(SenseFoundation(Foundation::kHierarchical), 100.0);
  // Section 5.3.3: Softplus(1) = ln(1 + e)
  EXPECT_NEAR(SenseFoundation(Foundation::kUniform), 1.3132616875182228, 1e-15);
  // 100 / max(2, 5) + 0.3 + 0.5
  EXPECT_NEAR(PairWeight(100, 2, 5, 0.5, 0.3), 20.8, 1e-14);
  EXPECT_NEAR(PairWeight(100, 5, 2, 0.5, 0.3), 20.8, 1e-14);
}

// Eq. 4-19
TEST(ChargeFoundation, GrowsAsRangeFalls) {
  // Softplus(10 + e^0.5) = 11.6487212707 + ln(1 + e^-11.6487212707) = 11.6487212707 + 0.0000087302
  EXPECT_NEAR(ChargeFoundation(Foundation::kHierarchical, 0.5), 11.648730000870822, 1e-13);
  // Softplus(e^0.5 / e) = ln(1 + e^0.6065306597)
  EXPECT_NEAR(ChargeFoundation(Foundation::kUniform, 0.5), 1.0417093877814123, 1e-14);
  EXPECT_GT(ChargeFoundation(Foundation::kHierarchical, 0.1),
            ChargeFoundation(Foundation::kHierarchical, 0.9));
}

TEST(ExpectedCosts, OneProbeByHandAndEqualProbesAgree) {
  const std::vector<Point> sites = {{0, 0}, {12000, 0}};
  // At 10 m/s and 600 s from (0, 0): 1 and 2 intervals; costs 5 and 10:
  // 0.7310585786 * 5 + 0.2689414214 * 10
  const Probe probe = {{0, 0}, 10};
  const Probe faster = {{0, 0}, 20};  // 1 and 1 intervals: the plain mean
  const auto costs =
      ExpectedCosts({probe, faster, probe}, sites, Array({5, 10}), 10 * kMinuteUs, {});
  EXPECT_NEAR(costs[0], 6.344707106849976, 1e-14);
  EXPECT_EQ(costs[1], 7.5);
  EXPECT_EQ(costs[2], costs[0]);
  EXPECT_EQ(ExpectedCosts({probe}, {}, Array({}), kMinuteUs, {})[0], 0.0);
}

/// One UAV with half its range, one worker, one vehicle, two tasks, one charging point:
///   interval 600 s, UAV and vehicle 6000 m an interval, worker 3000 m an interval
///   u0 (0, 0) 15 of 30 km; w0 (3000, 0); v0 (0, 6000); T0 (6000, 0); T1 (12000, 0); C0 (0, 0)
/// Constraint (6): T0 6 + 3 + 6 = 15 <= 15 holds; T1 12 + 3 + 12 = 27 does not.
Situation HandSituation() {
  return SituationBuilder()
      .Uav({0, 0}, 15e3)
      .Worker({3000, 0})
      .Vehicle({0, 6000})
      .Task({6000, 0})
      .Task({12000, 0})
      .Charge({0, 0})
      .Build();
}

TEST(Weights, SmallSituationByHand) {
  const Situation situation = HandSituation();
  const Weights w = ComputeWeights(situation);
  ASSERT_EQ(w.n_uavs(), 1);
  ASSERT_EQ(w.n_tasks(), 2);
  EXPECT_TRUE(w.senseable(0, 0));
  EXPECT_FALSE(w.senseable(0, 1));
  EXPECT_TRUE(w.chargeable(0, 0));
  EXPECT_EQ(w.uav_task.intervals(0, 0), 1);
  EXPECT_EQ(w.uav_task.intervals(0, 1), 2);
  EXPECT_EQ(w.worker_task.intervals(0, 0), 1);
  EXPECT_EQ(w.worker_task.intervals(0, 1), 3);
  EXPECT_EQ(w.worker_task.travel_us(0, 1), 1800 * kSecondUs);

  // Du_tL = [1 / E_tL(0.5), none: 180 / 10] = [1.6065306597, 18]
  // Worker at its place: intervals 1, 3: p = 0.8807970780, 0.1192029220
  //   before 0.8807970780 * 1.6065306597 + 0.1192029220 * 18 = 3.5606801072
  // at T0: intervals 1, 2: p = 0.7310585786, 0.2689414214: after 6.0154136053
  //   Softplus((3.5606801072 - 6.0154136053) / 3.5606801072) = Softplus(-0.6894001776) / 1
  EXPECT_NEAR(w.worker_to_task(0, 0), 0.4067156697592846, 1e-14);
  // at T1: p the other way round: after 13.5911170544; Softplus(-2.8170003048) / 3
  EXPECT_NEAR(w.worker_to_task(0, 1), 0.019355355853445153, 1e-14);

  // Dw_tL = [1, 3]; the UAV at (0, 0): 0.7310585786 * 1 + 0.2689414214 * 3 = 1.5378828427,
  // at T0: intervals 1, 1: 2. Task part Softplus(-0.3004891819) = 0.5541470987.
  // One charging point: its expected cost is the same anywhere: charge part ln 2.
  // UiTx: 15 - 6 = 9 of 30 km left: 0.3 * 0.5541470987 + 0.7 * 0.6931471806
  EXPECT_NEAR(w.uav_to_task(0, 0), 0.65144715600272, 1e-14);
  // UiTxWj: 3 km less: 0.2 * 0.5541470987 + 0.8 * 0.6931471806
  EXPECT_NEAR(w.uav_senses(0, 0), 0.6653471641884617, 1e-14);
  // 100 / max(1, 1) + 0.4067156698 + 0.6653471642
  EXPECT_NEAR(w.Sense(0, 0, 0), 101.07206283394774, 1e-12);

  // The UAV is at C0 already: all gains 0, one interval.
  EXPECT_NEAR(w.uav_to_charge(0, 0), std::log(2.0), 1e-15);
  EXPECT_NEAR(w.uav_charges(0, 0), std::log(2.0), 1e-15);
  EXPECT_NEAR(w.vehicle_to_charge(0, 0), std::log(2.0), 1e-15);
  // Softplus(10 + e^0.5) / max(1, 1) + ln 2 + ln 2
  EXPECT_NEAR(w.Charge(0, 0, 0), 13.035024361990713, 1e-12);
  EXPECT_NEAR(w.stay, std::log(2.0), 1e-15);
}

TEST(Weights, UniformFoundationChangesOnlyThePairsOwnTerm) {
  const Situation situation = HandSituation();
  const Weights h = ComputeWeights(situation);
  const Weights u = ComputeWeights(situation, Foundation::kUniform);
  EXPECT_EQ(u.worker_to_task(0, 0), h.worker_to_task(0, 0));
  EXPECT_EQ(u.uav_senses(0, 0), h.uav_senses(0, 0));
  // 1.3132616875 + 1.0720628339; 1.0417093878 + 2 ln 2
  EXPECT_NEAR(u.Sense(0, 0, 0), 2.3853245214659, 1e-12);
  EXPECT_NEAR(u.Charge(0, 0, 0), 2.4280037489013, 1e-12);
}

TEST(Weights, CeilToMinutesCountsMinutes) {
  SituationBuilder builder;
  builder.Uav({0, 0}).Task({6000, 0}).Charge({90, 0});
  builder.scenario().rules.ceil_to_minutes = true;
  const Weights w = ComputeWeights(builder.Build());
  EXPECT_EQ(w.uav_task.intervals(0, 0), 10);   // 600 s
  EXPECT_EQ(w.uav_charge.intervals(0, 0), 1);  // 9 s
}

TEST(Weights, MeanOverAllIsTheLiteralForm) {
  SituationBuilder builder;
  // Only the first UAV can sense (constraint (6): 0 + 3 + 0 <= 30; the second has 1 km).
  builder.Uav({0, 0}, 30e3)
      .Uav({0, 0}, 1e3)
      .Worker({0, 0})
      .Task({0, 0})
      .Task({12000, 0})
      .Charge({0, 0});
  const Weights feasible = ComputeWeights(builder.Build());
  builder.scenario().rules.mean_over_all = true;
  const Weights all = ComputeWeights(builder.Build());
  // All of Du_tL halve: the relative gain, and so every weight, stays the same.
  EXPECT_NEAR(all.worker_to_task(0, 1), feasible.worker_to_task(0, 1), 1e-14);
  // Once no UAV can sense at T1, the literal form says that it is matched at no cost, ours that it
  // takes the whole mission (18 intervals): going there looks better to one and worse to the other.
  builder.scenario().tasks[1].cost_m = 29e3;
  const Weights none_all = ComputeWeights(builder.Build());
  builder.scenario().rules.mean_over_all = false;
  const Weights none = ComputeWeights(builder.Build());
  const double stay_over_4 = std::log(2.0) / 4;  // 12 km at 5 m/s: 4 intervals
  EXPECT_GT(none_all.worker_to_task(0, 1), stay_over_4);
  EXPECT_LT(none.worker_to_task(0, 1), stay_over_4);
}

TEST(Weights, OnlyIdleAgentsAndOpenTasksCount) {
  Situation situation = HandSituation();
  situation.task_status[0] = TaskStatus::kReserved;
  situation.workers[0].busy_until_us = 1;
  situation.vehicles[0].failed = true;
  const Weights w = ComputeWeights(situation);
  ASSERT_EQ(w.n_tasks(), 1);
  EXPECT_EQ(w.tasks[0], TaskId(1));
  EXPECT_EQ(w.n_workers(), 0);
  EXPECT_EQ(w.n_vehicles(), 0);
  // Nobody to match with: all expected costs 0, gains 0 / 0 = 0, two intervals.
  EXPECT_NEAR(w.uav_to_task(0, 0), std::log(2.0) / 2, 1e-15);
}

TEST(Weights, EmptySituation) {
  const Weights w = ComputeWeights(SituationBuilder().Build());
  EXPECT_EQ(w.n_uavs() + w.n_workers() + w.n_vehicles() + w.n_tasks() + w.n_charging_points(), 0);
}

}  // namespace
}  // namespace muster::scheduler
