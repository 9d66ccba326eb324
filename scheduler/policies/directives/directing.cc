#include "scheduler/policies/directives/directing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "model/feasibility.h"
#include "scheduler/checker.h"
#include "scheduler/policies/rollout/forward_model.h"
#include "scheduler/solver/candidates.h"

namespace muster::scheduler {
namespace {

using State = DirectiveOutcome::State;
using Key = std::pair<AgentKind, std::int32_t>;

constexpr double kFull_m = 1;  ///< a UAV that lacks less range than this is charged

/// The site without directives but the forbidden pairs: nobody charges where it is forbidden.
std::shared_ptr<const Site> WithoutDirectives(const Site& site) {
  auto rest = std::make_shared<Site>(site);
  rest->directives.clear();
  for (ChargingPoint& point : rest->charging_points) {
    if (IsOffLimits(site.directives, AgentKind::kUav, point.at) ||
        IsOffLimits(site.directives, AgentKind::kVehicle, point.at)) {
      point.capacity = 0;
    }
  }
  return rest;
}

class Director {
 public:
  explicit Director(const Situation& situation) : situation_(situation), site_(*situation.site) {
    result_.rest = situation;
    result_.rest.site = WithoutDirectives(site_);
    for (const Directive& one : site_.directives) result_.outcomes.push_back({one, {}, {}});
  }

  Directing Direct() {
    KeepOffLimits();
    ForEach(Directive::Kind::kChargeNow, [&](const Directive& one) { return ChargeNow(one); });
    ForEach(Directive::Kind::kPin, [&](const Directive& one) { return Pin(one); });
    ForEach(Directive::Kind::kGoTo, [&](const Directive& one) { return GoTo(one); });
    for (const AgentKind kind : kAgentKinds) {
      std::erase_if(ByKind(kind, result_.rest.uavs, result_.rest.workers, result_.rest.vehicles),
                    [&](const AgentState& agent) {
                      return standing_.contains({kind, agent.id});
                    });
    }
    return std::move(result_);
  }

 private:
  struct Outcome {
    State state = State::kKept;
    std::string why = {};
  };

  template <class Keep>
  void ForEach(Directive::Kind kind, Keep keep) {
    for (DirectiveOutcome& outcome : result_.outcomes) {
      if (outcome.directive.kind != kind) continue;
      Outcome of_one = keep(outcome.directive);
      outcome.state = of_one.state;
      outcome.why = std::move(of_one.why);
    }
  }

  /// Tasks in an area that is forbidden to UAVs or workers are nobody's.
  void KeepOffLimits() {
    for (std::size_t x = 0; x < site_.tasks.size(); ++x) {
      if (!IsOffLimits(TaskId(x))) continue;
      TaskStatus& status = result_.rest.task_status[x];
      if (status == TaskStatus::kOpen) status = TaskStatus::kHeld;
    }
  }
  bool IsOffLimits(TaskId task) const {
    const Point at = site_.tasks[task.index()].at;
    return muster::IsOffLimits(site_.directives, AgentKind::kUav, at) ||
           muster::IsOffLimits(site_.directives, AgentKind::kWorker, at);
  }

  /// null: it is not online, or has failed.
  const AgentState* Find(AgentKind kind, std::int32_t id) const {
    const auto& agents = result_.rest.agents(kind);
    const auto found =
        std::lower_bound(agents.begin(), agents.end(), id,
                         [](const AgentState& agent, std::int32_t i) { return agent.id < i; });
    return found != agents.end() && found->id == id ? &*found : nullptr;
  }
  bool IsFree(const AgentState& agent) const {
    return agent.idle(situation_.now_us) && !standing_.contains({agent.kind, agent.id});
  }
  std::vector<const AgentState*> FreeOnes(AgentKind kind) const {
    std::vector<const AgentState*> free;
    for (const AgentState& agent : result_.rest.agents(kind)) {
      if (IsFree(agent)) free.push_back(&agent);
    }
    return free;
  }
  static Outcome Absent(AgentKind kind, std::int32_t id) {
    return {State::kUnkept, fmt::format("{}:{} has failed or is not online", ToString(kind), id)};
  }
  static Outcome Busy(const AgentState& agent) {
    return {State::kWaits, fmt::format("{}:{} is under way", ToString(agent.kind), agent.id)};
  }

  /// What the action breaks now; "": nothing.
  std::string Broken(const Action& action) const {
    const auto violations = CheckActions(result_.rest, {&action, 1});
    if (violations.empty()) return "";
    const std::string& message = violations.front().message;
    const std::size_t colon = message.find("): ");
    return colon == std::string::npos ? message : message.substr(colon + 3);
  }

  double WeightOf(const Action& action) {
    if (!weights_) weights_.emplace(situation_);
    return weights_->Of(action).value_or(0);
  }

  void Send(Action action) {
    action.weight = WeightOf(action);
    CarryOut(action, &result_.rest);
    // One who goes ahead takes a place of this decision too.
    if (action.charge.valid() && !IsPair(action.kind)) {
      ++result_.rest.charging_load[action.charge.index()];
    }
    result_.actions.push_back(action);
  }
  /// Whether it is there, or will be: to the rounding of a place that was told.
  static bool IsAt(const AgentState& agent, Point place) {
    return TravelUs(agent.WayM(agent.to, place), agent.speed_m_s) == 0;
  }
  void Hold(const AgentState& agent) { standing_.insert({agent.kind, agent.id}); }

  /// Sends it there alone if that is possible; it stays where it is otherwise.
  void GoAhead(const AgentState& agent, TaskId task, ChargeId charge) {
    const bool is_uav = agent.kind == AgentKind::kUav;
    const Action action =
        MakeAction(site_, is_uav ? &agent : nullptr, is_uav ? nullptr : &agent, task, charge);
    if (IsAt(agent, action.to) || !Broken(action).empty()) return Hold(agent);
    Send(action);
  }

  Outcome ChargeNow(const Directive& one) {
    const AgentState* const uav = Find(AgentKind::kUav, one.agents.uavs);
    if (uav == nullptr) return Absent(AgentKind::kUav, one.agents.uavs);
    if (uav->action == ActionKind::kCharge) return {State::kOver};  // under way
    if (!IsFree(*uav)) return Busy(*uav);
    const double range_m = situation_.range_m(*uav);
    if (range_m >= uav->range_full_m - kFull_m) return {State::kOver};
    const std::vector<ChargeId> points = PointsFor(one, *uav, range_m);
    if (points.empty()) return {State::kUnkept, "no charging point with a free place is in range"};
    if (const auto action = BestCharge(one, *uav, range_m, points)) {
      Send(*action);
      return {};
    }
    GoAhead(*uav, {}, points.front());
    return {State::kWaits, "no vehicle is free that can charge it"};
  }

  /// Those that it may use, nearest first.
  std::vector<ChargeId> PointsFor(const Directive& one, const AgentState& uav,
                                  double range_m) const {
    std::vector<std::pair<double, ChargeId>> found;
    for (std::size_t y = 0; y < site_.charging_points.size(); ++y) {
      if (one.charge >= 0 && static_cast<std::size_t>(one.charge) != y) continue;
      const double way_m = uav.WayM(uav.to, site_.charging_points[y].at);
      if (CanReachCharge(range_m, way_m) && result_.rest.free_places(ChargeId(y)) > 0) {
        found.emplace_back(way_m, ChargeId(y));
      }
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
      return std::tuple(a.first, a.second.value) < std::tuple(b.first, b.second.value);
    });
    std::vector<ChargeId> points;
    for (const auto& [way_m, point] : found) points.push_back(point);
    return points;
  }

  /// The pair that has charged first.
  std::optional<Action> BestCharge(const Directive& one, const AgentState& uav, double range_m,
                                   const std::vector<ChargeId>& points) const {
    std::vector<std::tuple<TimeUs, std::int32_t, std::int32_t, const AgentState*>> found;
    for (const AgentState* vehicle : FreeOnes(AgentKind::kVehicle)) {
      if (one.agents.vehicles >= 0 && one.agents.vehicles != vehicle->id) continue;
      for (const ChargeId point : points) {
        const Point at = site_.charging_points[point.index()].at;
        const double way_m = uav.WayM(uav.to, at);
        const TimeUs uav_us = TravelUs(way_m, uav.speed_m_s);
        const TimeUs vehicle_us = TravelUs(vehicle->WayM(vehicle->to, at), vehicle->speed_m_s);
        if (uav_us == kNever || vehicle_us == kNever) continue;
        const TimeUs takes_us =
            ChargingUs(uav.range_full_m, range_m - way_m, vehicle->charge_rate_m_s);
        found.emplace_back(std::max(uav_us, vehicle_us) + takes_us, vehicle->id, point.value,
                           vehicle);
      }
    }
    std::sort(found.begin(), found.end());
    for (const auto& [end_us, id, point, vehicle] : found) {
      const Action action = MakeAction(site_, &uav, vehicle, {}, ChargeId(point));
      if (Broken(action).empty()) return action;
    }
    return {};
  }

  Outcome Pin(const Directive& one) {
    const TaskId task(one.task);
    const TaskStatus status = situation_.task_status[task.index()];
    if (status == TaskStatus::kHeld) return {State::kWaits, "the task is held"};
    if (status != TaskStatus::kOpen) return {State::kOver};
    if (IsOffLimits(task)) return {State::kUnkept, "the task lies in a forbidden area"};
    std::vector<const AgentState*> free;
    const AgentState* busy = nullptr;
    for (const AgentKind kind : {AgentKind::kUav, AgentKind::kWorker}) {
      const std::int32_t id = one.agents[kind];
      if (id < 0) continue;
      const AgentState* const agent = Find(kind, id);
      if (agent == nullptr) return Absent(kind, id);
      if (site_.Forbids(*agent, one.task)) {
        return {State::kUnkept, fmt::format("{}:{} must not do that task", ToString(kind), id)};
      }
      if (std::string late = TooLate(*agent, task); !late.empty()) {
        return {State::kUnkept, std::move(late)};
      }
      if (IsFree(*agent)) {
        free.push_back(agent);
      } else {
        busy = agent;
      }
    }
    if (busy != nullptr) {
      KeepFor(free, task);
      return Busy(*busy);
    }
    return SendPair(one, task, free);
  }

  /// All that are named are free.
  Outcome SendPair(const Directive& one, TaskId task, const std::vector<const AgentState*>& free) {
    const auto candidates = [&](AgentKind kind) {
      const std::int32_t id = one.agents[kind];
      return id < 0 ? FreeOnes(kind) : std::vector<const AgentState*>{Find(kind, id)};
    };
    std::optional<Action> best;
    std::string broken = "nobody is free to do it with";
    for (const AgentState* uav : candidates(AgentKind::kUav)) {
      for (const AgentState* worker : candidates(AgentKind::kWorker)) {
        Action action = MakeAction(site_, uav, worker, task, {});
        action.weight = WeightOf(action);
        if (best && action.weight <= best->weight) continue;
        if (std::string why = Broken(action); !why.empty()) {
          broken = std::move(why);
        } else {
          best = action;
        }
      }
    }
    if (best) {
      Send(*best);
      return {};
    }
    if (one.agents.uavs >= 0 && one.agents.workers >= 0) return {State::kUnkept, std::move(broken)};
    const AgentKind missing = one.agents.uavs < 0 ? AgentKind::kUav : AgentKind::kWorker;
    const auto& others = situation_.agents(missing);
    const bool some_busy = std::any_of(others.begin(), others.end(), [&](const AgentState& other) {
      return !other.idle(situation_.now_us);
    });
    if (!some_busy) return {State::kUnkept, std::move(broken)};
    KeepFor(free, task);
    return {State::kWaits, fmt::format("no {} is free that can do it", ToString(missing))};
  }

  /// Those who are free go ahead; nobody else gets the task.
  void KeepFor(const std::vector<const AgentState*>& free, TaskId task) {
    for (const AgentState* agent : free) GoAhead(*agent, task, {});
    result_.rest.task_status[task.index()] = TaskStatus::kHeld;
  }

  /// Why it cannot be at the task in time once it is free; "": it can.
  std::string TooLate(const AgentState& agent, TaskId id) const {
    const Task& task = site_.tasks[id.index()];
    const bool knows_end = agent.busy_until_us != kNever;
    const TimeUs from_us =
        knows_end ? std::max(situation_.now_us, agent.busy_until_us) : situation_.now_us;
    const TimeUs travel_us = TravelUs(agent.WayM(agent.to, task.at), agent.speed_m_s);
    const std::string name = fmt::format("{}:{}", ToString(agent.kind), agent.id);
    if (travel_us == kNever) return "no way leads " + name + " there";
    if (!CanBegin(task, from_us, travel_us)) return name + " cannot be there before it expires";
    const TimeUs latest_us = LatestEnd(agent, site_.rules);
    if (latest_us != kNever && from_us + travel_us > latest_us) {
      return name + " cannot be there before it leaves or the mission ends";
    }
    return "";
  }

  Outcome GoTo(const Directive& one) {
    const AgentKind kind = one.agent_kind();
    const AgentState* const agent = Find(kind, one.agents[kind]);
    if (agent == nullptr) return Absent(kind, one.agents[kind]);
    const Point goal = agent->ways->StopNear(kind, one.place).at;
    if (muster::IsOffLimits(site_.directives, kind, goal)) {
      return {State::kUnkept, "the place lies in an area that is forbidden to it"};
    }
    if (!IsFree(*agent)) return IsAt(*agent, goal) ? Outcome{State::kOver} : Busy(*agent);
    if (IsAt(*agent, goal)) {
      Hold(*agent);
      return {};
    }
    Action action = MakeStay(site_, *agent);
    action.kind = ActionKind::kGoTo;
    action.to = goal;
    if (!std::isfinite(agent->WayM(agent->to, action.to))) {
      return {State::kUnkept, "no way leads there"};
    }
    if (std::string why = Broken(action); !why.empty()) {
      return {State::kUnkept, std::move(why)};
    }
    Send(action);
    return {};
  }

  const Situation& situation_;
  const Site& site_;
  Directing result_;
  std::set<Key> standing_;  ///< agents of directives that stay where they are
  std::optional<ActionWeights> weights_;
};

}  // namespace

Directing Direct(const Situation& situation) { return Director(situation).Direct(); }

bool IsSentBy(const Action& action, const Directive& directive) {
  // Each agent is sent by one directive at most; what is not named there is a partner.
  using Kind = Directive::Kind;
  const bool fits = directive.kind == Kind::kPin ? action.task.value == directive.task
                    : directive.kind == Kind::kChargeNow
                        ? action.charge.valid()
                        : directive.kind == Kind::kGoTo && action.kind == ActionKind::kGoTo;
  return fits && std::all_of(std::begin(kAgentKinds), std::end(kAgentKinds), [&](AgentKind kind) {
           const std::int32_t named = directive.agents[kind], member = MemberOf(action, kind);
           return named < 0 || member < 0 || named == member;
         });
}

Decision Join(const Situation& situation, const Directing& directing, Decision rest) {
  std::vector<Action> actions = std::move(rest.actions);
  std::erase_if(actions, [&](const Action& action) {
    const AgentKind kind = action.uav.valid()      ? AgentKind::kUav
                           : action.worker.valid() ? AgentKind::kWorker
                                                   : AgentKind::kVehicle;
    return action.kind == ActionKind::kGoTo &&
           IsOffLimits(situation.site->directives, kind, action.to);
  });
  actions.insert(actions.end(), directing.actions.begin(), directing.actions.end());
  Decision decision = MakeDecision(
      std::move(actions), rest.candidates + static_cast<std::int64_t>(directing.actions.size()));
  decision.bound = rest.bound;
  for (const Action& action : directing.actions) decision.bound += action.weight;
  decision.refused = std::move(rest.refused);
  for (const DirectiveOutcome& outcome : directing.outcomes) {
    if (outcome.state != State::kUnkept) continue;
    decision.unkept.push_back(fmt::format("order {} ({}): {}", outcome.directive.order,
                                          ToString(outcome.directive), outcome.why));
  }
  return decision;
}

Decision DecideWithDirectives(const Situation& situation, Policy* policy) {
  if (situation.site->directives.empty()) return policy->Decide(situation);
  const Directing directing = Direct(situation);
  return Join(situation, directing, policy->Decide(directing.rest));
}

}  // namespace muster::scheduler
