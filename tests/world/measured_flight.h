#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/measured.h"
#include "protocol/convert.h"
#include "world/referee.h"

namespace muster::world::testing {

using Report = MeasuredReport::Kind;
using Kind = Event::Kind;
using Happened = std::vector<std::pair<Kind, TimeUs>>;

/// A UAV 5 km (500 s) and a worker 4 km (800 s) from one task of 60 s; a vehicle at a charging
/// point 1 km (100 s) from the UAV, where 5 km of range come in 100 s.
inline Scenario Small() {
  Scenario scenario;
  scenario.width_m = scenario.height_m = 10'000;
  scenario.rules.interval_us = 600 * kSecondUs;
  scenario.rules.limit_us = 3600 * kSecondUs;
  AgentSpec agent;
  agent.online_until_us = 3000 * kSecondUs;
  agent.speed_m_s = 10;
  agent.range_full_m = 20'000;
  agent.range_m = 15'000;
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

inline Action Sense() {
  Action action;
  action.kind = ActionKind::kSense;
  action.uav = UavId(0);
  action.worker = WorkerId(0);
  action.task = TaskId(0);
  action.to = {3000, 4000};
  return action;
}

inline Action Charge() {
  Action action;
  action.kind = ActionKind::kCharge;
  action.uav = UavId(0);
  action.vehicle = VehicleId(0);
  action.charge = ChargeId(0);
  action.to = {0, 1000};
  return action;
}

/// What whoever holds the agent must know alike, but for rounding.
inline std::string Shown(const AgentState& a) {
  const auto m = a.measured.value_or(Measured());
  const auto activity = a.activity.value_or(Activity());
  return fmt::format(
      "{} {} from {:.6f},{:.6f} to {:.6f},{:.6f} {}-{} range {:.6f} per m {} action {} target {} "
      "partner {} decision {} busy {} activity {}-{} failed {} measured {} arrived {} done {}",
      ToString(a.kind), a.id, a.from.x_m, a.from.y_m, a.to.x_m, a.to.y_m, a.depart_us, a.arrive_us,
      a.range_at_departure_m, a.range_per_m, static_cast<int>(a.action), a.target, a.partner,
      a.decision, a.busy_until_us, activity.start_us, activity.end_us, a.failed,
      a.measured.has_value(), m.arrived, m.done);
}

/// A mission of these three. What agents say is applied by the agents' side; the world knows what
/// goes over the wire. After each tick both must have come to the same state.
class Flight {
 public:
  explicit Flight(Scenario scenario, TimeUs tick_s = 30)
      : scenario_(std::move(scenario)), referee_(std::make_unique<Referee>(scenario_)) {
    scenario_.rules.tick_us = tick_s * kSecondUs;
    for (const AgentKind kind : kAgentKinds) {
      for (std::size_t i = 0; i < scenario_.agents(kind).size(); ++i) {
        agents_[kind].push_back(StartOf(kind, static_cast<std::int32_t>(i),
                                        scenario_.agents(kind)[i], *scenario_.ways));
      }
    }
    world_ = agents_;
  }

  Flight& Measure(AgentKind kind) {
    AgentState& agent = agents_.at(kind, 0);
    ByKind(kind, scenario_.uavs, scenario_.workers, scenario_.vehicles)[0].measured = true;
    const TimeUs t = std::max<TimeUs>(previous_us_, 0);
    agent.measured.emplace();
    agent.measured->seen = {PositionAt(agent, t), t, RangeAt(agent, t, scenario_.tasks)};
    NoteLeg(&agent);
    return *this;
  }
  Flight& Command(const Action& action) {
    command_ = action;
    return *this;
  }
  Flight& Tell(MeasuredReport report) {
    report.agent = 0;
    if (report.decision < 0) report.decision = agents_[report.agent_kind][0].decision;
    told_.push_back(std::move(report));
    return *this;
  }
  Flight& Arrived(AgentKind kind) { return Tell({.agent_kind = kind, .kind = Report::kArrived}); }
  Flight& Done(AgentKind kind, std::optional<double> range_m = {}) {
    return Tell({.agent_kind = kind, .kind = Report::kDone, .range_m = range_m});
  }
  Flight& At(AgentKind kind, Point at, TimeUs at_s, std::optional<TimeUs> expected_s = {},
             std::optional<double> range_m = {}) {
    if (expected_s) expected_s = *expected_s * kSecondUs;
    return Tell({.agent_kind = kind,
                 .at_us = at_s * kSecondUs,
                 .at = at,
                 .range_m = range_m,
                 .expected_us = expected_s});
  }

  Flight& FailUav(TimeUs at_s) {
    referee_->Add(
        {AgentKind::kUav, 0, at_s * kSecondUs, kNever, {FailureReason::Cause::kFault, "fault"}});
    return *this;
  }

  /// One tick: what was told is taken, then judged, then all have settled.
  Flight& Judge(TimeUs t_s, std::int32_t decision = -1) {
    const TimeUs t = t_s * kSecondUs;
    if (command_) {
      for (const AgentKind kind : kAgentKinds) {
        const std::int32_t id = MemberOf(*command_, kind);
        if (id < 0) continue;
        Begin(&agents_.at(kind, id), *command_, decision_, previous_us_, scenario_.disturbances,
              scenario_.seed);
      }
      command_.reset();
    }
    for (MeasuredReport& report : std::exchange(told_, {})) {
      if (report.kind != Report::kPlace) report.at_us = t;
      AgentState& own = agents_.at(report.agent_kind, 0);
      const std::string before = Shown(own);
      refusal_ = ApplyReport(&own, report, t, scenario_.tasks);
      if (!refusal_.empty()) {
        EXPECT_EQ(Shown(own), before);
        continue;
      }
      if (report.kind == Report::kFailed) {
        referee_->Add(
            {report.agent_kind, 0, t, kNever, {FailureReason::Cause::kSaid, report.reason}});
      }
    }
    ForEach([&](AgentState& own, AgentState& known) {
      ExpectOnward(&own, t, scenario_.rules.TickAfter(t));
      const auto reported =
          FromWire(ToWire(own, t, scenario_.tasks), own.kind, t, WireLimits(scenario_));
      ASSERT_TRUE(reported);
      known = *reported;
    });
    referee_->Judge(t, decision, &world_);
    ForEach([&](AgentState& own, AgentState& known) {
      Settle(&own, referee_->verdict(), t, scenario_.tasks);
      // The rest of a free move is told from a place behind, so that its goal can be seen.
      AgentState shown = known;
      if (own.action == ActionKind::kGoTo && own.arrive_us > t) {
        EXPECT_EQ(PositionAt(known, t), PositionAt(own, t));
        shown.from = own.from, shown.depart_us = own.depart_us;
        shown.range_at_departure_m = own.range_at_departure_m;
      }
      EXPECT_EQ(Shown(own), Shown(shown)) << "at " << t_s;
    });
    for (Event& event : referee_->TakeEvents()) {
      if (event.kind != Kind::kAgentOnline) events_.push_back(std::move(event));
    }
    previous_us_ = t;
    decision_ = decision;
    return *this;
  }
  Flight& Until(TimeUs t_s) {
    const TimeUs tick_s = scenario_.rules.tick_us / kSecondUs;
    for (TimeUs t = previous_us_ / kSecondUs + tick_s; t <= t_s; t += tick_s) Judge(t);
    return *this;
  }
  /// The world dies and goes on from what it published.
  void RestartWorld() {
    auto restarted = std::make_unique<Referee>(scenario_);
    restarted->Restore(previous_us_, referee_->task_status(), referee_->verdict());
    referee_ = std::move(restarted);
  }

  Happened happened() const {
    Happened list;
    for (const Event& event : events_) list.push_back({event.kind, event.at_us / kSecondUs});
    return list;
  }
  const std::vector<Event>& events() const { return events_; }
  const std::string& refusal() const { return refusal_; }
  const AgentState& agent(AgentKind kind) const { return world_[kind][0]; }
  TaskStatus task() const { return referee_->task_status()[0]; }
  const Scenario& scenario() const { return scenario_; }

 private:
  template <class Visit>
  void ForEach(Visit visit) {
    for (const AgentKind kind : kAgentKinds) {
      for (std::size_t i = 0; i < agents_[kind].size(); ++i)
        visit(agents_[kind][i], world_[kind][i]);
    }
  }

  Scenario scenario_;
  std::unique_ptr<Referee> referee_;
  Agents agents_, world_;
  std::vector<MeasuredReport> told_;
  std::optional<Action> command_;
  std::string refusal_;
  TimeUs previous_us_ = -1;
  std::int32_t decision_ = -1;
  std::vector<Event> events_;
};

}  // namespace muster::world::testing
