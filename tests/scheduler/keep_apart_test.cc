// Decisions that keep UAVs apart.
#include "scheduler/separation/keep_apart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "model/order.h"
#include "model/separation.h"
#include "scheduler/checker.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::SituationBuilder;

void UseSeparation(SituationBuilder* builder, Separation minima = {}) {
  ScenarioAir air;
  air.separation = minima;
  UseAir(std::move(air), &builder->scenario());
}

Action ToTask(const Situation& s, std::size_t uav, int task) {
  return MakeAction(*s.site, &s.uavs[uav], nullptr, TaskId(task), ChargeId());
}

Decision Apart(const Situation& s, std::vector<Action> actions) {
  return KeepApart(s, MakeDecision(std::move(actions), 10));
}

const Clearance& Of(const Decision& decision, int uav) {
  return *std::find_if(decision.clearances.begin(), decision.clearances.end(),
                       [&](const Clearance& c) { return c.uav == uav; });
}

TEST(KeepApart, LeavesADecisionAsItIsWithoutSeparation) {
  SituationBuilder builder;
  builder.Uav({0, 0}).Task({1000, 0}).Charge({0, 0});
  const Situation s = builder.Build();
  EXPECT_TRUE(Apart(s, {ToTask(s, 0, 0)}).clearances.empty());
}

TEST(KeepApart, GivesTheLowestAltitudeOfEachDirection) {
  SituationBuilder builder;
  builder.Uav({0, 1000})
      .Uav({9000, 1000})
      .Uav({0, 5000})
      .Task({9000, 1000})
      .Task({0, 1000})
      .Task({9000, 5000});
  builder.Charge({15e3, 15e3});
  UseSeparation(&builder);
  const Situation s = builder.Build();
  const Decision d = Apart(s, {ToTask(s, 0, 0), ToTask(s, 1, 1), ToTask(s, 2, 2)});
  EXPECT_EQ(d.actions.size(), 3u);
  EXPECT_EQ(Of(d, 0), (Clearance{0, 0, 0, 30, 0}));  // to the east
  EXPECT_EQ(Of(d, 1), (Clearance{1, 0, 0, 40, 0}));  // to the west
  EXPECT_EQ(Of(d, 2), (Clearance{2, 0, 0, 30, 0}));  // meets nobody
}

TEST(KeepApart, OneOfTwoThatRiseFromOnePlaceWaits) {
  SituationBuilder builder;
  builder.Uav({5000, 5000}).Uav({5000, 5000}).Task({9000, 5000}).Task({9000, 5200});
  builder.Charge({5000, 5000}, 2);
  UseSeparation(&builder);
  const Situation s = builder.Build();
  const Decision d = Apart(s, {ToTask(s, 0, 0), ToTask(s, 1, 1)});
  EXPECT_EQ(Of(d, 0).begin_us, 0);
  // Both fly at 10 m/s: 5 s later it is 50 m behind, which is enough.
  EXPECT_EQ(Of(d, 1).begin_us, 5 * kSecondUs);
  EXPECT_TRUE(d.withheld.empty());
}

TEST(KeepApart, LeavesOutWhatFindsNoAltitude) {
  // One layer, and a UAV that hovers in the middle of the only way.
  SituationBuilder builder;
  builder.Uav({5000, 5000})
      .Uav({0, 5000})
      .Worker({9000, 5000})
      .Task({9000, 5000})
      .Charge({20e3, 20e3});
  UseSeparation(&builder, {50, 10, 30, 30});
  Situation s = builder.Build();
  s.clearances = {{0, 0, 30, 30, 0}};
  s.decision = 1;
  s.now_us = s.site->rules.interval_us;
  const Action sense = MakeAction(*s.site, &s.uavs[1], s.workers.data(), TaskId(0), ChargeId());
  const Decision d = Apart(s, {sense});
  EXPECT_TRUE(d.actions.empty());
  EXPECT_EQ(d.weight, 0);
  ASSERT_EQ(d.withheld.size(), 1u);
  EXPECT_EQ(d.withheld[0], sense);
  ASSERT_EQ(d.clearances.size(), 1u) << "it has never left the ground";
}

TEST(KeepApart, DoesNotWaitTooLong) {
  SituationBuilder builder;
  builder.Uav({5000, 5000}).Uav({5000, 5000}).Task({9000, 5000}).Task({9000, 5200});
  builder.Charge({5000, 5000}, 2);
  // 4004.997 m at 10 m/s: there after 400.5 s. Sensing must begin by 402 s, so it cannot wait 5 s.
  builder.scenario().tasks[1].expires_us = 402 * kSecondUs;
  UseSeparation(&builder);
  const Situation s = builder.Build();
  EXPECT_EQ(Apart(s, {ToTask(s, 0, 0), ToTask(s, 1, 1)}).withheld.size(), 1u);
}

TEST(KeepApart, OneThatHoversMakesWay) {
  // It hovers where another one, sent before, has yet to pass at the same altitude: something that
  // no decision has planned.
  SituationBuilder builder;
  builder.Uav({5000, 5000}).Uav({0, 5000}).Task({9000, 5000}).Charge({20e3, 20e3});
  UseSeparation(&builder);
  Situation s = builder.Build();
  AgentState& passes = s.uavs[1];
  passes.to = {9000, 5000};
  passes.arrive_us = passes.busy_until_us = 900 * kSecondUs;
  passes.action = ActionKind::kUavToTask;
  passes.target = 0;
  s.decision = 1;
  s.now_us = 10 * kSecondUs;
  s.clearances = {{0, 0, 30, 30, 0}, {1, 0, 30, 30, 0}};
  const Decision d = Apart(s, {});
  EXPECT_EQ(Of(d, 0), (Clearance{0, 1, 30, 40, s.now_us}));
  EXPECT_EQ(Of(d, 1), s.clearances[1]);
}

TEST(KeepApart, OneThatHoversInANewZoneLeavesIt) {
  SituationBuilder builder;
  // In the zone, on the ground in it, too short of range in its midst, and outside.
  builder.Uav({5100, 5000}).Uav({5200, 5000}).Uav({5500, 5500}, 300).Uav({9000, 9000});
  builder.Charge({20e3, 20e3});
  ScenarioAir air;
  air.margin_m = 30;
  air.separation = Separation();
  UseAir(std::move(air), &builder.scenario());
  Order order = ParseOrder(
      R"({"order": "zone_add", "area_km": [[5, 4.5], [6, 4.5], [6, 6.5], [5, 6.5]]})", "order");
  TakeInto(&builder.scenario(), order, 0);
  Situation s = builder.Build();
  s.decision = 1;
  s.now_us = 600 * kSecondUs;
  s.clearances = {{0, 0, 30, 30, 0}, {2, 0, 30, 50, 0}, {3, 0, 30, 30, 0}};
  // Whether the policy says nothing of it, or says that it stays.
  Action stays = MakeStay(*s.site, s.uavs[0]);
  stays.weight = 0.7;
  for (const std::vector<Action>& actions : {std::vector<Action>(), {stays}}) {
    const Decision d = Apart(s, actions);
    ASSERT_EQ(d.actions.size(), 1u);
    EXPECT_EQ(d.actions[0].kind, ActionKind::kGoTo);
    EXPECT_EQ(d.actions[0].uav.value, 0);
    EXPECT_EQ(d.actions[0].to, (Point{4900, 5000}));  // 4,970 is the margin's edge
    EXPECT_EQ(d.weight, 0);
    EXPECT_EQ(Of(d, 0).decision, 1);
    EXPECT_TRUE(CheckActions(s, d.actions).empty());
  }
}

/// From 4 to 5 km, beginning so high above the ground.
void UseHighZone(SituationBuilder* builder, double lower_m, TimeUs until_us = kNever) {
  ScenarioAir air;
  PlannedZone& zone = air.zones.emplace_back();
  zone.zone.rings = {{{4000, 4000}, {5000, 4000}, {5000, 6000}, {4000, 6000}}};
  zone.lower_m = lower_m;
  zone.until_us = until_us;
  UseAir(std::move(air), &builder->scenario());
}

TEST(KeepApart, FliesBelowAZoneThatBeginsHighAboveTheGround) {
  // Three UAVs hover on the way, at 30, 40 and 50 m.
  const auto decide = [](double lower_m, TimeUs until_us) {
    SituationBuilder builder;
    builder.Uav({0, 5000}).Uav({3000, 5000}).Uav({3200, 5000}).Uav({3400, 5000});
    builder.Task({9000, 5000}).Charge({20e3, 20e3});
    UseHighZone(&builder, lower_m, until_us);
    Situation s = builder.Build();
    s.decision = 1;
    s.now_us = 600 * kSecondUs;
    s.clearances = {{1, 0, 30, 30, 0}, {2, 0, 40, 40, 0}, {3, 0, 50, 50, 0}};
    return Apart(s, {ToTask(s, 0, 0)});
  };
  EXPECT_EQ(Of(decide(80, kNever), 0).to_m, 70);
  EXPECT_EQ(Of(decide(70, kNever), 0).to_m, 60);
  EXPECT_EQ(decide(60, kNever).withheld.size(), 1u);
  EXPECT_EQ(Of(decide(60, 600 * kSecondUs), 0).to_m, 70) << "it holds no longer";
}

TEST(KeepApart, OneThatIsTooHighForAZoneOnItsWayGoesDownFirst) {
  SituationBuilder builder;
  builder.Uav({3900, 5000}).Task({4500, 5000}).Charge({20e3, 20e3});
  UseHighZone(&builder, 60);
  Situation s = builder.Build();
  s.decision = 1;
  s.now_us = 600 * kSecondUs;
  s.clearances = {{0, 0, 30, 110, 0}};
  const Decision first = Apart(s, {ToTask(s, 0, 0)});
  EXPECT_EQ(first.withheld.size(), 1u);
  EXPECT_EQ(Of(first, 0), (Clearance{0, 1, 110, 30, s.now_us}));
  s.decision = 2;
  s.now_us = 1200 * kSecondUs;
  s.clearances = first.clearances;
  const Decision second = Apart(s, {ToTask(s, 0, 0)});
  EXPECT_TRUE(second.withheld.empty());
  EXPECT_EQ(Of(second, 0), (Clearance{0, 2, 30, 30, s.now_us}));
}

/// Pairs of UAVs that come too close as planned.
int Conflicts(const Situation& s, const Decision& d) {
  const LandingPlaces landing(s.site->charging_points);
  std::vector<Trajectory> paths;
  for (const AgentState& uav : s.uavs) {
    const auto own = std::find_if(d.actions.begin(), d.actions.end(), [&](const Action& a) {
      return a.uav.value == uav.id && !IsStay(a.kind);
    });
    const auto found = std::find_if(d.clearances.begin(), d.clearances.end(),
                                    [&](const Clearance& c) { return c.uav == uav.id; });
    const Clearance clearance = found == d.clearances.end() ? Clearance{uav.id} : *found;
    AgentState goes = uav;
    if (own != d.actions.end()) {
      Begin(&goes, *own, s.decision, s.now_us, {}, 0, clearance.begin_us - s.now_us);
    }
    paths.push_back(TrajectoryOf(goes, clearance, s.now_us, landing));
  }
  int conflicts = 0;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      conflicts += AreInConflict(paths[i], paths[j], *s.site->separation) ? 1 : 0;
    }
  }
  return conflicts;
}

TEST(KeepApart, KeepsAHundredUavsApartBelow120Metres) {
  int together = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed, Stream::kTest, 36);
    const auto place = [&] {
      return Point{random.Below(12) * 500.0 + 3000, random.Below(12) * 500.0 + 3000};
    };
    SituationBuilder builder;
    for (int i = 0; i < 120; ++i) builder.Uav(place()).Task(place());
    for (int i = 0; i < 10; ++i) builder.Charge(place(), {});
    UseSeparation(&builder);
    const Situation s = builder.Build();
    std::vector<Action> actions;
    for (int i = 0; i < 120; ++i) {
      const auto u = static_cast<std::size_t>(i);
      actions.push_back(i % 4 > 0
                            ? ToTask(s, u, i)
                            : MakeAction(*s.site, &s.uavs[u], nullptr, TaskId(), ChargeId(i % 10)));
    }
    Decision at_one = MakeDecision(actions, 10);
    for (int i = 0; i < 120; ++i) at_one.clearances.push_back({i, 0, 0, 30, 0});
    together += Conflicts(s, at_one);
    const Decision d = Apart(s, actions);
    EXPECT_EQ(Conflicts(s, d), 0) << "seed " << seed;
    EXPECT_LE(d.withheld.size(), 12u) << "seed " << seed;
    for (const Clearance& c : d.clearances) EXPECT_LE(c.to_m, 120);
    EXPECT_TRUE(CheckActions(s, d.actions).empty()) << "seed " << seed;
  }
  EXPECT_GT(together, 800) << "without altitudes of their own";
}

}  // namespace
}  // namespace muster::scheduler
