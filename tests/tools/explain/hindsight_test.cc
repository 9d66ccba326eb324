#include "tools/explain/hindsight.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/check.h"
#include "model/generator.h"
#include "tests/tools/explain/mission_log.h"
#include "tools/bound/upper_bound.h"

namespace muster::tools {
namespace {

Scenario DrawnScenario(std::uint64_t seed) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.rules.interval_us = 15 * kMinuteUs;
  settings.rules.limit_us = 75 * kMinuteUs;
  return Generate(settings, seed);
}

/// One UAV 12 km from the nearest of its charging points, one worker, and two tasks: both can sense
/// the near one at once; a second worker comes to the far one after an hour.
Scenario WorkerComesLater() {
  Scenario scenario;
  scenario.name = "two tasks";
  scenario.seed = 1;
  scenario.width_m = scenario.height_m = 30e3;
  scenario.rules.limit_us = 120 * kMinuteUs;
  const auto spec = [&](Point at, double speed_m_s) {
    AgentSpec agent;
    agent.at = at;
    agent.speed_m_s = speed_m_s;
    agent.online_until_us = scenario.rules.limit_us;
    return agent;
  };
  AgentSpec uav = spec({1000, 1000}, 10);
  uav.range_full_m = uav.range_m = 30e3;
  AgentSpec later = spec({9000, 1000}, 1);
  later.online_from_us = 60 * kMinuteUs;
  scenario.uavs = {uav};
  scenario.workers = {spec({1000, 1000}, 1), later};
  AgentSpec vehicle = spec({5000, 1000}, 10);
  vehicle.charge_rate_m_s = 100;
  scenario.vehicles = {vehicle};
  scenario.charging_points = {{{5000, 1000}}};
  scenario.tasks = {{{1000, 1000}, 3000}, {{9000, 1000}, 3000}};
  return scenario;
}

void ExpectItAddsUp(const Hindsight& hindsight) {
  Outcome lost;
  for (const HindsightDecision& decision : hindsight.decisions) {
    EXPECT_EQ(decision.missing, "");
    EXPECT_LE(decision.best.worth, hindsight.best.worth + 1e-9);
    EXPECT_GE(decision.best.worth, hindsight.was.worth - 1e-9);
    lost.done += decision.lost.done;
    lost.worth += decision.lost.worth;
    if (decision.lost.done > 0) {
      EXPECT_FALSE(decision.better.empty() && decision.commanded.empty());
    }
  }
  EXPECT_GE(lost.done, hindsight.best.done - hindsight.was.done);
  EXPECT_GE(hindsight.missed.size(), hindsight.best.done - hindsight.was.done);
  EXPECT_TRUE(std::is_sorted(hindsight.missed.begin(), hindsight.missed.end()));
}

TEST(Hindsight, AMissionThatDidEverythingLostNothing) {
  const Hindsight hindsight =
      LookBack(Logged(SimulatedPackets(WorkerComesLater(), "horizon")), "run", 1);
  EXPECT_EQ(hindsight.policy, "horizon");
  EXPECT_EQ(hindsight.tasks, 2u);
  EXPECT_EQ(hindsight.was.done, 2u);
  EXPECT_EQ(hindsight.best.done, 2u);
  EXPECT_TRUE(hindsight.missed.empty());
  ExpectItAddsUp(hindsight);
}

TEST(Hindsight, WhatNobodyWasSentToIsLostAtTheDecisionWhereItWasPossibleLast) {
  const Scenario scenario = WorkerComesLater();
  const DecisionLog log = Logged(SimulatedPackets(scenario, "external:false"));
  const Hindsight hindsight = LookBack(log, "run", 1);
  EXPECT_EQ(hindsight.was.done, 0u);
  EXPECT_EQ(hindsight.best.done, 2u) << "it knows that another worker comes";
  EXPECT_EQ(hindsight.missed, (std::vector<std::int32_t>{0, 1}));
  ExpectItAddsUp(hindsight);
  // The last sensing must begin at 110 min: 15 min from 1 to 9 km and on are needed for both.
  EXPECT_EQ(hindsight.decisions.back().best.done, 1u);
  EXPECT_EQ(hindsight.decisions.back().lost.done, 1u);
  EXPECT_NE(ToText(hindsight).find(
                "external:false did 0 of 2 tasks. The best plan found in hindsight does 2."),
            std::string::npos)
      << ToText(hindsight);
}

TEST(Hindsight, WhoFailsAndWhatIsCancelledIsKnown) {
  Scenario scenario = WorkerComesLater();
  DecisionLog log = Logged(SimulatedPackets(scenario, "external:false"));
  event_t failed = {};
  failed.kind = static_cast<std::int8_t>(EventKind::kAgentFailed);
  failed.at_us = 61 * kMinuteUs;
  failed.uav_id = failed.vehicle_id = failed.task_id = failed.charge_id = -1;
  failed.worker_id = 1;
  log.events.push_back(failed);
  Hindsight hindsight = LookBack(log, "run", 1);
  EXPECT_EQ(hindsight.best.done, 1u) << "the second worker fails before it has sensed anything";
  EXPECT_EQ(hindsight.decisions[6].failed, 1u);
  log.last_world->task_status[0] = static_cast<std::int8_t>(TaskStatus::kCancelled);
  hindsight = LookBack(log, "run", 1);
  EXPECT_EQ(hindsight.best.done, 0u);
}

TEST(Hindsight, IsAboveTheMissionAndBelowTheBoundAndMoreEffortFindsMore) {
  const Scenario scenario = DrawnScenario(1);
  const DecisionLog log = Logged(SimulatedPackets(scenario, "mpq"));
  const Hindsight one = LookBack(log, "run", 1), two = LookBack(log, "run", 2);
  ExpectItAddsUp(one);
  ExpectItAddsUp(two);
  EXPECT_GT(one.best.done, one.was.done + 3) << "mpq gets much less done";
  EXPECT_GE(two.best.done, one.best.done);
  EXPECT_LE(two.best.done, static_cast<std::size_t>(UpperBound(scenario)));
  EXPECT_EQ(ToJson(one), ToJson(LookBack(log, "run", 1))) << "the same again";
}

TEST(Hindsight, AMissionThatHasNotEndedIsRefused) {
  DecisionLog log = Logged(SimulatedPackets(WorkerComesLater(), "horizon"));
  --log.last_world->tick;
  EXPECT_THROW(LookBack(log, "run", 1), InputError) << "half a minute is missing";
  log.last_world.reset();
  EXPECT_THROW(LookBack(log, "run", 1), InputError);
}

TEST(Hindsight, DecisionsThatTheLogLacksAreSaidSo) {
  DecisionLog log = Logged(SimulatedPackets(WorkerComesLater(), "horizon"));
  log.decisions.at(1).told.clear();
  const Hindsight hindsight = LookBack(log, "run", 1);
  EXPECT_NE(hindsight.decisions[1].missing, "");
  EXPECT_EQ(hindsight.decisions[0].missing, "");
  EXPECT_NE(ToText(hindsight).find("not known: the log lacks"), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
