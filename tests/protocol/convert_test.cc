#include "protocol/convert.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/model/block.h"
#include "tests/model/manhattan_ways.h"

namespace muster {
namespace {

Scenario TwoOfEach() {
  Scenario scenario;
  AgentSpec agent;
  agent.speed_m_s = 10;
  agent.range_full_m = agent.range_m = 20'000;
  agent.online_until_us = 3600 * kSecondUs;
  scenario.uavs = scenario.workers = {agent, agent};
  agent.charge_rate_m_s = 50;
  scenario.vehicles = {agent, agent};
  scenario.tasks = {{{3000, 4000}, 600}, {{100, 0}, 600}};
  scenario.charging_points = {{{0, 1000}, 1}, {{0, 2000}, 1}};
  return scenario;
}

AgentState MovingUav(const Scenario& scenario) {
  AgentState uav = StartOf(AgentKind::kUav, 1, scenario.uavs[1], *scenario.ways);
  Action action;
  action.kind = ActionKind::kSense;
  action.uav = UavId(1);
  action.worker = WorkerId(0);
  action.task = TaskId(0);
  action.to = scenario.tasks[0].at;
  Begin(&uav, action, 2, 100 * kSecondUs, scenario.disturbances, scenario.seed);
  return uav;
}

TEST(Convert, AnAgentUnderWayComesBackAsItWas) {
  const Scenario scenario = TwoOfEach();
  const WireLimits limits(scenario);
  const AgentState uav = MovingUav(scenario);
  for (const TimeUs t : {130 * kSecondUs, 600 * kSecondUs, 900 * kSecondUs}) {
    const auto back = FromWire(ToWire(uav, t, scenario.tasks), AgentKind::kUav, t, limits);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->to, uav.to);
    EXPECT_EQ(PositionAt(*back, 450 * kSecondUs), PositionAt(uav, 450 * kSecondUs));
    EXPECT_EQ(RangeAt(*back, t, scenario.tasks), RangeAt(uav, t, scenario.tasks));
    EXPECT_EQ(back->busy_until_us, kNever);
    EXPECT_EQ(back->partner, 0);
  }
}

TEST(Convert, AFreeMoveUnderWayIsExtrapolated) {
  const Scenario scenario = TwoOfEach();
  AgentState uav = StartOf(AgentKind::kUav, 0, scenario.uavs[0], *scenario.ways);
  Action action;
  action.kind = ActionKind::kGoTo;
  action.uav = UavId(0);
  action.to = {600, 800};
  Begin(&uav, action, 0, 0, {}, 1);
  const auto back = FromWire(ToWire(uav, 30 * kSecondUs, scenario.tasks), AgentKind::kUav,
                             30 * kSecondUs, WireLimits(scenario));
  ASSERT_TRUE(back);
  EXPECT_NEAR(Distance(back->to, action.to), 0, 1e-6);
}

TEST(Convert, AFreeMoveOnABentWayComesBackWithItsGoalAndTheRestOfItsWay) {
  const testing::InManhattan scope;
  const Scenario scenario = TwoOfEach();
  AgentState uav = StartOf(AgentKind::kUav, 0, scenario.uavs[0], *scenario.ways);
  const Point start = uav.to;
  Action action;
  action.kind = ActionKind::kGoTo;
  action.uav = UavId(0);
  action.to = {start.x_m + 600, start.y_m + 800};
  Begin(&uav, action, 0, 0, {}, 1);
  for (const double share : {0.1, 0.4, 0.5, 0.99}) {
    const auto t = static_cast<TimeUs>(share * static_cast<double>(uav.arrive_us));
    const agent_t wire = ToWire(uav, t, scenario.tasks);
    EXPECT_EQ(wire.depart_us, uav.depart_us);
    EXPECT_EQ(wire.range_at_departure_m, uav.range_at_departure_m);
    const auto back = FromWire(wire, AgentKind::kUav, t, WireLimits(scenario));
    ASSERT_TRUE(back);
    EXPECT_NEAR(Distance(back->to, action.to), 0, 1e-6);
    EXPECT_EQ(back->arrive_us, uav.arrive_us);
    for (const TimeUs later : {t, (t + uav.arrive_us) / 2, uav.arrive_us}) {
      EXPECT_NEAR(Distance(PositionAt(*back, later), PositionAt(uav, later)), 0, 1e-6) << later;
      EXPECT_NEAR(RangeAt(*back, later, {}), RangeAt(uav, later, {}), 1e-6) << later;
    }
  }
}

TEST(Convert, AFreeMoveToANumberedPlaceComesBackWithItsOrigin) {
  Scenario scenario = testing::OnTheBlock();
  scenario.workers[0].online_until_us = 3600 * kSecondUs;
  AgentState worker = StartOf(AgentKind::kWorker, 0, scenario.workers[0], *scenario.ways);
  Action action;
  action.kind = ActionKind::kGoTo;
  action.worker = WorkerId(0);
  action.to = scenario.tasks[0].at;
  Begin(&worker, action, 0, 0, {}, 1);
  ASSERT_EQ(worker.target, 0) << "the first of the places that have a number";
  const TimeUs t = worker.arrive_us / 3;
  const auto back =
      FromWire(ToWire(worker, t, scenario.tasks), AgentKind::kWorker, t, WireLimits(scenario));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->from, worker.from);
  EXPECT_EQ(back->depart_us, worker.depart_us);
  EXPECT_EQ(back->to, worker.to);
}

TEST(Convert, ImpossibleReportsAreRefused) {
  const Scenario scenario = TwoOfEach();
  const WireLimits limits(scenario);
  const TimeUs t = 200 * kSecondUs;
  const agent_t good = ToWire(MovingUav(scenario), t, scenario.tasks);
  ASSERT_TRUE(FromWire(good, AgentKind::kUav, t, limits));
  const std::vector<std::function<void(agent_t*)>> lies = {
      [](agent_t* a) { a->id = 2; },
      [](agent_t* a) { a->id = -1; },
      [](agent_t* a) { a->action = 42; },
      [](agent_t* a) { a->target_id = 2; },
      [](agent_t* a) { a->partner_id = -1; },
      [](agent_t* a) { a->depart_us = 201 * kSecondUs; },
      [](agent_t* a) { a->arrive_us = a->depart_us - 1; },
      [](agent_t* a) { a->speed_m_s = std::numeric_limits<double>::quiet_NaN(); },
      [](agent_t* a) { a->speed_m_s = 0; },
      [](agent_t* a) { a->speed_m_s = 1e-300; },
      [](agent_t* a) { a->speed_m_s = 1e300; },
      [](agent_t* a) { a->range_left_m = -1; },
      [](agent_t* a) { a->range_left_m = 1e300; },
      [](agent_t* a) { a->range_full_m = 1e300; },
      [](agent_t* a) { a->range_at_departure_m = 1e300; },
      [](agent_t* a) { a->range_at_departure_m = std::numeric_limits<double>::quiet_NaN(); },
  };
  for (std::size_t i = 0; i < lies.size(); ++i) {
    agent_t bad = good;
    lies[i](&bad);
    EXPECT_FALSE(FromWire(bad, AgentKind::kUav, t, limits)) << "lie " << i;
  }
  EXPECT_FALSE(FromWire(good, AgentKind::kVehicle, t, limits));
  agent_t vehicle =
      ToWire(StartOf(AgentKind::kVehicle, 1, scenario.vehicles[1], *scenario.ways), t, {});
  EXPECT_TRUE(FromWire(vehicle, AgentKind::kVehicle, t, limits));
  vehicle.charge_rate_m_s = 0;
  EXPECT_FALSE(FromWire(vehicle, AgentKind::kVehicle, t, limits));
}

TEST(Convert, ActionsActivitiesAndRulingsRoundTrip) {
  const Scenario scenario = TwoOfEach();
  const WireLimits limits(scenario);
  Action action;
  action.kind = ActionKind::kCharge;
  action.uav = UavId(1);
  action.vehicle = VehicleId(0);
  action.charge = ChargeId(1);
  action.to = {0, 2000};
  action.weight = 12.5;
  EXPECT_EQ(FromWire(ToWire(action), limits), action);
  action_t foreign = ToWire(action);
  foreign.charge_id = 2;
  EXPECT_FALSE(FromWire(foreign, limits));
  action_t other_kind = ToWire(action);
  other_kind.kind = NumberOf(ActionKind::kVehicleToCharge);
  EXPECT_FALSE(FromWire(other_kind, limits)) << "a UAV drives to no charging point";
  action_t without = ToWire(action);
  without.vehicle_id = -1;
  EXPECT_FALSE(FromWire(without, limits));

  const Activity activity{Activity::Kind::kCharging, UavId(0), 1, 1, 5, 9};
  EXPECT_EQ(FromWire(ToWire(activity), limits), activity);
  activity_t backwards = ToWire(activity);
  backwards.end_us = 4;
  EXPECT_FALSE(FromWire(backwards, limits));

  const Ruling ruling{AgentKind::kVehicle, 1, Ruling::Kind::kReleased, 77};
  EXPECT_EQ(FromWire(ToWire(ruling), limits), ruling);
  ruling_t unknown = ToWire(ruling);
  unknown.kind = 3;
  EXPECT_FALSE(FromWire(unknown, limits));
}

/// A report of an agent of that class with that action under way, all ids the highest there are.
agent_t Report(const Scenario& scenario, AgentKind kind, ActionKind action, std::int32_t target,
               std::int32_t partner) {
  AgentState agent = StartOf(kind, 1, scenario.agents(kind)[1], *scenario.ways);
  agent.depart_us = 100 * kSecondUs;
  agent.arrive_us = agent.busy_until_us = 200 * kSecondUs;
  agent.action = action;
  agent.target = target;
  agent.partner = partner;
  return ToWire(agent, 150 * kSecondUs, scenario.tasks);
}

TEST(Convert, AnActionNeedsItsClassItsTargetAndItsPartner) {
  // Different numbers of everything, so that no list stands for another.
  Scenario scenario = TwoOfEach();
  scenario.workers.resize(3, scenario.workers[0]);
  scenario.vehicles.resize(4, scenario.vehicles[0]);
  scenario.tasks.resize(5, scenario.tasks[0]);
  scenario.charging_points.resize(6, scenario.charging_points[0]);
  const WireLimits limits(scenario);
  const std::int32_t none = -1;
  struct Row {
    ActionKind action;
    std::int32_t targets;      ///< how many there are; -1: any number will do
    std::int32_t partners[3];  ///< by class, how many there are; -1: any number, 0: not its action
  };
  const Row rows[] = {
      {ActionKind::kNone, none, {none, none, none}},
      {ActionKind::kGoTo, none, {none, none, none}},
      {ActionKind::kUavStays, none, {0, 0, 0}},
      {ActionKind::kWorkerStays, none, {0, 0, 0}},
      {ActionKind::kVehicleStays, none, {0, 0, 0}},
      {ActionKind::kUavToTask, 5, {none, 0, 0}},
      {ActionKind::kWorkerToTask, 5, {0, none, 0}},
      {ActionKind::kUavToCharge, 6, {none, 0, 0}},
      {ActionKind::kVehicleToCharge, 6, {0, 0, none}},
      {ActionKind::kSense, 5, {3, 2, 0}},
      {ActionKind::kCharge, 6, {4, 0, 2}},
  };
  for (const Row& row : rows) {
    for (const AgentKind kind : kAgentKinds) {
      const std::int32_t partners = row.partners[static_cast<std::size_t>(kind)];
      const auto taken = [&](std::int32_t target, std::int32_t partner) {
        return FromWire(Report(scenario, kind, row.action, target, partner), kind, 150 * kSecondUs,
                        limits)
            .has_value();
      };
      const std::int32_t last = row.targets == none ? 99 : row.targets - 1;
      const std::int32_t mate = partners == none ? 99 : std::max(partners - 1, 0);
      const std::string what = std::string(ToString(row.action)) + std::string(ToString(kind));
      EXPECT_EQ(taken(last, mate), partners != 0) << what;
      EXPECT_EQ(taken(0, 0), partners != 0) << what;
      EXPECT_EQ(taken(last + 1, mate), partners != 0 && row.targets == none) << what;
      EXPECT_EQ(taken(-1, mate), partners != 0 && row.targets == none) << what;
      EXPECT_EQ(taken(last, mate + 1), partners == none) << what;
      EXPECT_EQ(taken(last, -1), partners == none) << what;
    }
  }
}

TEST(Convert, ReportsAtTheEdgeOfThePossible) {
  const Scenario scenario = TwoOfEach();
  const WireLimits limits(scenario);
  const TimeUs t = 150 * kSecondUs;
  const agent_t good = Report(scenario, AgentKind::kUav, ActionKind::kUavToTask, 1, -1);
  const auto taken = [&](const std::function<void(agent_t*)>& edit) {
    agent_t edited = good;
    edit(&edited);
    return FromWire(edited, AgentKind::kUav, t, limits).has_value();
  };
  EXPECT_TRUE(taken([&](agent_t* a) { a->depart_us = t; }));
  EXPECT_FALSE(taken([&](agent_t* a) { a->depart_us = t + 1; }));
  EXPECT_TRUE(taken([](agent_t* a) { a->depart_us = 0; }));
  EXPECT_FALSE(taken([](agent_t* a) { a->depart_us = -1; }));
  EXPECT_TRUE(taken([](agent_t* a) { a->arrive_us = a->depart_us; }));
  EXPECT_FALSE(taken([](agent_t* a) { a->arrive_us = a->depart_us - 1; }));
  EXPECT_TRUE(taken([](agent_t* a) { a->range_left_m = 0; }));
  EXPECT_TRUE(taken([](agent_t* a) { a->range_at_departure_m = 0; }));
  EXPECT_FALSE(taken([](agent_t* a) { a->range_at_departure_m = -1; }));
  EXPECT_TRUE(taken([](agent_t* a) { a->id = 0; }));
}

TEST(Convert, ALegEndsAtItsPlaceOrWhereItIsExtrapolatedTo) {
  const Scenario scenario = TwoOfEach();
  const WireLimits limits(scenario);
  const auto to = [&](ActionKind action, std::int32_t target, TimeUs t) {
    agent_t wire = Report(scenario, AgentKind::kUav, action, target, 0);
    wire.from_x_m = 0;
    wire.from_y_m = 0;
    wire.x_m = 30;
    wire.y_m = 40;
    return FromWire(wire, AgentKind::kUav, t, limits)->to;
  };
  const TimeUs half = 150 * kSecondUs;
  EXPECT_EQ(to(ActionKind::kUavToTask, 1, half), scenario.tasks[1].at);
  EXPECT_EQ(to(ActionKind::kSense, 1, half), scenario.tasks[1].at);
  EXPECT_EQ(to(ActionKind::kUavToCharge, 1, half), scenario.charging_points[1].at);
  EXPECT_EQ(to(ActionKind::kCharge, 1, half), scenario.charging_points[1].at);
  EXPECT_EQ(to(ActionKind::kGoTo, -1, half), (Point{60, 80}));
  EXPECT_EQ(to(ActionKind::kGoTo, -1, 125 * kSecondUs), (Point{120, 160}));
  EXPECT_EQ(to(ActionKind::kGoTo, -1, 100 * kSecondUs), (Point{30, 40}));      // not gone yet
  EXPECT_EQ(to(ActionKind::kUavToTask, 1, 200 * kSecondUs), (Point{30, 40}));  // it is there
  EXPECT_EQ(to(ActionKind::kGoTo, -1, 200 * kSecondUs), (Point{30, 40}));
}

TEST(Convert, TheWindOnALegIsDrawnAgain) {
  Scenario scenario = TwoOfEach();
  scenario.disturbances.wind = {0.1, 0.4};
  const WireLimits limits(scenario);
  const auto per_metre = [&](AgentKind kind, ActionKind action) {
    agent_t wire = Report(scenario, kind, action, 1, 1);
    wire.decision = 3;
    return FromWire(wire, kind, 150 * kSecondUs, limits)->range_per_m;
  };
  EXPECT_EQ(per_metre(AgentKind::kUav, ActionKind::kSense),
            RangePerMetre(UavId(1), 3, scenario.disturbances, scenario.seed));
  EXPECT_EQ(per_metre(AgentKind::kUav, ActionKind::kNone), 1);
  EXPECT_EQ(per_metre(AgentKind::kWorker, ActionKind::kSense), 1);
}

TEST(Convert, FailureIsInTheStatus) {
  const Scenario scenario = TwoOfEach();
  const WireLimits limits(scenario);
  agent_t wire = Report(scenario, AgentKind::kUav, ActionKind::kNone, -1, -1);
  EXPECT_FALSE(FromWire(wire, AgentKind::kUav, 150 * kSecondUs, limits)->failed);
  wire.status = static_cast<std::int8_t>(AgentStatus::kFailed);
  EXPECT_TRUE(FromWire(wire, AgentKind::kUav, 150 * kSecondUs, limits)->failed);
}

TEST(Convert, EveryIdIsLookedAt) {
  Scenario scenario = TwoOfEach();
  scenario.workers.resize(3, scenario.workers[0]);
  scenario.vehicles.resize(4, scenario.vehicles[0]);
  scenario.tasks.resize(5, scenario.tasks[0]);
  scenario.charging_points.resize(6, scenario.charging_points[0]);
  const WireLimits limits(scenario);
  struct Row {
    std::int32_t action_t::*id;
    std::int32_t n;
    ActionKind kind;  ///< one that has that id
  };
  const Row rows[] = {{&action_t::uav_id, 2, ActionKind::kUavStays},
                      {&action_t::worker_id, 3, ActionKind::kWorkerStays},
                      {&action_t::vehicle_id, 4, ActionKind::kVehicleStays},
                      {&action_t::uav_id, 2, ActionKind::kGoTo},
                      {&action_t::worker_id, 3, ActionKind::kSense},
                      {&action_t::task_id, 5, ActionKind::kSense},
                      {&action_t::vehicle_id, 4, ActionKind::kCharge},
                      {&action_t::charge_id, 6, ActionKind::kCharge}};
  const auto of_kind = [](ActionKind kind) {
    Action action;
    action.kind = kind;
    const auto shape = ShapeOf(kind).value_or(ActionShape{.uav = true});
    if (shape.uav) action.uav = UavId(0);
    if (shape.worker) action.worker = WorkerId(0);
    if (shape.vehicle) action.vehicle = VehicleId(0);
    if (shape.task) action.task = TaskId(0);
    if (shape.charge) action.charge = ChargeId(0);
    return ToWire(action);
  };
  for (const auto& [id, n, kind] : rows) {
    action_t wire = of_kind(kind);
    for (const std::int32_t good : {0, n - 1}) {
      wire.*id = good;
      EXPECT_TRUE(FromWire(wire, limits)) << n << " of them, id " << good;
    }
    for (const std::int32_t bad : {-2, -1, n}) {
      wire.*id = bad;
      EXPECT_FALSE(FromWire(wire, limits)) << n << " of them, id " << bad;
    }
  }
  const action_t none = of_kind(ActionKind::kUavStays);
  action_t superfluous = none;
  superfluous.task_id = 0;
  EXPECT_FALSE(FromWire(superfluous, limits));
  for (const int kind : {-1, 10}) {
    action_t wire = none;
    wire.kind = static_cast<std::int8_t>(kind);
    EXPECT_FALSE(FromWire(wire, limits)) << kind;
  }
  for (double action_t::*const place : {&action_t::x_m, &action_t::y_m}) {
    action_t wire = none;
    wire.*place = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(FromWire(wire, limits));
  }

  for (const int kind : {0, 1}) {
    const std::int32_t partners = kind == 0 ? 3 : 4, sites = kind == 0 ? 5 : 6;
    const auto taken = [&](std::int32_t uav, std::int32_t partner, std::int32_t site) {
      activity_t wire{};
      wire.kind = static_cast<std::int8_t>(kind);
      wire.uav_id = uav;
      wire.partner_id = partner;
      wire.site_id = site;
      return FromWire(wire, limits).has_value();
    };
    EXPECT_TRUE(taken(0, 0, 0));
    EXPECT_TRUE(taken(1, partners - 1, sites - 1));
    EXPECT_FALSE(taken(2, 0, 0));
    EXPECT_FALSE(taken(-1, 0, 0));
    EXPECT_FALSE(taken(0, partners, 0));
    EXPECT_FALSE(taken(0, -1, 0));
    EXPECT_FALSE(taken(0, 0, sites));
    EXPECT_FALSE(taken(0, 0, -1));
  }
  activity_t early{};
  early.start_us = -1;
  EXPECT_FALSE(FromWire(early, limits));
  activity_t unknown{};
  unknown.kind = 2;
  EXPECT_FALSE(FromWire(unknown, limits));

  const auto ruled = [&](int agent_kind, std::int32_t id, int kind, TimeUs at_us) {
    ruling_t wire{};
    wire.agent_kind = static_cast<std::int8_t>(agent_kind);
    wire.agent_id = id;
    wire.kind = static_cast<std::int8_t>(kind);
    wire.at_us = at_us;
    return FromWire(wire, limits).has_value();
  };
  EXPECT_TRUE(ruled(0, 0, 0, 0));
  EXPECT_TRUE(ruled(2, 3, 1, 5));
  EXPECT_FALSE(ruled(2, 4, 1, 5));
  EXPECT_FALSE(ruled(3, 0, 0, 0));
  EXPECT_FALSE(ruled(-1, 0, 0, 0));
  EXPECT_FALSE(ruled(0, -1, 0, 0));
  EXPECT_FALSE(ruled(0, 0, -1, 0));
  EXPECT_TRUE(ruled(0, 0, 2, 0));
  EXPECT_FALSE(ruled(0, 0, 3, 0));
  EXPECT_FALSE(ruled(0, 0, 0, -1));
}

TEST(Convert, AClockIsOfItsMission) {
  Scenario scenario;
  Rules& rules = scenario.rules;
  rules.interval_us = 600 * kSecondUs;
  rules.limit_us = 1810 * kSecondUs;  // decisions 0 to 3; the last tick, 61, is a short one
  rules.tick_us = 30 * kSecondUs;
  const auto clock_of = [&](std::int64_t tick, std::int32_t required) {
    clock_t clock{};
    clock.tick = tick;
    clock.tick_us = rules.TimeOf(tick);
    clock.limit_us = rules.limit_us;
    clock.decision = rules.DecisionAt(tick);
    clock.required_decision = required;
    return clock;
  };
  EXPECT_TRUE(Possible(clock_of(0, -1), scenario));
  EXPECT_TRUE(Possible(clock_of(0, 0), scenario));
  EXPECT_FALSE(Possible(clock_of(0, 1), scenario));
  EXPECT_TRUE(Possible(clock_of(61, 3), scenario));
  EXPECT_FALSE(Possible(clock_of(61, 4), scenario));
  EXPECT_FALSE(Possible(clock_of(62, 3), scenario));
  EXPECT_FALSE(Possible(clock_of(-1, -1), scenario));
  for (std::int64_t clock_t::*const field : {&clock_t::tick_us, &clock_t::limit_us}) {
    clock_t other = clock_of(20, 0);
    ASSERT_TRUE(Possible(other, scenario));
    other.*field += 1;
    EXPECT_FALSE(Possible(other, scenario));
  }
  clock_t other = clock_of(20, 0);
  other.decision = -1;
  EXPECT_FALSE(Possible(other, scenario));

  // An order that is not known yet may ask for a decision, so any is possible that may be.
  other.required_decision = 0;
  scenario.rules.emergencies_at_once = true;
  ASSERT_TRUE(scenario.takes_orders());
  EXPECT_FALSE(Possible(other, scenario)) << "at a whole interval";
  other = clock_of(21, 0);
  for (const std::int32_t decision : {-1, 2, 21}) {
    other.decision = decision;
    EXPECT_TRUE(Possible(other, scenario)) << decision;
  }
  for (const std::int32_t decision : {0, 1, 22}) {
    other.decision = decision;
    EXPECT_FALSE(Possible(other, scenario)) << decision;
  }

  const auto world_of = [&](std::int64_t tick, TimeUs late_us) {
    world_state_t world{};
    world.tick = tick;
    world.header.sim_us = rules.TimeOf(tick) + late_us;
    return Possible(world, rules);
  };
  EXPECT_TRUE(world_of(0, 0));
  EXPECT_TRUE(world_of(61, 0));
  EXPECT_FALSE(world_of(62, 0));
  EXPECT_FALSE(world_of(-1, 0));
  EXPECT_FALSE(world_of(3, 1));
}

TEST(Convert, StatesAreSaidInPartsOf256) {
  for (const std::size_t n : {0, 1, 255, 256, 257, 512, 700}) {
    std::vector<agent_t> agents(n);
    for (std::size_t i = 0; i < n; ++i) agents[i].id = static_cast<std::int32_t>(i);
    const auto messages = StatesMessages(AgentKind::kWorker, 7, 2, agents);
    ASSERT_EQ(messages.size(), (n + 255) / 256);
    std::size_t id = 0;
    for (const agent_states_t& message : messages) {
      EXPECT_EQ(message.kind, 1);
      EXPECT_EQ(message.tick, 7);
      EXPECT_EQ(message.applied_decision, 2);
      EXPECT_EQ(static_cast<std::size_t>(message.n), message.agents.size());
      for (const agent_t& agent : message.agents) EXPECT_EQ(agent.id, static_cast<int>(id++));
    }
    EXPECT_EQ(id, n);
  }
}

TEST(Possible, RulingsTellWhatHasHappenedAndSchedulesTheirTicksDecision) {
  const Scenario scenario;
  const Rules& rules = scenario.rules;  // ticks of 30 s, decisions every 10 min
  rulings_t rulings{};
  rulings.tick = 3;
  rulings.rulings = {{0, 1, 0, 90 * kSecondUs}};
  EXPECT_TRUE(Possible(rulings, rules));
  rulings.rulings[0].at_us += 1;
  EXPECT_FALSE(Possible(rulings, rules)) << "of the future";
  rulings.tick = 4;
  EXPECT_TRUE(Possible(rulings, rules));
  rulings.tick = 1'000'000;
  EXPECT_FALSE(Possible(rulings, rules));

  schedule_t schedule{};
  schedule.tick = 40;
  schedule.decision = 2;
  EXPECT_TRUE(Possible(schedule, scenario));
  schedule.decision = 130;
  EXPECT_FALSE(Possible(schedule, scenario));
  schedule.tick = 41;
  schedule.decision = -1;
  EXPECT_FALSE(Possible(schedule, scenario));

  clearances_t clearances{};
  clearances.tick = 40;
  clearances.decision = 2;
  EXPECT_TRUE(Possible(clearances, scenario));
  clearances.decision = 1;
  EXPECT_FALSE(Possible(clearances, scenario)) << "decided at another tick";
  clearances.tick = -20;
  clearances.decision = -1;
  EXPECT_FALSE(Possible(clearances, scenario));
}

}  // namespace
}  // namespace muster
