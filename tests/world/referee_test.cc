#include "world/referee.h"

#include <gtest/gtest.h>

namespace muster::world {
namespace {

/// One UAV and one worker 5 km and 4 km from one task; a vehicle at a charging point.
Scenario SmallScenario() {
  Scenario scenario;
  scenario.width_m = scenario.height_m = 10'000;
  scenario.rules.interval_us = 600 * kSecondUs;
  scenario.rules.limit_us = 3600 * kSecondUs;
  AgentSpec agent;
  agent.online_until_us = 3000 * kSecondUs;
  agent.speed_m_s = 10;
  agent.range_full_m = agent.range_m = 20'000;
  scenario.uavs = {agent};
  agent.at = {3000, 0};
  agent.speed_m_s = 5;
  scenario.workers = {agent};
  agent.at = {0, 1000};
  agent.charge_rate_m_s = 50;
  scenario.vehicles = {agent};
  scenario.tasks = {{{3000, 4000}, 600}};
  scenario.charging_points = {{{0, 1000}, 1}};
  return scenario;
}

FailureReason Fault(const std::string& id) { return {FailureReason::Cause::kFault, id}; }

Agents StartAgents(const Scenario& scenario) {
  Agents agents;
  for (const AgentKind kind : kAgentKinds) {
    for (std::size_t i = 0; i < scenario.agents(kind).size(); ++i) {
      agents[kind].push_back(
          StartOf(kind, static_cast<std::int32_t>(i), scenario.agents(kind)[i], *scenario.ways));
    }
  }
  return agents;
}

/// The agents' side of the lockstep without messages: a verdict reaches them before the next tick.
class Mission {
 public:
  explicit Mission(Scenario scenario)
      : scenario_(std::move(scenario)), agents_(StartAgents(scenario_)), referee_(scenario_) {}

  void Command(const Action& action) { command_ = action; }
  void Judge(TimeUs t, std::int32_t decision = -1) {
    if (previous_us_ >= 0) {
      for (const AgentKind kind : kAgentKinds) {
        for (AgentState& agent : agents_[kind]) {
          Settle(&agent, referee_.verdict(), previous_us_, scenario_.tasks);
        }
      }
    }
    if (command_) {
      const auto begin = [&](AgentKind kind, std::int32_t id) {
        if (id >= 0) {
          Begin(&agents_.at(kind, id), *command_, decision_, previous_us_, scenario_.disturbances,
                1);
        }
      };
      begin(AgentKind::kUav, command_->uav.value);
      begin(AgentKind::kWorker, command_->worker.value);
      begin(AgentKind::kVehicle, command_->vehicle.value);
      command_.reset();
    }
    Agents reported = agents_;
    referee_.Judge(t, decision, &reported);
    for (const Event& event : referee_.TakeEvents()) events_.push_back(event);
    previous_us_ = t;
    decision_ = decision;
  }
  std::vector<std::pair<Event::Kind, TimeUs>> Happened() const {
    std::vector<std::pair<Event::Kind, TimeUs>> list;
    for (const Event& event : events_) {
      if (event.kind != Event::Kind::kAgentOnline)
        list.push_back({event.kind, event.at_us / kSecondUs});
    }
    return list;
  }
  const std::vector<Event>& events() const { return events_; }
  Referee& referee() { return referee_; }
  Agents& agents() { return agents_; }

 private:
  Scenario scenario_;
  Agents agents_;
  Referee referee_;
  std::optional<Action> command_;
  TimeUs previous_us_ = -1;
  std::int32_t decision_ = -1;
  std::vector<Event> events_;
};

Action Sense() {
  Action action;
  action.kind = ActionKind::kSense;
  action.uav = UavId(0);
  action.worker = WorkerId(0);
  action.task = TaskId(0);
  action.to = {3000, 4000};
  return action;
}

using Kind = Event::Kind;
using Happened = std::vector<std::pair<Kind, TimeUs>>;

TEST(Referee, EventsDoNotDependOnTheTick) {
  for (const TimeUs tick : {20, 30, 300, 600}) {
    Mission mission(SmallScenario());
    mission.Judge(0, 0);
    mission.Command(Sense());
    for (TimeUs t = tick; t <= 1200; t += tick) mission.Judge(t * kSecondUs);
    EXPECT_EQ(mission.Happened(),
              (Happened{{Kind::kSensingStarted, 800}, {Kind::kSensingDone, 860}}))
        << "tick " << tick;
    EXPECT_EQ(mission.referee().done(), 1);
  }
}

TEST(Referee, TaskGoesFromReservedToSensingToDone) {
  Mission mission(SmallScenario());
  const auto status = [&] { return mission.referee().task_status()[0]; };
  mission.Judge(0, 0);
  EXPECT_EQ(status(), TaskStatus::kOpen);
  mission.Command(Sense());
  mission.Judge(30 * kSecondUs);
  EXPECT_EQ(status(), TaskStatus::kReserved);
  mission.Judge(810 * kSecondUs);
  EXPECT_EQ(status(), TaskStatus::kSensing);
  mission.Judge(900 * kSecondUs);
  EXPECT_EQ(status(), TaskStatus::kDone);
  mission.Judge(930 * kSecondUs);
  mission.Judge(960 * kSecondUs);
  EXPECT_EQ(status(), TaskStatus::kDone);
  EXPECT_TRUE(mission.referee().verdict().activities().empty());
}

TEST(Referee, FailedPartnerReleasesTheSurvivorAndReopensTheTask) {
  for (const TimeUs tick : {30, 600}) {
    Mission mission(SmallScenario());
    mission.Judge(0, 0);
    mission.Command(Sense());
    mission.referee().Add({AgentKind::kWorker, 0, 300 * kSecondUs, 900 * kSecondUs, Fault("test")});
    for (TimeUs t = tick; t <= 1200; t += tick) mission.Judge(t * kSecondUs);
    EXPECT_EQ(mission.Happened(), (Happened{{Kind::kAgentFailed, 300},
                                            {Kind::kSensingAborted, 300},
                                            {Kind::kAgentBack, 900}}));
    EXPECT_EQ(mission.referee().task_status()[0], TaskStatus::kOpen);
    const AgentState& uav = mission.agents().uavs[0];
    EXPECT_TRUE(uav.idle(300 * kSecondUs));
    EXPECT_EQ(PositionAt(uav, 1200 * kSecondUs), (Point{1800, 2400}));  // 300 s at 10 m/s
    EXPECT_DOUBLE_EQ(RangeAt(uav, 1200 * kSecondUs, {}), 20'000 - 3000);
  }
}

TEST(Referee, TheEndOfAnOutageBringsBackNobodyWhoHadFailedForGood) {
  Scenario scenario = SmallScenario();
  scenario.uavs[0].range_m = 1000;
  Mission mission(scenario);
  mission.referee().Add({AgentKind::kUav, 0, 300 * kSecondUs, 600 * kSecondUs, Fault("uav")});
  mission.referee().Add({AgentKind::kWorker, 0, 300 * kSecondUs, 600 * kSecondUs, Fault("worker")});
  mission.Judge(0, 0);
  mission.Command(Sense());
  for (TimeUs t = 30; t <= 1200; t += 30) mission.Judge(t * kSecondUs);
  EXPECT_EQ(mission.Happened(), (Happened{{Kind::kAgentFailed, 100},  // out of range
                                          {Kind::kSensingAborted, 100},
                                          {Kind::kAgentFailed, 300},
                                          {Kind::kAgentBack, 600}}));
  EXPECT_TRUE(mission.agents().uavs[0].failed);
  EXPECT_FALSE(mission.agents().workers[0].failed);
}

TEST(Referee, AFaultHasNoEffectOnAnAgentWhoseDriverGaveUp) {
  // A world that was started again in between knows that the agent has failed, and not why.
  for (const bool again : {false, true}) {
    Mission mission(SmallScenario());
    mission.referee().Add({AgentKind::kWorker,
                           0,
                           30 * kSecondUs,
                           kNever,
                           {FailureReason::Cause::kSaid, "its driver: tired"}});
    mission.Judge(30 * kSecondUs);
    Mission next(SmallScenario());
    next.referee().Restore(30 * kSecondUs, mission.referee().task_status(),
                           mission.referee().verdict());
    Mission& after = again ? next : mission;
    after.referee().Add({AgentKind::kWorker, 0, 60 * kSecondUs, 90 * kSecondUs, Fault("f")});
    for (const TimeUs t : {60, 90, 120}) after.Judge(t * kSecondUs);
    for (const Event& event : after.events()) EXPECT_NE(event.by_fault, "f") << again;
    EXPECT_TRUE(after.referee().has_failed(AgentKind::kWorker, 0)) << again;
  }
}

TEST(Referee, OnlyWhoFailsWithItsProcessIsRuledToBeLost) {
  Mission mission(SmallScenario());
  mission.referee().Add(
      {AgentKind::kUav, 0, 30 * kSecondUs + 1, kNever, FailureReason::LossOf("uav")});
  // A planned outage may begin at the same microsecond, and before.
  mission.referee().Add(
      {AgentKind::kWorker, 0, 30 * kSecondUs + 1, kNever, FailureReason::LossOf("worker")});
  mission.referee().Add({AgentKind::kWorker, 0, 30 * kSecondUs + 1, kNever, Fault("f")});
  mission.referee().Add({AgentKind::kVehicle, 0, 20 * kSecondUs, 90 * kSecondUs, Fault("g")});
  mission.referee().Add(
      {AgentKind::kVehicle, 0, 30 * kSecondUs + 1, kNever, FailureReason::LossOf("vehicle")});
  for (const TimeUs t : {0, 30, 60}) mission.Judge(t * kSecondUs);
  const TimeUs lost_us = 30 * kSecondUs + 1;
  using RKind = Ruling::Kind;
  EXPECT_EQ(mission.referee().verdict().rulings(),
            (std::vector<Ruling>{{AgentKind::kUav, 0, RKind::kLost, lost_us},
                                 {AgentKind::kWorker, 0, RKind::kFailed, lost_us},
                                 {AgentKind::kVehicle, 0, RKind::kFailed, 20 * kSecondUs}}));
  std::vector<std::pair<std::string, std::string>> told;
  for (const Event& event : mission.events()) {
    if (event.kind == Kind::kAgentFailed) told.emplace_back(event.detail, event.by_fault);
  }
  EXPECT_EQ(told, (std::vector<std::pair<std::string, std::string>>{
                      {"g", "g"}, {"f", "f"}, {"uav is lost", ""}}));
  mission.referee().EndOutages(FailureReason::LossOf("uav"), 90 * kSecondUs);
  mission.Judge(90 * kSecondUs);
  EXPECT_EQ(mission.referee().verdict().rulings(),
            (std::vector<Ruling>{{AgentKind::kWorker, 0, RKind::kFailed, lost_us},
                                 {AgentKind::kVehicle, 0, RKind::kFailed, 20 * kSecondUs}}));
}

TEST(Referee, AVacantPlaceOfALostProcessFailsInSilence) {
  Scenario scenario = SmallScenario();
  AddRoom({0, {1, 0, 0}}, &scenario);
  Mission mission(scenario);
  for (const std::int32_t id : {0, 1}) {
    mission.referee().Add(
        {AgentKind::kUav, id, 30 * kSecondUs + 1, kNever, FailureReason::LossOf("uav")});
  }
  for (const TimeUs t : {0, 30, 60}) mission.Judge(t * kSecondUs);
  EXPECT_EQ(mission.referee().verdict().rulings().size(), 2U);
  mission.referee().EndOutages(FailureReason::LossOf("uav"), 90 * kSecondUs);
  mission.Judge(90 * kSecondUs);
  EXPECT_EQ(mission.Happened(), (Happened{{Kind::kAgentFailed, 30}, {Kind::kAgentBack, 90}}));
}

TEST(Referee, OverlappingOutagesAreOne) {
  Mission mission(SmallScenario());
  mission.referee().Add({AgentKind::kUav, 0, 100 * kSecondUs, 600 * kSecondUs, Fault("first")});
  mission.referee().Add({AgentKind::kUav, 0, 300 * kSecondUs, 900 * kSecondUs, Fault("second")});
  mission.Judge(0, 0);
  for (TimeUs t = 30; t <= 1200; t += 30) mission.Judge(t * kSecondUs);
  EXPECT_EQ(mission.Happened(),
            (Happened{{Kind::kAgentFailed, 100},
                      {Kind::kFaultApplied, 300},  // the second: nothing else tells of its begin
                      {Kind::kAgentBack, 900}}));
}

TEST(Referee, AnOutageThatBeginsWhereAnotherEndsIsToldOfToo) {
  for (const TimeUs tick : {30, 50, 300}) {
    Mission mission(SmallScenario());
    mission.referee().Add({AgentKind::kUav, 0, 100 * kSecondUs, 300 * kSecondUs, Fault("first")});
    mission.referee().Add({AgentKind::kUav, 0, 300 * kSecondUs, 900 * kSecondUs, Fault("second")});
    mission.Judge(0, 0);
    for (TimeUs t = tick; t <= 1200; t += tick) mission.Judge(t * kSecondUs);
    EXPECT_EQ(
        mission.Happened(),
        (Happened{{Kind::kAgentFailed, 100}, {Kind::kFaultApplied, 300}, {Kind::kAgentBack, 900}}))
        << "tick " << tick;
  }
}

TEST(Referee, FailureWhileSensingSpendsProRataWhateverTheTick) {
  for (const TimeUs tick : {30, 900}) {
    const Scenario scenario = SmallScenario();
    Mission mission(scenario);
    mission.Judge(0, 0);
    mission.Command(Sense());
    mission.referee().Add({AgentKind::kWorker, 0, 815 * kSecondUs, kNever, Fault("test")});
    for (TimeUs t = tick; t <= 1800; t += tick) mission.Judge(t * kSecondUs);
    EXPECT_EQ(mission.Happened(), (Happened{{Kind::kSensingStarted, 800},
                                            {Kind::kAgentFailed, 815},
                                            {Kind::kSensingAborted, 815}}))
        << "tick " << tick;
    EXPECT_DOUBLE_EQ(RangeAt(mission.agents().uavs[0], 1800 * kSecondUs, scenario.tasks),
                     20'000 - 5000 - 150);
  }
}

TEST(Referee, UavThatRunsDryFailsOnItsWay) {
  Scenario scenario = SmallScenario();
  scenario.disturbances.wind = {1, 1};  // twice the range a metre
  scenario.uavs[0].range_m = 6'000;     // dry after 3 km
  Mission mission(scenario);
  mission.Judge(0, 0);
  mission.Command(Sense());
  mission.Judge(30 * kSecondUs);
  EXPECT_EQ(mission.referee().task_status()[0], TaskStatus::kReserved);
  mission.Judge(600 * kSecondUs);
  EXPECT_EQ(mission.Happened(),
            (Happened{{Kind::kAgentFailed, 300}, {Kind::kSensingAborted, 300}}));
  EXPECT_EQ(mission.referee().task_status()[0], TaskStatus::kOpen);
}

TEST(Referee, UavThatRunsDryWhileSensingFailsThere) {
  for (const TimeUs tick : {10, 30, 900}) {
    Scenario scenario = SmallScenario();
    scenario.uavs[0].range_m = 5'300;  // half of what sensing takes is left on arrival
    Mission mission(scenario);
    mission.Judge(0, 0);
    mission.Command(Sense());
    for (TimeUs t = tick; t <= 1800; t += tick) mission.Judge(t * kSecondUs);
    EXPECT_EQ(mission.Happened(), (Happened{{Kind::kSensingStarted, 800},
                                            {Kind::kAgentFailed, 830},
                                            {Kind::kSensingAborted, 830}}))
        << "tick " << tick;
    EXPECT_EQ(mission.referee().task_status()[0], TaskStatus::kOpen);
    EXPECT_EQ(RangeAt(mission.agents().uavs[0], 1800 * kSecondUs, scenario.tasks), 0);
  }
}

TEST(Referee, UavReleasedBeforeItRunsDryDoesNotFail) {
  for (const TimeUs tick : {10, 30, 900}) {
    Scenario scenario = SmallScenario();
    scenario.uavs[0].range_m = 5'300;
    Mission mission(scenario);
    mission.Judge(0, 0);
    mission.Command(Sense());
    mission.referee().Add({AgentKind::kWorker, 0, 815 * kSecondUs, kNever, Fault("test")});
    for (TimeUs t = tick; t <= 1800; t += tick) mission.Judge(t * kSecondUs);
    EXPECT_EQ(mission.Happened(), (Happened{{Kind::kSensingStarted, 800},
                                            {Kind::kAgentFailed, 815},
                                            {Kind::kSensingAborted, 815}}))
        << "tick " << tick;
    EXPECT_DOUBLE_EQ(RangeAt(mission.agents().uavs[0], 1800 * kSecondUs, scenario.tasks), 150);
  }
}

TEST(Referee, HalfACommandIsNoActivity) {
  Mission mission(SmallScenario());
  mission.Judge(0, 0);
  Agents& agents = mission.agents();
  Begin(&agents.uavs[0], Sense(), 0, 0, {}, 1);
  mission.Judge(30 * kSecondUs);
  mission.Judge(60 * kSecondUs);
  EXPECT_TRUE(agents.uavs[0].idle(30 * kSecondUs));
  EXPECT_EQ(mission.referee().task_status()[0], TaskStatus::kOpen);
  EXPECT_TRUE(mission.Happened().empty());
}

TEST(Referee, MeetingStartsSensingOnlyWhereTheScenarioSaysSo) {
  for (const bool meets : {false, true}) {
    Scenario scenario = SmallScenario();
    scenario.rules.start_on_meeting = meets;
    scenario.uavs[0].at = {3400, 4300};
    scenario.workers[0].at = {3900, 4900};
    Mission mission(scenario);
    mission.Judge(0, 0);
    mission.Judge(600 * kSecondUs);
    EXPECT_EQ(mission.referee().done(), meets ? 1 : 0);
    if (meets) {
      EXPECT_EQ(mission.Happened(),
                (Happened{{Kind::kSensingStarted, 0}, {Kind::kSensingDone, 60}}));
      EXPECT_DOUBLE_EQ(RangeAt(mission.agents().uavs[0], 600 * kSecondUs, scenario.tasks), 19'400);
    }
  }
}

TEST(Referee, ContinuesFromItsOwnVerdictAfterARestart) {
  Scenario scenario = SmallScenario();
  Mission mission(scenario);
  mission.Judge(0, 0);
  mission.Command(Sense());
  mission.Judge(30 * kSecondUs);
  Referee restarted(scenario);
  restarted.Restore(30 * kSecondUs, mission.referee().task_status(), mission.referee().verdict());
  Agents agents = mission.agents();
  for (AgentState& uav : agents.uavs) {
    Settle(&uav, mission.referee().verdict(), 30 * kSecondUs, scenario.tasks);
  }
  restarted.Judge(900 * kSecondUs, -1, &agents);
  const std::vector<Event> events = restarted.TakeEvents();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[1].kind, Kind::kSensingDone);
  EXPECT_EQ(events[1].at_us, 860 * kSecondUs);
  EXPECT_EQ(restarted.done(), 1);
}

TEST(Referee, ARestartDoesNotReviveWhatAFailureAborted) {
  const Scenario scenario = SmallScenario();
  Mission mission(scenario);
  mission.Judge(0, 0);
  mission.Command(Sense());
  mission.referee().Add({AgentKind::kWorker, 0, 40 * kSecondUs, kNever, Fault("test")});
  mission.Judge(30 * kSecondUs);
  mission.Judge(60 * kSecondUs);
  Referee restarted(scenario);
  restarted.Restore(60 * kSecondUs, mission.referee().task_status(), mission.referee().verdict());
  Agents agents = mission.agents();
  for (const AgentKind kind : kAgentKinds) {
    for (AgentState& agent : agents[kind]) {
      Settle(&agent, mission.referee().verdict(), 60 * kSecondUs, scenario.tasks);
    }
  }
  restarted.Judge(90 * kSecondUs, -1, &agents);
  EXPECT_TRUE(restarted.verdict().activities().empty());
  EXPECT_EQ(restarted.task_status()[0], TaskStatus::kOpen);
}

Scenario Timed(TimeUs reported_us, TimeUs expires_us) {
  Scenario scenario = SmallScenario();
  scenario.tasks[0].reported_us = reported_us;
  scenario.tasks[0].expires_us = expires_us;
  return scenario;
}

TEST(Referee, ATaskIsUnknownUntilItIsReported) {
  for (const TimeUs tick : {20, 30, 300}) {
    Mission mission(Timed(250 * kSecondUs, kNever));
    mission.Judge(0, 0);
    EXPECT_EQ(mission.referee().task_status()[0], TaskStatus::kUnreported);
    for (TimeUs t = tick; t <= 300; t += tick) mission.Judge(t * kSecondUs);
    EXPECT_EQ(mission.Happened(), (Happened{{Kind::kTaskReported, 250}})) << "tick " << tick;
    EXPECT_EQ(mission.referee().task_status()[0], TaskStatus::kOpen);
  }
}

TEST(Referee, SensingThatHasNotBegunWhenItsTaskExpiresIsCalledOff) {
  for (const TimeUs tick : {20, 30, 300, 600}) {
    Mission mission(Timed(0, 700 * kSecondUs));  // the worker would be there after 800 s
    mission.Judge(0, 0);
    mission.Command(Sense());
    for (TimeUs t = tick; t <= 1800; t += tick) mission.Judge(t * kSecondUs);
    EXPECT_EQ(mission.Happened(),
              (Happened{{Kind::kSensingAborted, 700}, {Kind::kTaskExpired, 700}}))
        << "tick " << tick;
    EXPECT_EQ(mission.referee().task_status()[0], TaskStatus::kExpired);
    EXPECT_EQ(mission.referee().done(), 0);
    EXPECT_TRUE(mission.agents().uavs[0].idle(700 * kSecondUs));
    // 700 s at 5 m/s of 4 km.
    EXPECT_EQ(PositionAt(mission.agents().workers[0], 1800 * kSecondUs), (Point{3000, 3500}));
  }
}

TEST(Referee, SensingThatHasBegunGoesOnAfterTheExpiry) {
  for (const TimeUs expires : {801, 830}) {
    Mission mission(Timed(0, expires * kSecondUs));
    mission.Judge(0, 0);
    mission.Command(Sense());
    for (TimeUs t = 20; t <= 1200; t += 20) mission.Judge(t * kSecondUs);
    EXPECT_EQ(mission.Happened(),
              (Happened{{Kind::kSensingStarted, 800}, {Kind::kSensingDone, 860}}));
  }
  // It must begin before, not at, the expiry.
  Mission mission(Timed(0, 800 * kSecondUs));
  mission.Judge(0, 0);
  mission.Command(Sense());
  for (TimeUs t = 20; t <= 1200; t += 20) mission.Judge(t * kSecondUs);
  EXPECT_EQ(mission.referee().task_status()[0], TaskStatus::kExpired);
}

TEST(Referee, ATaskExpiresWhenItsSensingEndsTooLateToBeginAnew) {
  for (const TimeUs tick : {10, 20, 300}) {
    Mission mission(Timed(0, 830 * kSecondUs));
    mission.Judge(0, 0);
    mission.Command(Sense());
    mission.referee().Add({AgentKind::kWorker, 0, 850 * kSecondUs, kNever, Fault("test")});
    for (TimeUs t = tick; t <= 1200; t += tick) mission.Judge(t * kSecondUs);
    EXPECT_EQ(mission.Happened(), (Happened{{Kind::kSensingStarted, 800},
                                            {Kind::kAgentFailed, 850},
                                            {Kind::kSensingAborted, 850},
                                            {Kind::kTaskExpired, 850}}))
        << "tick " << tick;
  }
}

TEST(Referee, FailedMatchIsTold) {
  Scenario scenario = SmallScenario();
  scenario.disturbances.match_failure = {1, 1};
  Mission mission(scenario);
  mission.Judge(0, 0);
  mission.referee().Take(0, {Sense()});
  mission.Judge(30 * kSecondUs);
  EXPECT_EQ(mission.Happened(), (Happened{{Kind::kMatchFailed, 0}}));
}

}  // namespace
}  // namespace muster::world
