#include "model/agent.h"

#include <gtest/gtest.h>

#include "model/feasibility.h"

namespace muster {
namespace {

const std::vector<Task> kTasks = {{{3000, 4000}, 600}};

AgentState UavAtOrigin() {
  AgentSpec spec;
  spec.speed_m_s = 10;
  spec.range_full_m = 10'000;
  spec.range_m = 8'000;
  spec.online_until_us = 3600 * kSecondUs;
  return StartOf(AgentKind::kUav, 0, spec, StraightWays());
}

AgentState WorkerAt(Point at) {
  AgentSpec spec;
  spec.at = at;
  spec.speed_m_s = 5;
  spec.online_until_us = 3600 * kSecondUs;
  return StartOf(AgentKind::kWorker, 0, spec, StraightWays());
}

Action Sense() {
  Action action;
  action.kind = ActionKind::kSense;
  action.uav = UavId(0);
  action.worker = WorkerId(0);
  action.task = TaskId(0);
  action.to = kTasks[0].at;
  return action;
}

/// A damaged report may tell of more than a full range: a time below zero would be its charging.
TEST(Charging, NothingIsMissingOfMoreThanAFullRange) {
  EXPECT_EQ(ChargingUs(30'000, 29'000, 50), 20 * kSecondUs);
  EXPECT_EQ(ChargingUs(30'000, 30'000, 50), 0);
  EXPECT_EQ(ChargingUs(30'000, 1e300, 50), 0);
}

TEST(Agent, FliesStraightAndSpendsItsRangeByDistance) {
  AgentState uav = UavAtOrigin();
  Begin(&uav, Sense(), 0, 100 * kSecondUs, {}, 1);
  // 5 km at 10 m/s: 500 s.
  EXPECT_EQ(uav.arrive_us, 600 * kSecondUs);
  const TimeUs halfway = 350 * kSecondUs;
  EXPECT_EQ(PositionAt(uav, halfway), (Point{1500, 2000}));
  EXPECT_DOUBLE_EQ(RangeAt(uav, halfway, kTasks), 8000 - 2500);
  EXPECT_EQ(StatusAt(uav, halfway), AgentStatus::kMoving);
  EXPECT_EQ(StatusAt(uav, 700 * kSecondUs), AgentStatus::kWaiting);
}

TEST(Agent, SensingStartsAtTheLaterArrivalAndTakesCostOverSpeed) {
  AgentState uav = UavAtOrigin();
  AgentState worker = WorkerAt({3000, 0});
  Begin(&uav, Sense(), 0, 0, {}, 1);
  Begin(&worker, Sense(), 0, 0, {}, 1);
  const Activity activity = PlanActivity(uav, worker, kTasks);
  EXPECT_EQ(activity.start_us, 800 * kSecondUs);             // worker: 4 km at 5 m/s
  EXPECT_EQ(activity.end_us, (800 + 600 / 10) * kSecondUs);  // constraint (2)
  const Verdict verdict({activity}, {});
  Settle(&uav, verdict, 830 * kSecondUs, kTasks);
  EXPECT_EQ(StatusAt(uav, 830 * kSecondUs), AgentStatus::kSensing);
  EXPECT_DOUBLE_EQ(RangeAt(uav, 830 * kSecondUs, kTasks), 8000 - 5000 - 300);
  Settle(&uav, verdict, 900 * kSecondUs, kTasks);
  EXPECT_TRUE(uav.idle(900 * kSecondUs));
  EXPECT_EQ(PositionAt(uav, 900 * kSecondUs), kTasks[0].at);
  EXPECT_DOUBLE_EQ(RangeAt(uav, 900 * kSecondUs, kTasks), 8000 - 5000 - 600);
}

TEST(Agent, ChargingFillsWhatIsMissingOnArrival) {
  AgentState uav = UavAtOrigin();
  AgentSpec spec;
  spec.speed_m_s = 10;
  spec.charge_rate_m_s = 50;
  spec.online_until_us = 3600 * kSecondUs;
  AgentState vehicle = StartOf(AgentKind::kVehicle, 2, spec, StraightWays());
  Action charge;
  charge.kind = ActionKind::kCharge;
  charge.uav = UavId(0);
  charge.vehicle = VehicleId(2);
  charge.charge = ChargeId(1);
  charge.to = {1000, 0};
  Begin(&uav, charge, 3, 0, {}, 1);
  Begin(&vehicle, charge, 3, 0, {}, 1);
  const Activity activity = PlanActivity(uav, vehicle, kTasks);
  EXPECT_EQ(activity.start_us, 100 * kSecondUs);
  EXPECT_EQ(activity.end_us, (100 + 60) * kSecondUs);  // (10,000 - 7,000) / 50, constraint (4)
  const Verdict verdict({activity}, {});
  Settle(&uav, verdict, 130 * kSecondUs, kTasks);
  EXPECT_DOUBLE_EQ(RangeAt(uav, 130 * kSecondUs, kTasks), 7000 + 1500);
  Settle(&uav, verdict, 160 * kSecondUs, kTasks);
  EXPECT_EQ(RangeAt(uav, 160 * kSecondUs, kTasks), 10'000);
}

TEST(Agent, ReleaseStopsItWhereItIsWithWhatIsSpentProRata) {
  AgentState uav = UavAtOrigin();
  Begin(&uav, Sense(), 0, 0, {}, 1);
  const Activity activity{Activity::Kind::kSensing, UavId(0),       0, 0,
                          500 * kSecondUs,          560 * kSecondUs};
  const Ruling release{AgentKind::kUav, 0, Ruling::Kind::kReleased, 515 * kSecondUs};
  Settle(&uav, Verdict({activity}, {release}), 600 * kSecondUs, kTasks);
  EXPECT_TRUE(uav.idle(515 * kSecondUs));
  EXPECT_DOUBLE_EQ(RangeAt(uav, 600 * kSecondUs, kTasks), 8000 - 5000 - 600 * 0.25);
}

TEST(Agent, OfTwoReleasesTheEarlierCounts) {
  const Ruling by_order{AgentKind::kUav, 0, Ruling::Kind::kReleased, 120 * kSecondUs};
  const Ruling by_loss{AgentKind::kUav, 0, Ruling::Kind::kReleased, 100 * kSecondUs};
  for (const auto& rulings : {std::vector{by_order, by_loss}, std::vector{by_loss, by_order}}) {
    AgentState uav = UavAtOrigin();
    Begin(&uav, Sense(), 0, 0, {}, 1);
    Settle(&uav, Verdict({}, rulings), 120 * kSecondUs, kTasks);
    EXPECT_EQ(PositionAt(uav, 120 * kSecondUs), (Point{600, 800}));
  }
}

TEST(Agent, ReleaseEndsALegThatGoesRoundSinceThen) {
  constexpr TimeUs kRelease = 110 * kSecondUs, kTick = 120 * kSecondUs;
  const Verdict verdict({}, {{AgentKind::kUav, 0, Ruling::Kind::kReleased, kRelease}});
  AgentState uav = UavAtOrigin();
  Begin(&uav, Sense(), 0, kTick, {}, 1);  // as if a zone had sent it round at this tick
  Settle(&uav, verdict, kTick, kTasks);
  EXPECT_TRUE(uav.idle(kTick));
  EXPECT_EQ(PositionAt(uav, 2 * kTick), (Point{0, 0}));
  // A release of before is no release from what was commanded later.
  Begin(&uav, Sense(), 0, kTick, {}, 1);
  Settle(&uav, verdict, 2 * kTick, kTasks);
  EXPECT_FALSE(uav.idle(2 * kTick));
}

TEST(Agent, FailureHoldsAsLongAsItIsListed) {
  AgentState uav = UavAtOrigin();
  Begin(&uav, Sense(), 0, 0, {}, 1);
  const Verdict failed({}, {{AgentKind::kUav, 0, Ruling::Kind::kFailed, 100 * kSecondUs}});
  Settle(&uav, failed, 120 * kSecondUs, kTasks);
  EXPECT_EQ(StatusAt(uav, 120 * kSecondUs), AgentStatus::kFailed);
  EXPECT_FALSE(uav.idle(120 * kSecondUs));
  EXPECT_EQ(PositionAt(uav, 200 * kSecondUs), (Point{600, 800}));
  Settle(&uav, Verdict(), 240 * kSecondUs, kTasks);
  EXPECT_TRUE(uav.idle(240 * kSecondUs));
}

TEST(Agent, WhoWasLostBeforeItWasReleasedStandsWhereItWasLost) {
  AgentState uav = UavAtOrigin();
  Begin(&uav, Sense(), 0, 0, {}, 1);
  const Verdict verdict({}, {{AgentKind::kUav, 0, Ruling::Kind::kReleased, 110 * kSecondUs},
                             {AgentKind::kUav, 0, Ruling::Kind::kLost, 100 * kSecondUs}});
  Settle(&uav, verdict, 120 * kSecondUs, kTasks);
  EXPECT_EQ(StatusAt(uav, 120 * kSecondUs), AgentStatus::kFailed);
  EXPECT_EQ(PositionAt(uav, 200 * kSecondUs), (Point{600, 800}));
}

TEST(Agent, AnEarlierActivityLikeItIsNotTakenAgain) {
  AgentState uav = UavAtOrigin();
  Begin(&uav, Sense(), 0, 1000 * kSecondUs, {}, 1);
  const Activity earlier{Activity::Kind::kSensing, UavId(0),       0, 0,
                         500 * kSecondUs,          560 * kSecondUs};
  Settle(&uav, Verdict({earlier}, {}), 1010 * kSecondUs, kTasks);
  EXPECT_FALSE(uav.activity);
  EXPECT_EQ(uav.busy_until_us, kNever);
}

TEST(Agent, TakesAMeetingThatBeginsAfterItsWayInTheSameTick) {
  AgentState worker = WorkerAt({3000, 3600});
  Action go;
  go.kind = ActionKind::kGoTo;
  go.worker = WorkerId(0);
  go.to = {3000, 4000};
  Begin(&worker, go, 0, 0, {}, 1);  // arrives at 80 s
  const Activity meeting{Activity::Kind::kSensing, UavId(4), 0, 0, 90 * kSecondUs, 150 * kSecondUs};
  Settle(&worker, Verdict({meeting}, {}), 90 * kSecondUs, kTasks);
  EXPECT_EQ(StatusAt(worker, 90 * kSecondUs), AgentStatus::kSensing);
  EXPECT_FALSE(worker.idle(149 * kSecondUs));
  EXPECT_TRUE(worker.idle(150 * kSecondUs));
}

TEST(Agent, TakesAMeetingThatBeginsAsItIsReleased) {
  // Its partner fails as the decision is due; at the same tick it meets another that is there.
  constexpr TimeUs kTick = 1000 * kSecondUs;
  AgentState uav = UavAtOrigin();
  Begin(&uav, Sense(), 0, 0, {}, 1);  // arrives at 500 s
  const Activity aborted{Activity::Kind::kSensing, UavId(0),        0, 0,
                         900 * kSecondUs,          1200 * kSecondUs};
  Settle(&uav, Verdict({aborted}, {}), 990 * kSecondUs, kTasks);
  ASSERT_EQ(StatusAt(uav, 990 * kSecondUs), AgentStatus::kSensing);
  const Activity meeting{Activity::Kind::kSensing, UavId(0), 1, 0, kTick, 1300 * kSecondUs};
  const Ruling release{AgentKind::kUav, 0, Ruling::Kind::kReleased, kTick};
  const Ruling order = release;
  Settle(&uav, Verdict({aborted, meeting}, {release, order}), kTick, kTasks);
  EXPECT_EQ(StatusAt(uav, kTick), AgentStatus::kSensing);
  EXPECT_EQ(uav.partner, 1);
  EXPECT_FALSE(uav.idle(1299 * kSecondUs));
  EXPECT_TRUE(uav.idle(1300 * kSecondUs));

  // Without a meeting, or failed as well, it is not at work.
  for (const Ruling::Kind kind : {Ruling::Kind::kReleased, Ruling::Kind::kFailed}) {
    AgentState other = UavAtOrigin();
    Begin(&other, Sense(), 0, 0, {}, 1);
    const bool fails = kind == Ruling::Kind::kFailed;
    Settle(&other,
           Verdict(fails ? std::vector{meeting} : std::vector<Activity>(),
                   {release, {AgentKind::kUav, 0, kind, kTick}}),
           kTick, kTasks);
    EXPECT_EQ(StatusAt(other, kTick), fails ? AgentStatus::kFailed : AgentStatus::kIdle);
  }
}

TEST(Agent, AnActivityOfNoLengthIsReleasedFromBeforeItBegins) {
  AgentState uav = UavAtOrigin();
  Begin(&uav, Sense(), 0, 0, {}, 1);  // arrives at 500 s
  const Activity activity{Activity::Kind::kSensing, UavId(0),       0, 0,
                          700 * kSecondUs,          700 * kSecondUs};
  Settle(&uav, Verdict({activity}, {}), 600 * kSecondUs, kTasks);
  EXPECT_EQ(uav.busy_until_us, 700 * kSecondUs);
  const Ruling release{AgentKind::kUav, 0, Ruling::Kind::kReleased, 650 * kSecondUs};
  Settle(&uav, Verdict({activity}, {release}), 720 * kSecondUs, kTasks);
  EXPECT_EQ(uav.busy_until_us, 650 * kSecondUs);
  EXPECT_EQ(uav.action, ActionKind::kNone);
}

TEST(Agent, RunsDryWhereItsRangeEnds) {
  AgentState uav = UavAtOrigin();
  uav.range_at_departure_m = 2500;
  Begin(&uav, Sense(), 0, 0, {}, 1);
  EXPECT_EQ(RunsDryAt(uav), 250 * kSecondUs);
  uav.range_at_departure_m = 5000;  // the last metre may be used
  EXPECT_FALSE(RunsDryAt(uav));
  // 150 m are left on arrival, a quarter of what sensing takes.
  const Activity sensing{Activity::Kind::kSensing, UavId(0),       0, 0,
                         500 * kSecondUs,          560 * kSecondUs};
  uav.range_at_departure_m = 5150;
  EXPECT_EQ(RunsDryAt(uav, sensing, kTasks), 515 * kSecondUs);
  uav.range_at_departure_m = 5600;
  EXPECT_FALSE(RunsDryAt(uav, sensing, kTasks));
}

TEST(Agent, DisturbancesAreFunctionsOfSeedAgentAndDecision) {
  Disturbances disturbances;
  disturbances.wind = {0.1, 0.4};
  disturbances.communication_m = {100, 500};
  AgentState uav = UavAtOrigin();
  Begin(&uav, Sense(), 4, 0, disturbances, 7);
  EXPECT_EQ(uav.range_per_m, RangePerMetre(UavId(0), 4, disturbances, 7));
  EXPECT_GE(uav.range_per_m, 1.1);
  EXPECT_LT(uav.range_per_m, 1.4);
  EXPECT_LE(uav.range_at_departure_m, 8000 - 100);
  EXPECT_GT(uav.range_at_departure_m, 8000 - 500);
  EXPECT_NE(RangePerMetre(UavId(0), 4, disturbances, 7),
            RangePerMetre(UavId(0), 5, disturbances, 7));
  EXPECT_NE(RangePerMetre(UavId(0), 4, disturbances, 7),
            RangePerMetre(UavId(1), 4, disturbances, 7));

  disturbances.match_failure = {1, 1};
  EXPECT_TRUE(MatchFails(Sense(), 0, disturbances, 7));
  disturbances.match_failure = {0, 0};
  EXPECT_FALSE(MatchFails(Sense(), 0, disturbances, 7));
}

TEST(Agent, FailureRatesAreThoseOfTheScenario) {
  Disturbances disturbances;
  disturbances.agent_failure = {0.01, 0.05};
  int failures = 0;
  for (std::int32_t id = 0; id < 1000; ++id) {
    for (std::int32_t decision = 0; decision < 20; ++decision) {
      failures += SuddenlyFails(AgentKind::kWorker, id, decision, disturbances, 3);
    }
  }
  // 20,000 trials at 0.03 in the mean: 600 with a standard deviation of 24 plus that of p.
  EXPECT_NEAR(failures, 600, 120);
}

TEST(Agent, StayingKeepsItFree) {
  AgentState uav = UavAtOrigin();
  Action stay;
  stay.kind = ActionKind::kUavStays;
  stay.uav = UavId(0);
  Begin(&uav, stay, 5, 100, {}, 1);
  EXPECT_TRUE(uav.idle(100));
  EXPECT_EQ(uav.decision, 5);
}

TEST(Feasibility, ConstraintsHoldWithEquality) {
  EXPECT_TRUE(CanReachCharge(5000, 5000));
  EXPECT_FALSE(CanReachCharge(4999, 5000));
  EXPECT_TRUE(CanSense(6000, 2000, 3000, 1000));
  EXPECT_FALSE(CanSense(5999, 2000, 3000, 1000));
  const std::vector<ChargingPoint> points = {{{0, 0}, 1}, {{10, 0}, 1}};
  EXPECT_DOUBLE_EQ(NearestChargeM(StraightWays(), {7, 4}, points), 5);
}

TEST(Feasibility, StrictEndsAtDowntimeOrLimit) {
  AgentState worker = WorkerAt({0, 0});
  Rules rules;
  rules.limit_us = 5000 * kSecondUs;
  EXPECT_EQ(LatestEnd(worker, rules), 3600 * kSecondUs);
  rules.limit_us = 1800 * kSecondUs;
  EXPECT_EQ(LatestEnd(worker, rules), 1800 * kSecondUs);
  rules.availability = Availability::kOverrun;
  EXPECT_EQ(LatestEnd(worker, rules), kNever);
}

}  // namespace
}  // namespace muster
