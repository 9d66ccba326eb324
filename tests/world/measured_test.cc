// Measured agents through the referee, by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "tests/world/measured_flight.h"

namespace muster::world {
namespace {

using testing::Charge;
using testing::Flight;
using testing::Happened;
using testing::Kind;
using testing::Report;
using testing::Sense;
using testing::Shown;
using testing::Small;

constexpr auto kUav = AgentKind::kUav;
constexpr auto kWorker = AgentKind::kWorker;
constexpr auto kVehicle = AgentKind::kVehicle;

/// The worker's way, 4 km to the north, at that speed.
Point WorkerAt(TimeUs t_s, double speed_m_s) {
  return {3000, std::min(4000.0, speed_m_s * static_cast<double>(t_s))};
}

TEST(Measured, WhoDoesAsComputedHasTheComputedOutcome) {
  for (const TimeUs tick : {10, 20, 30}) {
    Flight computed(Small(), tick), measured(Small(), tick);
    for (const AgentKind kind : kAgentKinds) measured.Measure(kind);
    for (Flight* flight : {&computed, &measured}) flight->Judge(0, 0).Command(Sense());
    for (TimeUs t = tick; t <= 1500; t += tick) {
      computed.Judge(t);
      for (const AgentKind kind : {kUav, kWorker}) {
        // By clocks and places of its own: half a slack beside what is computed.
        const AgentState& agent = computed.agent(kind);
        Point at = PositionAt(agent, t * kSecondUs);
        at.x_m += 0.5 * agent.speed_m_s;
        std::optional<double> range_m;
        if (kind == kUav) range_m = RangeAt(agent, t * kSecondUs, computed.scenario().tasks) + 5;
        measured.At(kind, at, t, {}, range_m);
        if (t >= (kind == kUav ? 500 : 800) && t < 860) measured.Arrived(kind);
        if (t >= 860 && t < 860 + tick) {
          measured.Done(kind, kind == kUav ? std::optional(9405.0) : std::nullopt);
        }
      }
      measured.Judge(t);
      EXPECT_EQ(measured.refusal(), "") << t;
    }
    EXPECT_EQ(computed.happened(),
              (Happened{{Kind::kSensingStarted, 800}, {Kind::kSensingDone, 860}}));
    EXPECT_EQ(measured.happened(), computed.happened());
    for (const AgentKind kind : kAgentKinds) {
      AgentState agent = measured.agent(kind);
      agent.measured.reset();
      EXPECT_EQ(Shown(agent), Shown(computed.agent(kind)));
    }
  }
}

TEST(Measured, WithoutADriverNobodyIsNotReady) {
  AgentState agent;
  agent.measured.emplace();
  agent.online_until_us = agent.busy_until_us = kNever;
  ASSERT_TRUE(agent.not_ready());
  SayAsComputed(&agent, 5);
  EXPECT_TRUE(agent.idle(5));
}

TEST(Measured, WhoIsLateAndSaysSoMovesTheSensing) {
  Flight flight(Small());
  flight.Measure(kWorker).Judge(0, 0).Command(Sense());
  for (TimeUs t = 30; t <= 990; t += 30) flight.At(kWorker, WorkerAt(t, 4), t, 1000).Judge(t);
  EXPECT_EQ(flight.refusal(), "");
  EXPECT_EQ(flight.task(), TaskStatus::kReserved);
  EXPECT_EQ(flight.agent(kUav).activity->start_us, 1000 * kSecondUs);
  flight.Arrived(kWorker).Judge(1020);
  EXPECT_EQ(flight.task(), TaskStatus::kSensing);
  flight.Judge(1050).Done(kWorker).Judge(1080);
  EXPECT_EQ(flight.happened(),
            (Happened{{Kind::kSensingStarted, 1000}, {Kind::kSensingDone, 1060}}));
  EXPECT_EQ(flight.task(), TaskStatus::kDone);
  EXPECT_DOUBLE_EQ(flight.agent(kUav).range_at_departure_m, 15'000 - 5000 - 600);
}

TEST(Measured, WithoutAWordArrivalAndEndMoveFromTickToTick) {
  for (const bool restarts : {false, true}) {
    Flight flight(Small());
    flight.Measure(kWorker).Judge(0, 0).Command(Sense()).Until(900);
    EXPECT_EQ(flight.task(), TaskStatus::kReserved);
    EXPECT_EQ(flight.agent(kUav).activity->start_us, 930 * kSecondUs);
    if (restarts) flight.RestartWorld();
    flight.Arrived(kWorker).Judge(930);
    EXPECT_EQ(flight.task(), TaskStatus::kSensing);
    if (restarts) flight.RestartWorld();
    flight.Judge(960).Judge(990).Judge(1020);  // computed, it would have ended at 990
    EXPECT_EQ(flight.task(), TaskStatus::kSensing);
    EXPECT_FALSE(flight.agent(kUav).idle(1020 * kSecondUs));
    flight.Done(kWorker).Judge(1050);
    EXPECT_EQ(flight.happened(),
              (Happened{{Kind::kSensingStarted, 930}, {Kind::kSensingDone, 1050}}));
    EXPECT_TRUE(flight.agent(kUav).idle(1050 * kSecondUs));
    EXPECT_TRUE(flight.agent(kWorker).idle(1050 * kSecondUs));
  }
}

TEST(Measured, ALateOneIsGivenUpAfterTheScenariosPatience) {
  for (const TimeUs patience : {600, 95}) {
    for (const bool restarts : {false, true}) {
      Scenario scenario = Small();
      scenario.rules.patience_us = patience * kSecondUs;
      Flight flight(scenario);
      flight.Measure(kWorker).Judge(0, 0).Command(Sense());
      flight.Until(570).At(kWorker, {3000, 1000}, 600, 5000).Until(810 + patience / 30 * 30 - 30);
      EXPECT_EQ(flight.task(), TaskStatus::kReserved);
      if (restarts) flight.RestartWorld();
      flight.Until(840 + patience / 30 * 30);
      EXPECT_EQ(flight.happened(), (Happened{{Kind::kSensingAborted, 800 + patience}}));
      EXPECT_EQ(flight.events().at(0).detail, "before its start: worker:0 is late");
      EXPECT_EQ(flight.task(), TaskStatus::kOpen);
      EXPECT_EQ(flight.agent(kUav).busy_until_us, (800 + patience) * kSecondUs);
      EXPECT_EQ(flight.agent(kUav).to, (Point{3000, 4000}));
      const TimeUs told_s = (800 + patience + 29) / 30 * 30;  // it has gone on until then
      EXPECT_EQ(flight.agent(kWorker).busy_until_us, told_s * kSecondUs);
      EXPECT_LT(flight.agent(kWorker).to.y_m, 2000);
    }
  }
}

TEST(Measured, ATaskThatExpiresBeforeGoesFirst) {
  Scenario scenario = Small();
  scenario.tasks[0].expires_us = 1000 * kSecondUs;
  Flight flight(scenario);
  flight.Measure(kWorker).Judge(0, 0).Command(Sense()).Until(1500);
  EXPECT_EQ(flight.happened(),
            (Happened{{Kind::kSensingAborted, 1000}, {Kind::kTaskExpired, 1000}}));
  EXPECT_EQ(flight.task(), TaskStatus::kExpired);
}

TEST(Measured, WhoIsThereBeforeHeSaidHeWouldIsBelieved) {
  Flight flight(Small());
  flight.Measure(kWorker).Judge(0, 0).Command(Sense());
  flight.At(kWorker, WorkerAt(30, 4), 30, 1200).Until(870);
  EXPECT_EQ(flight.agent(kWorker).arrive_us, 1200 * kSecondUs);
  flight.Arrived(kWorker).Judge(900);
  EXPECT_EQ(flight.refusal(), "");
  EXPECT_EQ(flight.agent(kUav).activity->start_us, 900 * kSecondUs);
}

TEST(Measured, SensingEndsEarlyWhenAllWhoAreMeasuredSaySo) {
  Flight flight(Small());
  flight.Measure(kUav).Measure(kWorker).Judge(0, 0).Command(Sense());
  flight.Until(780).Arrived(kUav).Arrived(kWorker).Judge(810);
  flight.Done(kUav, 9000).Judge(840);
  EXPECT_EQ(flight.task(), TaskStatus::kSensing);
  flight.Judge(870).Done(kWorker).Judge(900);
  // The UAV came to be there at 810 at the latest, as it said; 1000 m are gone instead of 600.
  EXPECT_EQ(flight.happened(), (Happened{{Kind::kSensingStarted, 810}, {Kind::kSensingDone, 900}}));
  EXPECT_EQ(flight.agent(kUav).range_at_departure_m, 9000);
}

TEST(Measured, ChargingEndsWhenTheUavSaysSoWithTheRangeItHas) {
  // There at 100 s with 14 km; full after 120 s, at 220 s.
  Flight early(Small());
  early.Measure(kUav).Judge(0, 0).Command(Charge()).Until(90).Arrived(kUav).Judge(120).Judge(150);
  early.Done(kUav, 18'600).Judge(180);  // 80 s are 4 km
  EXPECT_NE(early.refusal().find("charged can be 18000 m"), std::string::npos) << early.refusal();
  early.Done(kUav).Judge(210);
  EXPECT_EQ(early.happened(),
            (Happened{{Kind::kChargingStarted, 100}, {Kind::kChargingDone, 210}}));
  EXPECT_DOUBLE_EQ(early.agent(kUav).range_at_departure_m, 14'000 + 110 * 50);

  // The slack is the way of a second, 10 m.
  for (const auto& [range_m, is_refused] : {std::pair(18'010, false), {18'011, true}}) {
    Flight slack(Small());
    slack.Measure(kUav).Judge(0, 0).Command(Charge()).Until(90).Arrived(kUav).Judge(120).Judge(150);
    slack.Done(kUav, range_m).Judge(180);
    EXPECT_EQ(!slack.refusal().empty(), is_refused) << range_m;
  }

  Flight late(Small());
  late.Measure(kUav).Judge(0, 0).Command(Charge()).Until(90).Arrived(kUav).Judge(120).Until(270);
  late.Done(kUav, 17'000).Judge(300);
  EXPECT_EQ(late.happened(), (Happened{{Kind::kChargingStarted, 100}, {Kind::kChargingDone, 300}}));
  EXPECT_EQ(late.agent(kUav).range_at_departure_m, 17'000);
  EXPECT_EQ(late.agent(kVehicle).busy_until_us, 300 * kSecondUs);

  Flight full(Small());
  full.Measure(kUav).Judge(0, 0).Command(Charge()).Until(90).Arrived(kUav).Judge(120).Until(270);
  full.Done(kUav, 20'000).Judge(300);
  EXPECT_EQ(full.refusal(), "");
  EXPECT_EQ(full.agent(kUav).range_at_departure_m, 20'000);
}

TEST(Measured, TheWayThatASilentOneWasComputedToMakeTakesNoRange) {
  Flight flight(Small());
  flight.Measure(kUav).Judge(0, 0).Command(Sense());
  // Computed to be nearly there after 300 s, it is 100 m from where it set out.
  flight.At(kUav, {30, 40}, 30, 1000).Until(300).At(kUav, {60, 80}, 330, 1200).Judge(330);
  const AgentState& uav = flight.agent(kUav);
  EXPECT_DOUBLE_EQ(RangeAt(uav, 330 * kSecondUs, flight.scenario().tasks), 15'000 - 100);
  flight.Until(1170).Arrived(kUav).Judge(1200);
  EXPECT_NEAR(RangeAt(uav, uav.arrive_us, flight.scenario().tasks), 15'000 - 5000, 1e-6);
  flight.Judge(1230).Done(kUav, 9900).Judge(1260);
  EXPECT_EQ(flight.refusal(), "");
  EXPECT_EQ(flight.task(), TaskStatus::kDone);
  EXPECT_DOUBLE_EQ(uav.range_at_departure_m, 9900);
}

TEST(Measured, WhoTakesOffLosesNoRangeForTheWayThatItIsComputedToMakeMeanwhile) {
  Flight flight(Small());
  flight.Measure(kUav).Judge(0, 0).Command(Sense());
  // At each tick it is computed to be 10 m on its way: as long as nothing more is heard, that is as
  // good as where it is.
  for (TimeUs t = 30; t <= 300; t += 30) {
    if (t > 30) flight.At(kUav, {0, 0}, t - 30, t + 469);
    flight.At(kUav, {0, 0}, t - 1, t + 499).Judge(t);
    ASSERT_EQ(flight.refusal(), "");
    EXPECT_GE(RangeAt(flight.agent(kUav), t * kSecondUs, flight.scenario().tasks), 15'000 - 10);
  }
  // It flies, and says what it has.
  flight.At(kUav, {300, 400}, 359, 810, 14'500).Judge(360);
  EXPECT_EQ(flight.refusal(), "");
  EXPECT_NEAR(RangeAt(flight.agent(kUav), 360 * kSecondUs, flight.scenario().tasks), 14'490, 1);
}

TEST(Measured, ASilentOneThatIsOverdueIsNotBehindThePlaceThatItToldLast) {
  Flight flight(Small());
  flight.Measure(kUav).Judge(0, 0).Command(Sense()).Until(450);
  // As computed, 200 m before its task. It is to be there at 500 s, and says nothing at 510 s.
  flight.At(kUav, {2880, 3840}, 480).Judge(480).Judge(510);
  const AgentState& uav = flight.agent(kUav);
  EXPECT_NEAR(Distance(PositionAt(uav, 510 * kSecondUs), {0, 0}), 4900, 1e-6);
  EXPECT_NEAR(RangeAt(uav, 510 * kSecondUs, flight.scenario().tasks), 15'000 - 4900, 1e-6);
  flight.Judge(540);
  EXPECT_GT(Distance(PositionAt(uav, 540 * kSecondUs), {0, 0}), 4900);
}

TEST(Measured, SensingBringsNoRangeBackThatTheWindWasComputedToTake) {
  Scenario scenario = Small();
  scenario.disturbances.wind = {1, 1};  // a metre takes two
  Flight flight(scenario);
  flight.Measure(kUav).Judge(0, 0).Command(Sense()).Until(480).Arrived(kUav).Judge(510);
  const AgentState& uav = flight.agent(kUav);
  EXPECT_DOUBLE_EQ(RangeAt(uav, uav.arrive_us, flight.scenario().tasks), 5000);
  flight.Until(840).Done(kUav, 9000).Judge(870);
  EXPECT_EQ(flight.refusal(), "");
  EXPECT_EQ(flight.task(), TaskStatus::kDone);
  EXPECT_DOUBLE_EQ(uav.range_at_departure_m, 5000);
}

TEST(Measured, AComputedPartnerWaitsThoughSensingIsShorterThanTheDelay) {
  Scenario scenario = Small();
  scenario.tasks[0].cost_m = 100;  // 10 s
  Flight flight(scenario);
  flight.Measure(kWorker).Judge(0, 0).Command(Sense()).Until(780);
  flight.At(kWorker, {3000, 3990}, 808, 810).Arrived(kWorker).Judge(810);
  EXPECT_EQ(flight.agent(kUav).activity->start_us, 810 * kSecondUs);
  EXPECT_FALSE(flight.agent(kUav).idle(810 * kSecondUs));
  flight.Done(kWorker).Judge(840);
  EXPECT_DOUBLE_EQ(flight.agent(kUav).range_at_departure_m, 15'000 - 5000 - 100);
  EXPECT_EQ(flight.happened(), (Happened{{Kind::kSensingStarted, 810}, {Kind::kSensingDone, 820}}));
}

TEST(Measured, ItsOwnFailureAndItsPartnersEndWhatIsUnderWay) {
  Flight fails(Small());
  fails.Measure(kWorker).Judge(0, 0).Command(Sense()).Until(810);
  fails.Tell({.agent_kind = kWorker, .kind = Report::kFailed, .reason = "a flat tyre"}).Judge(840);
  EXPECT_EQ(fails.happened(), (Happened{{Kind::kAgentFailed, 840}, {Kind::kSensingAborted, 840}}));
  EXPECT_EQ(fails.events().at(0).detail, "a flat tyre");
  fails.Arrived(kWorker).Judge(870);
  EXPECT_EQ(fails.refusal(), "it has failed");
  EXPECT_TRUE(fails.agent(kUav).idle(870 * kSecondUs));

  // Told of a time after its partner's failure: it is free when it hears, where it is then.
  Flight partner(Small());
  partner.Measure(kWorker).Judge(0, 0).Command(Sense()).Until(600);
  partner.FailUav(610).At(kWorker, {3000, 2600}, 625, 1000).Judge(630);
  EXPECT_EQ(partner.agent(kWorker).busy_until_us, 630 * kSecondUs);
  EXPECT_NEAR(partner.agent(kWorker).to.y_m, 2600 + 1400 * (5.0 / 375), 1e-9);
}

TEST(Measured, AFreeOneStandsWhereItSaysItIs) {
  Flight flight(Small());
  flight.Measure(kUav).Judge(0).At(kUav, {5, 5}, 30).Judge(30);
  EXPECT_EQ(flight.agent(kUav).to, (Point{0, 0}));  // within the slack
  flight.At(kUav, {180, 240}, 60).Judge(60);
  EXPECT_EQ(flight.agent(kUav).to, (Point{180, 240}));
  EXPECT_DOUBLE_EQ(flight.agent(kUav).range_at_departure_m, 14'700);
  flight.At(kUav, {180, 240}, 90, {}, 14'000).Judge(90);
  EXPECT_EQ(flight.agent(kUav).range_at_departure_m, 14'000);
  flight.At(kUav, {180, 240}, 120, {}, 14'500).Judge(120);
  EXPECT_NE(flight.refusal().find("at most 14000 m"), std::string::npos) << flight.refusal();
}

TEST(Measured, WhoWasSilentIsBelievedWhereItTrulyWas) {
  // Computed to be near the task when its partner failed; truly not half way.
  Flight flight(Small());
  flight.Measure(kWorker).Judge(0, 0).Command(Sense()).Until(780).FailUav(785).Judge(810);
  EXPECT_GT(flight.agent(kWorker).to.y_m, 3700);
  flight.At(kWorker, {3000, 1500}, 815).Judge(840);
  EXPECT_EQ(flight.refusal(), "");
  EXPECT_EQ(flight.agent(kWorker).to, (Point{3000, 1500}));
}

TEST(Measured, OneWhoMovesAloneIsBusyUntilHeSaysHeIsThere) {
  Flight flight(Small());
  Action go;
  go.kind = ActionKind::kGoTo;
  go.uav = UavId(0);
  go.to = {1000, 0};
  flight.Measure(kUav).Judge(0, 0).Command(go).Judge(30).Judge(60).Judge(90).Judge(120);
  EXPECT_FALSE(flight.agent(kUav).idle(120 * kSecondUs));
  EXPECT_EQ(StatusAt(flight.agent(kUav), 120 * kSecondUs), AgentStatus::kMoving);
  flight.Arrived(kUav).Judge(150);
  EXPECT_TRUE(flight.agent(kUav).idle(150 * kSecondUs));
  EXPECT_EQ(flight.agent(kUav).arrive_us, 150 * kSecondUs);
}

TEST(Measured, WhatCannotBeIsRefusedAndChangesNothing) {
  const auto refusal = [](auto tell) {
    Flight flight(Small());
    flight.Measure(kUav).Judge(0, 0).Command(Sense()).Until(270);
    tell(flight);
    flight.Judge(300);
    return flight.refusal();
  };
  using F = Flight&;
  // 300 s at 10 m/s are 3 km, of 15 km of range 12 km are left.
  EXPECT_EQ(refusal([](F f) { f.At(kUav, {1806, 2408}, 300); }), "");
  EXPECT_EQ(refusal([](F f) {
              f.At(kUav, {1860, 2480}, 300);
            }),
            "3100 m in 300 s are faster than its 10 m/s");
  EXPECT_EQ(refusal([](F f) {
              f.At(kUav, {1800, 2400}, 300, 490);
            }),
            "expects to arrive at 490 s, at 10 m/s not before 500 s");
  EXPECT_EQ(refusal([](F f) {
              f.At(kUav, {1800, 2400}, 300, 4'000'000'000);
            }),
            "expects to arrive in more than a hundred years");
  EXPECT_EQ(refusal([](F f) { f.At(kUav, {1800, 2400}, 300, {}, 12'005); }), "");
  EXPECT_EQ(refusal([](F f) {
              f.At(kUav, {1800, 2400}, 300, {}, 12'050);
            }),
            "a range of 12050 m, at most 12000 m can be left");
  EXPECT_EQ(refusal([](F f) { f.At(kUav, {1800, 2400}, 300, {}, -1); }), "a range of -1 m");
  EXPECT_EQ(refusal([](F f) { f.At(kUav, {std::nan(""), 0}, 300); }), "no place");
  EXPECT_EQ(refusal([](F f) {
              f.At(kUav, {0, 0}, 301);
            }),
            "a report about 301.0 s, which comes at 300.0 s");
  EXPECT_EQ(refusal([](F f) {
              f.At(kUav, {0, 0}, -1);
            }),
            "a report about -1.0 s, older than what is known");
  EXPECT_EQ(refusal([](F f) { f.Arrived(kUav); }), "5000 m in 300 s are faster than its 10 m/s");
  EXPECT_EQ(refusal([](F f) { f.Done(kUav); }), "neither sensing nor charging has begun");
  EXPECT_EQ(refusal([](F f) { f.Arrived(kWorker); }), "it is computed, not measured");
  EXPECT_EQ(refusal([](F f) { f.Measure(kVehicle).Arrived(kVehicle); }),
            "it has not been sent anywhere");
  EXPECT_EQ(refusal([](F f) {
              f.Measure(kWorker).At(kWorker, {3000, 1500}, 300, {}, 5);
            }),
            "only a UAV has a range");
  EXPECT_EQ(refusal([](F f) { f.Tell({.kind = Report::kArrived, .decision = 7}); }),
            "of the command of decision 7, under way is that of 0");
}

TEST(Measured, SmallErrorsDoNotAddUp) {
  // 10.3 m/s: each tick's way passes, but not all of them together.
  Flight flight(Small());
  flight.Measure(kUav).Judge(0, 0).Command(Sense());
  TimeUs refused_at = 0;
  for (TimeUs t = 30; t <= 300 && refused_at == 0; t += 30) {
    const double way = 10.3 * static_cast<double>(t);
    flight.At(kUav, {0.6 * way, 0.8 * way}, t).Judge(t);
    if (!flight.refusal().empty()) refused_at = t;
  }
  EXPECT_EQ(refused_at, 60);  // 18 m too far, 10 m are the slack
}

TEST(Measured, WhateverIsToldAllComeToTheSameState) {
  constexpr AgentKind kKinds[] = {kUav, kWorker, kVehicle};
  int refused = 0, taken = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed, Stream::kPolicy);
    const auto below = [&](int n) { return static_cast<int>(random.Uniform() * n); };
    Flight flight(Small());
    for (const AgentKind kind : kKinds) {
      if (below(3) > 0) flight.Measure(kind);
    }
    flight.Judge(0, 0);
    for (TimeUs t = 30; t <= 2400; t += 30) {
      if (t % 600 == 30) {
        const Action action = below(2) == 0 ? Sense() : Charge();
        const auto partner = action.kind == ActionKind::kSense ? kWorker : kVehicle;
        const TimeUs now = (t - 30) * kSecondUs;
        if (flight.agent(kUav).idle(now) && flight.agent(partner).idle(now) &&
            (action.kind == ActionKind::kCharge || flight.task() == TaskStatus::kOpen)) {
          flight.Command(action);
        }
      }
      const AgentKind kind = kKinds[below(3)];
      const AgentState& known = flight.agent(kind);
      switch (below(8)) {
        case 0:
        case 1:
          flight.Arrived(kind);
          break;
        case 2:
        case 3:
          flight.Done(kind, below(2) == 0 ? std::optional(random.Uniform() * 20e3) : std::nullopt);
          break;
        case 4: {
          const double speed = known.speed_m_s * random.Uniform() * 1.2;
          const Point at = Lerp(known.from, known.to, random.Uniform());
          flight.At(kind, {at.x_m + speed, at.y_m - speed}, t - below(40),
                    below(2) == 0 ? std::optional(t + below(900)) : std::nullopt,
                    kind == kUav ? std::optional(known.range_at_departure_m * random.Uniform())
                                 : std::nullopt);
          break;
        }
        default:
          break;
      }
      if (seed % 7 == 0 && below(10) == 0) flight.RestartWorld();
      flight.Judge(t, t % 600 == 0 ? static_cast<std::int32_t>(t / 600) : -1);
      ++(flight.refusal().empty() ? taken : refused);
      const Scenario& scenario = flight.scenario();
      const double range = RangeAt(flight.agent(kUav), t * kSecondUs, scenario.tasks);
      EXPECT_GE(range, 0);
      EXPECT_LE(range, 20'010);
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(taken, 1000);
}

}  // namespace
}  // namespace muster::world
