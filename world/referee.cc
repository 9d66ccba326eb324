#include "world/referee.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/check.h"
#include "model/feasibility.h"
#include "protocol/convert.h"

namespace muster::world {
namespace {

using Cause = FailureReason::Cause;

constexpr double kCellSide_m = 1000;

bool SameCell(Point a, Point b) {
  return std::floor(a.x_m / kCellSide_m) == std::floor(b.x_m / kCellSide_m) &&
         std::floor(a.y_m / kCellSide_m) == std::floor(b.y_m / kCellSide_m);
}

Activity::Kind KindOf(ActionKind action) {
  return action == ActionKind::kSense ? Activity::Kind::kSensing : Activity::Kind::kCharging;
}

bool Involves(const Activity& activity, const AgentState& agent) {
  if (agent.kind == AgentKind::kUav) return activity.uav.value == agent.id;
  return agent.kind == PartnerKind(activity.kind) && activity.partner == agent.id;
}

bool Matches(const AgentState& a, const AgentState& b) {
  return a.action == b.action && a.partner == b.id && b.partner == a.id && a.target == b.target &&
         a.decision == b.decision && !a.failed && !b.failed;
}

}  // namespace

std::string FailureReason::Text() const {
  switch (cause) {
    case Cause::kFault:
      return by;
    case Cause::kProcessLost:
      return LossDetail(by);
    case Cause::kOutOfRange:
      return "out of range";
    case Cause::kSudden:
      return "sudden failure";
    case Cause::kSaid:
      return by;
  }
  MUSTER_CHECK(false, "cause={}", static_cast<int>(cause));
}

Referee::Referee(const Scenario& scenario)
    : scenario_(scenario), task_status_(scenario.tasks.size(), TaskStatus::kOpen) {
  for (std::size_t x = 0; x < scenario.tasks.size(); ++x) {
    if (scenario.tasks[x].reported_us > 0) task_status_[x] = TaskStatus::kUnreported;
  }
  PlanTimes(0);
}

int Referee::done() const {
  return static_cast<int>(std::count(task_status_.begin(), task_status_.end(), TaskStatus::kDone));
}

void Referee::Restore(TimeUs t, std::vector<TaskStatus> task_status, const Verdict& verdict) {
  previous_us_ = t;
  task_status_ = std::move(task_status);
  verdict_ = verdict;
  JoinOutages(t);
  std::erase_if(outages_, [&](const Outage& outage) { return outage.until_us <= t; });
  failed_.clear();
  for (const Ruling& ruling : verdict.rulings()) {
    if (ruling.fails()) failed_[{ruling.agent_kind, ruling.agent}] = ruling;
  }
  PlanTimes(t);
  activities_.clear();
  for (const Activity& activity : verdict.activities()) {
    // One that a failure aborted is listed once more.
    const auto aborted_by = [&](const AgentKey& agent) {
      const auto failed = failed_.find(agent);
      return failed != failed_.end() && failed->second.at_us < activity.end_us;
    };
    // One that an expiry, an order or a partner's failure aborted has freed its UAV.
    const auto released_during = [&](const Activity& one) {
      const auto rulings = verdict.rulings_of(AgentKind::kUav, one.uav.value);
      return std::any_of(rulings.begin(), rulings.end(), [&](const Ruling& ruling) {
        return ruling.kind == Ruling::Kind::kReleased && ruling.at_us < one.end_us;
      });
    };
    // A meeting begins as its members are released, if they are, from what they did before.
    const bool meets =
        scenario_.rules.start_on_meeting && activity.start_us == t &&
        (activity.kind == Activity::Kind::kCharging ||
         task_status_[static_cast<std::size_t>(activity.site)] == TaskStatus::kSensing);
    const bool is_aborted = aborted_by({AgentKind::kUav, activity.uav.value}) ||
                            aborted_by({PartnerKind(activity.kind), activity.partner}) ||
                            (!meets && released_during(activity));
    activities_.push_back({activity, false, is_aborted});
  }
}

void Referee::EndOutages(const FailureReason& reason, TimeUs t) {
  for (Outage& outage : outages_) {
    if (outage.reason == reason) outage.until_us = std::min(outage.until_us, t);
  }
}

void Referee::Judge(TimeUs t, std::int32_t decision, Agents* agents) {
  MUSTER_CHECK(t > previous_us_, "t={} previous={}", t, previous_us_);
  std::erase_if(activities_, [&](const Known& known) {
    return known.is_aborted || known.activity.end_us <= previous_us_;
  });
  for (Known& known : activities_) known.is_new = false;
  released_.clear();

  TakeIn(t, agents);
  EmitReports(t);
  MoveActivities(t, agents);
  PlanNewActivities(t, agents);
  FindLate(t, agents);
  Return(t, agents);
  FindFailures(t, decision, agents);
  GiveUpUntil(t);
  ExpireUntil(t);
  Obey(t, agents);
  UpdateVerdict();
  for (const AgentKind kind : kAgentKinds) {
    for (AgentState& agent : (*agents)[kind]) Settle(&agent, verdict_, t, scenario_.tasks);
  }
  for (const TakenOrder& taken : std::exchange(orders_, {})) {
    if (taken.agent_id < 0) continue;
    muster::Obey(&agents->at(taken.order.agent_kind, taken.agent_id), taken, t, scenario_);
  }
  UpdateTasks(t);
  if (decision >= 0 && scenario_.rules.start_on_meeting) {
    Meet(t, agents);
    UpdateVerdict();
    UpdateTasks(t);
  }
  EmitPresence(t, agents);
  EmitProgress(t);
  previous_us_ = t;
}

void Referee::UpdateVerdict() {
  std::vector<Activity> listed;
  for (const Known& known : activities_) listed.push_back(known.activity);
  std::vector<Ruling> rulings = released_;
  for (const auto& [agent, ruling] : failed_) rulings.push_back(ruling);
  verdict_ = Verdict(std::move(listed), std::move(rulings));
}

void Referee::PlanNewActivities(TimeUs t, Agents* agents) {
  UpdateVerdict();
  const auto planned = [&](const AgentState& agent) {
    bool found = false;
    verdict_.ForEachActivityOf(agent.kind, agent.id, [&](const Activity& activity) {
      found |= activity.start_us >= agent.depart_us && activity.site == agent.target;
    });
    return found;
  };
  // A partner that did not take its half of the command leaves the other free where it is now.
  const auto release = [&](const AgentState& agent) {
    released_.push_back({agent.kind, agent.id, Ruling::Kind::kReleased, t});
  };
  for (const AgentState& uav : agents->uavs) {
    if (!IsPair(uav.action) || uav.failed || planned(uav)) continue;
    const AgentState& partner = agents->at(PartnerKind(KindOf(uav.action)), uav.partner);
    if (!Matches(uav, partner)) {
      release(uav);
      continue;
    }
    activities_.push_back({ActivityOf(uav, partner, scenario_), true, false});
  }
  for (const AgentKind kind : {AgentKind::kWorker, AgentKind::kVehicle}) {
    for (const AgentState& partner : (*agents)[kind]) {
      if (!IsPair(partner.action) || partner.failed || planned(partner)) continue;
      if (!Matches(agents->at(AgentKind::kUav, partner.partner), partner)) release(partner);
    }
  }
}

/// An outage that is over by t, and that another follows without a break, is a part of that one.
void Referee::JoinOutages(TimeUs t) {
  std::stable_sort(outages_.begin(), outages_.end(),
                   [](const Outage& a, const Outage& b) { return a.until_us < b.until_us; });
  for (Outage& outage : outages_) {
    if (outage.until_us > t) break;
    const auto next = std::find_if(outages_.begin(), outages_.end(), [&](const Outage& other) {
      return other.kind == outage.kind && other.agent == outage.agent &&
             other.until_us > outage.until_us && other.from_us <= outage.until_us;
    });
    if (next == outages_.end()) continue;
    if (outage.from_us < next->from_us) {
      if (!next->joined_us) next->joined_us = next->from_us;
      next->from_us = outage.from_us;
    }
    outage.goes_on = true;
  }
}

void Referee::Return(TimeUs t, Agents* agents) {
  JoinOutages(t);
  for (const Outage& outage : outages_) {
    if (outage.until_us > t || outage.goes_on) continue;
    // An agent that had failed for good before does not come back.
    const auto failed = failed_.find({outage.kind, outage.agent});
    if (failed == failed_.end() || failed->second.at_us < outage.from_us) continue;
    const bool lost = failed->second.kind == Ruling::Kind::kLost;
    failed_.erase(failed);
    if (lost && agents->at(outage.kind, outage.agent).is_vacant()) continue;  // as it failed
    Emit(Event::Kind::kAgentBack, outage.until_us, AgentKey{outage.kind, outage.agent},
         outage.reason);
  }
  std::erase_if(outages_, [&](const Outage& outage) { return outage.until_us <= t; });
}

void Referee::FindFailures(TimeUs t, std::int32_t decision, Agents* agents) {
  std::vector<Failure> failures;
  for (const AgentState& uav : agents->uavs) {
    if (uav.failed || uav.action == ActionKind::kNone) continue;
    if (const auto dry = RunsDryAt(uav); dry && *dry <= t) {
      failures.push_back({*dry, {AgentKind::kUav, uav.id}, {Cause::kOutOfRange}});
    }
  }
  for (const Known& known : activities_) {
    if (known.activity.kind != Activity::Kind::kSensing) continue;
    const AgentState& uav = agents->at(AgentKind::kUav, known.activity.uav.value);
    if (uav.failed) continue;
    if (const auto dry = RunsDryAt(uav, known.activity, scenario_.tasks); dry && *dry <= t) {
      // A partner that is done early shortens the sensing: at the last tick there was range left.
      failures.push_back(
          {std::max(*dry, previous_us_ + 1), {AgentKind::kUav, uav.id}, {Cause::kOutOfRange}});
    }
  }
  for (const Outage& outage : outages_) {
    if (outage.from_us > t) continue;
    failures.push_back({std::max(outage.from_us, previous_us_ + 1),
                        {outage.kind, outage.agent},
                        outage.reason,
                        outage.from_us > previous_us_});
    if (outage.joined_us && *outage.joined_us > previous_us_) {
      failures.push_back(
          {*outage.joined_us, {outage.kind, outage.agent}, outage.reason, true, true});
    }
  }
  // The more often it is decided, the more would fail.
  const bool is_drawn = scenario_.rules.AlwaysDecides(scenario_.rules.TickOf(t));
  if (decision >= 0 && is_drawn && scenario_.disturbances.agent_failure.on()) {
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentState& agent : (*agents)[kind]) {
        if (agent.online(t) && !JoinsNow({kind, agent.id}) &&
            SuddenlyFails(kind, agent.id, decision, scenario_.disturbances, scenario_.seed)) {
          failures.push_back({t, {kind, agent.id}, {Cause::kSudden}});
        }
      }
    }
  }
  std::sort(failures.begin(), failures.end());
  const auto released_before = [&](const Failure& failure) {
    return std::any_of(released_.begin(), released_.end(), [&](const Ruling& ruling) {
      return AgentKey(ruling.agent_kind, ruling.agent) == failure.agent &&
             ruling.at_us <= failure.at_us;
    });
  };
  for (const Failure& failure : failures) {
    // A UAV that was released before has not run dry.
    const bool dry = failure.reason.cause == Cause::kOutOfRange;
    GiveUpUntil(failure.at_us);
    ExpireUntil(failure.at_us);
    if (!dry || !released_before(failure)) Fail(failure, agents);
  }
}

bool Referee::JoinsNow(AgentKey agent) const {
  return std::any_of(orders_.begin(), orders_.end(), [&](const TakenOrder& taken) {
    return taken.order.kind == OrderKind::kAgentJoin &&
           AgentKey(taken.order.agent_kind, taken.agent_id) == agent;
  });
}

void Referee::Abort(Known* known, TimeUs t, const std::optional<AgentKey>& agent) {
  const Activity& activity = known->activity;
  known->is_aborted = true;
  for (const AgentKey& one : {AgentKey{AgentKind::kUav, activity.uav.value},
                              AgentKey{PartnerKind(activity.kind), activity.partner}}) {
    if (one != agent) released_.push_back({one.first, one.second, Ruling::Kind::kReleased, t});
  }
  const bool sensing = activity.kind == Activity::Kind::kSensing;
  const bool began = activity.start_us <= t;
  if (began && (known->is_new || activity.start_us > previous_us_)) {
    Emit(sensing ? Event::Kind::kSensingStarted : Event::Kind::kChargingStarted, activity.start_us,
         activity);
  }
  Emit(sensing ? Event::Kind::kSensingAborted : Event::Kind::kChargingAborted, t, activity,
       began ? "under way" : "before its start");
}

bool Referee::AbortActivityOf(const AgentState& agent, TimeUs t, bool fails) {
  const AgentKey failed(agent.kind, agent.id);
  bool found = false;
  for (Known& known : activities_) {
    const Activity& activity = known.activity;
    if (!Involves(activity, agent) || known.is_aborted || activity.end_us <= t ||
        activity.start_us < agent.depart_us) {
      continue;
    }
    found = true;
    Abort(&known, t, fails ? std::optional(failed) : std::nullopt);
    if (activity.kind == Activity::Kind::kSensing) {
      ExpireIfLate(static_cast<std::size_t>(activity.site), t);
    }
  }
  return found;
}

bool Referee::IsOutBecauseOfAnother(const Failure& failure) const {
  const TimeUs since_us = failed_.at(failure.agent).at_us;
  return std::any_of(outages_.begin(), outages_.end(), [&](const Outage& other) {
    // Whose driver has given up has failed for good. A restarted world does not know why.
    return AgentKey(other.kind, other.agent) == failure.agent && other.reason != failure.reason &&
           other.reason.cause != Cause::kSaid && other.from_us <= since_us;
  });
}

void Referee::Fail(const Failure& failure, Agents* agents) {
  const auto [kind, id] = failure.agent;
  const bool lost = failure.reason.cause == Cause::kProcessLost;
  const Ruling ruling{kind, id, lost ? Ruling::Kind::kLost : Ruling::Kind::kFailed, failure.at_us};
  if (!failed_.emplace(failure.agent, ruling).second) {
    // It fails no more than it has, but stays so when the other outage ends.
    if (failure.begins && (failure.joins || IsOutBecauseOfAnother(failure))) {
      Emit(Event::Kind::kFaultApplied, failure.at_us, failure.agent, failure.reason);
    }
    return;
  }
  const AgentState& agent = agents->at(kind, id);
  if (lost && agent.is_vacant()) return;  // nobody is told of an empty place
  Emit(Event::Kind::kAgentFailed, failure.at_us, failure.agent, failure.reason);
  AbortActivityOf(agent, failure.at_us, true);
}

void Referee::Meet(TimeUs t, Agents* agents) {
  const auto free_at = [&](const AgentState& agent, Point site) {
    return agent.idle(t) && SameCell(PositionAt(agent, t), site);
  };
  const auto meet = [&](const Activity& activity) {
    AgentState& uav = agents->at(AgentKind::kUav, activity.uav.value);
    AgentState& partner = agents->at(PartnerKind(activity.kind), activity.partner);
    if (activity.end_us >
        std::min(LatestEnd(uav, scenario_.rules), LatestEnd(partner, scenario_.rules))) {
      return false;
    }
    activities_.push_back({activity, true, false});
    const Verdict met({activity}, {});
    Settle(&uav, met, t, scenario_.tasks);
    Settle(&partner, met, t, scenario_.tasks);
    return true;
  };
  const std::vector<ForbiddenPair> forbidden = ForbiddenPairs(scenario_.directives);
  for (std::size_t x = 0; x < scenario_.tasks.size(); ++x) {
    if (task_status_[x] != TaskStatus::kOpen) continue;
    const Task& task = scenario_.tasks[x];
    const double home = NearestChargeM(*scenario_.ways, task.at, scenario_.charging_points);
    const auto may_do = [&](const AgentState& agent) {
      const ForbiddenPair pair{agent.kind, agent.id, static_cast<std::int32_t>(x)};
      return !std::binary_search(forbidden.begin(), forbidden.end(), pair);
    };
    for (const AgentState& uav : agents->uavs) {
      if (!free_at(uav, task.at) || !may_do(uav) ||
          !CanSense(RangeAt(uav, t, scenario_.tasks), 0, task.cost_m, home)) {
        continue;
      }
      const auto worker =
          std::find_if(agents->workers.begin(), agents->workers.end(),
                       [&](const AgentState& w) { return free_at(w, task.at) && may_do(w); });
      if (worker == agents->workers.end()) break;
      if (meet({Activity::Kind::kSensing, UavId(uav.id), worker->id, static_cast<std::int32_t>(x),
                t, t + SensingUs(task.cost_m, uav.speed_m_s)})) {
        break;
      }
    }
  }
  for (std::size_t y = 0; y < scenario_.charging_points.size(); ++y) {
    const ChargingPoint& point = scenario_.charging_points[y];
    auto load = std::count_if(activities_.begin(), activities_.end(), [&](const Known& known) {
      return !known.is_aborted && known.activity.kind == Activity::Kind::kCharging &&
             known.activity.site == static_cast<std::int32_t>(y) && known.activity.end_us > t;
    });
    for (const AgentState& uav : agents->uavs) {
      if (point.capacity && load >= *point.capacity) break;
      const double range = RangeAt(uav, t, scenario_.tasks);
      if (range >= uav.range_full_m || !free_at(uav, point.at)) continue;
      const auto vehicle = std::find_if(agents->vehicles.begin(), agents->vehicles.end(),
                                        [&](const AgentState& v) { return free_at(v, point.at); });
      if (vehicle == agents->vehicles.end()) break;
      if (meet({Activity::Kind::kCharging, UavId(uav.id), vehicle->id, static_cast<std::int32_t>(y),
                t, t + ChargingUs(uav.range_full_m, range, vehicle->charge_rate_m_s)})) {
        ++load;
      }
    }
  }
}

void Referee::EmitPresence(TimeUs t, Agents* agents) {
  const auto within = [&](TimeUs at) { return previous_us_ < at && at <= t; };
  for (const AgentKind kind : kAgentKinds) {
    for (const AgentState& agent : (*agents)[kind]) {
      if (agent.online_from_us >= agent.online_until_us) continue;
      const AgentKey key{kind, agent.id};
      if (within(agent.online_from_us)) Emit(Event::Kind::kAgentOnline, agent.online_from_us, key);
      if (within(agent.online_until_us)) {
        Emit(Event::Kind::kAgentOffline, agent.online_until_us, key);
      }
    }
  }
}

void Referee::EmitProgress(TimeUs t) {
  for (const Known& known : activities_) {
    if (known.is_aborted) continue;
    const Activity& activity = known.activity;
    const bool sensing = activity.kind == Activity::Kind::kSensing;
    if (activity.start_us <= t && (known.is_new || activity.start_us > previous_us_)) {
      Emit(sensing ? Event::Kind::kSensingStarted : Event::Kind::kChargingStarted,
           activity.start_us, activity);
    }
    if (activity.end_us <= t) {
      Emit(sensing ? Event::Kind::kSensingDone : Event::Kind::kChargingDone, activity.end_us,
           activity);
    }
  }
}

void Referee::Take(std::int32_t decision, const std::vector<Action>& actions) {
  for (const Action& action : actions) {
    if (!IsPair(action.kind) ||
        !MatchFails(action, decision, scenario_.disturbances, scenario_.seed)) {
      continue;
    }
    Event event;
    event.kind = Event::Kind::kMatchFailed;
    event.at_us = previous_us_;
    event.uav = action.uav;
    event.worker = action.worker;
    event.vehicle = action.vehicle;
    event.task = action.task;
    event.charge = action.charge;
    events_.push_back(event);
  }
}

void Referee::Emit(Event::Kind kind, TimeUs at_us, const Activity& activity, std::string detail) {
  Event event;
  event.kind = kind;
  event.at_us = at_us;
  event.uav = activity.uav;
  if (activity.kind == Activity::Kind::kSensing) {
    event.worker = WorkerId(activity.partner);
    event.task = TaskId(activity.site);
  } else {
    event.vehicle = VehicleId(activity.partner);
    event.charge = ChargeId(activity.site);
  }
  event.detail = std::move(detail);
  events_.push_back(event);
}

void Referee::Emit(Event::Kind kind, TimeUs at_us, TaskId task, std::string detail) {
  Event event;
  event.kind = kind;
  event.at_us = at_us;
  event.task = task;
  event.detail = std::move(detail);
  events_.push_back(std::move(event));
}

void Referee::Emit(Event::Kind kind, TimeUs at_us, AgentKey agent,
                   const std::optional<FailureReason>& reason) {
  Event event;
  event.kind = kind;
  event.at_us = at_us;
  if (agent.first == AgentKind::kUav) event.uav = UavId(agent.second);
  if (agent.first == AgentKind::kWorker) event.worker = WorkerId(agent.second);
  if (agent.first == AgentKind::kVehicle) event.vehicle = VehicleId(agent.second);
  if (reason) {
    event.detail = reason->Text();
    if (reason->cause == Cause::kFault) event.by_fault = reason->by;
  }
  events_.push_back(event);
}

std::vector<Event> Referee::TakeEvents() {
  std::sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
    return std::tie(a.at_us, a.kind, a.uav, a.worker, a.vehicle, a.task, a.charge, a.detail) <
           std::tie(b.at_us, b.kind, b.uav, b.worker, b.vehicle, b.task, b.charge, b.detail);
  });
  return std::exchange(events_, {});
}

}  // namespace muster::world
