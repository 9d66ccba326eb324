#include "scheduler/explain/explain.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace muster::scheduler {
namespace {

constexpr double kSame = 1e-6;  ///< weights closer than this are equal

bool AtSite(const Action& action, bool charging, std::int32_t site) {
  return charging ? action.charge.value == site : action.task.value == site;
}

const AgentState* Find(const std::vector<AgentState>& agents, std::int32_t id) {
  const auto found =
      std::lower_bound(agents.begin(), agents.end(), id,
                       [](const AgentState& a, std::int32_t wanted) { return a.id < wanted; });
  return found == agents.end() || found->id != id ? nullptr : &*found;
}

/// How far a place is from having a pair: less lacks less.
double Lack(const PlaceLook& look) {
  if (look.obstacle == Obstacle::kRange && look.nearest_range) {
    return look.nearest_range->needs_m() - look.nearest_range->range_m;
  }
  if (look.nearest_time) {
    return static_cast<double>(look.nearest_time->end_us - look.nearest_time->latest_us);
  }
  return 0;
}

}  // namespace

std::string_view ToString(TaskVerdict verdict) {
  constexpr std::string_view kNames[] = {"done",       "under way",  "chosen", "lost",
                                         "infeasible", "unreported", "expired"};
  return kNames[static_cast<int>(verdict)];
}

std::string_view ToString(AgentCondition condition) {
  constexpr std::string_view kNames[] = {"not yet online", "offline", "failed", "busy", "idle"};
  return kNames[static_cast<int>(condition)];
}

std::optional<Activity> UnderWayAt(const Situation& situation, TaskId task) {
  for (const AgentState& uav : situation.uavs) {
    if (uav.action != ActionKind::kSense || uav.target != task.value) continue;
    if (uav.busy_until_us <= situation.now_us) continue;
    if (uav.activity) return uav.activity;
    return Activity{
        Activity::Kind::kSensing, UavId(uav.id), uav.partner, task.value, kNever, kNever};
  }
  return {};
}

AgentCondition ConditionOf(const Situation& situation, AgentKind kind, std::int32_t id,
                           const AgentSpec& spec, std::optional<AgentState>* state) {
  const TimeUs now = situation.now_us;
  if (const AgentState* agent = Find(situation.agents(kind), id)) {
    *state = *agent;
    return agent->idle(now) ? AgentCondition::kIdle : AgentCondition::kBusy;
  }
  if (now < spec.online_from_us) return AgentCondition::kNotYetOnline;
  return now < spec.online_until_us ? AgentCondition::kFailed : AgentCondition::kOffline;
}

Action CommandTo(const Situation& situation, const std::vector<Action>& commanded, AgentKind kind,
                 std::int32_t id) {
  for (const Action& action : commanded) {
    if (MemberOf(action, kind) == id) return action;
  }
  Action stay;
  switch (kind) {
    case AgentKind::kUav:
      stay.kind = ActionKind::kUavStays;
      stay.uav = UavId(id);
      break;
    case AgentKind::kWorker:
      stay.kind = ActionKind::kWorkerStays;
      stay.worker = WorkerId(id);
      break;
    case AgentKind::kVehicle:
      stay.kind = ActionKind::kVehicleStays;
      stay.vehicle = VehicleId(id);
      break;
  }
  if (const AgentState* agent = Find(situation.agents(kind), id)) stay.to = agent->to;
  return stay;
}

std::vector<AgentAnswer::Blocked> BlockedOf(const std::vector<PlaceLook>& places) {
  std::map<std::pair<Obstacle, bool>, AgentAnswer::Blocked> groups;
  for (const PlaceLook& place : places) {
    if (place.obstacle == Obstacle::kNone) continue;
    auto [entry, is_new] = groups.try_emplace({place.obstacle, place.charging});
    AgentAnswer::Blocked& group = entry->second;
    ++group.places;
    if (is_new || Lack(place) < Lack(group.nearest)) group.nearest = place;
    group.obstacle = place.obstacle;
    group.charging = place.charging;
  }
  std::vector<AgentAnswer::Blocked> blocked;
  for (const auto& [key, group] : groups) blocked.push_back(group);
  return blocked;
}

Explainer::Explainer(const Situation& situation, std::vector<Action> commanded)
    : situation_(situation),
      commanded_(std::move(commanded)),
      look_(situation),
      exact_(situation) {}

Action Explainer::DoneBy(AgentKind kind, std::int32_t id) const {
  Action action = CommandTo(situation_, commanded_, kind, id);
  const bool logged = std::find(commanded_.begin(), commanded_.end(), action) != commanded_.end();
  if (!logged) action.weight = look_.WeightOf(action).value_or(0);
  return action;
}

Option Explainer::MakeOption(const PlaceLook& look, const PairLook& pair) const {
  Option option{pair, look.charging, look.site, {}, {}, {}};
  const AgentKind partner = look.charging ? AgentKind::kVehicle : AgentKind::kWorker;
  option.uav_did = DoneBy(AgentKind::kUav, pair.uav.value);
  option.partner_did = DoneBy(partner, pair.partner);
  for (const Action& action : commanded_) {
    if (IsPair(action.kind) && AtSite(action, look.charging, look.site)) {
      option.site_holder = action;
    }
  }
  return option;
}

std::optional<Forcing> Explainer::Force(const Demand& demand) const {
  auto with = exact_.Forced(demand);
  if (!with) return {};
  const Optimum& best = exact_.best();
  Forcing forcing;
  forcing.cost = std::max(0.0, best.weight - with->weight);
  forcing.cost_low = std::max(0.0, best.weight - with->bound);
  forcing.cost_high = std::max(0.0, best.bound - with->weight);
  forcing.exact = best.proven() && with->proven();
  if (forcing.exact && forcing.cost < kSame) forcing.cost = 0;
  for (const Action& action : with->actions) {
    if (!IsPair(action.kind)) continue;
    const bool meets = (!demand.task.valid() || action.task == demand.task) &&
                       (!demand.charge.valid() || action.charge == demand.charge) &&
                       (!demand.agent_kind || MemberOf(action, *demand.agent_kind) == demand.agent);
    if (meets) forcing.pair = action;
  }
  const auto senses = [](const std::vector<Action>& actions, TaskId task) {
    return std::any_of(actions.begin(), actions.end(), [task](const Action& a) {
      return a.kind == ActionKind::kSense && a.task == task;
    });
  };
  for (const Action& action : best.actions) {
    if (action.kind == ActionKind::kSense && !senses(with->actions, action.task)) {
      forcing.displaced.push_back(action.task);
    }
  }
  std::sort(forcing.displaced.begin(), forcing.displaced.end());
  forcing.with = std::move(*with);
  return forcing;
}

TaskAnswer Explainer::AboutTask(TaskId task) const {
  TaskAnswer answer;
  const TaskStatus status = situation_.task_status[task.index()];
  if (status == TaskStatus::kDone) {
    answer.verdict = TaskVerdict::kDone;
    return answer;
  }
  if (!IsToDo(status)) {
    answer.verdict =
        status == TaskStatus::kExpired ? TaskVerdict::kExpired : TaskVerdict::kUnreported;
    return answer;
  }
  if (status != TaskStatus::kOpen) {
    answer.verdict = TaskVerdict::kUnderWay;
    answer.activity = UnderWayAt(situation_, task);
    return answer;
  }
  for (const Action& action : commanded_) {
    if (action.task == task) answer.commanded.push_back(action);
  }
  answer.look = look_.AtTask(task);
  if (std::any_of(answer.commanded.begin(), answer.commanded.end(),
                  [](const Action& a) { return IsPair(a.kind); })) {
    answer.verdict = TaskVerdict::kChosen;
    return answer;
  }
  if (answer.look.obstacle != Obstacle::kNone) return answer;
  answer.verdict = TaskVerdict::kLost;
  for (const PairLook& pair : answer.look.best) {
    answer.options.push_back(MakeOption(answer.look, pair));
  }
  for (const Action& action : commanded_) {
    if (IsStay(action.kind)) continue;
    const bool holds =
        (action.uav.valid() && look_.AtTask(task, action.uav).pairs_feasible > 0) ||
        (action.worker.valid() && look_.AtTask(task, {}, action.worker).pairs_feasible > 0);
    if (holds) answer.rivals.push_back(action);
  }
  Demand demand;
  demand.task = task;
  answer.forcing = Force(demand);
  return answer;
}

AgentAnswer Explainer::AboutAgent(AgentKind kind, std::int32_t id, const AgentSpec& spec) const {
  AgentAnswer answer;
  answer.condition = ConditionOf(situation_, kind, id, spec, &answer.state);
  if (answer.condition != AgentCondition::kIdle) return answer;
  answer.did = DoneBy(kind, id);

  const std::vector<PlaceLook> places = PlacesOf(look_, situation_, kind, id);
  std::vector<const PlaceLook*> others;
  for (const PlaceLook& place : places) {
    if (place.obstacle != Obstacle::kNone) continue;
    ++answer.places_feasible;
    const bool commanded =
        IsPair(answer.did->kind) && AtSite(*answer.did, place.charging, place.site);
    if (!commanded) others.push_back(&place);
  }
  answer.blocked = BlockedOf(places);
  std::stable_sort(others.begin(), others.end(), [](const PlaceLook* a, const PlaceLook* b) {
    return a->best.front().weight > b->best.front().weight;
  });
  if (others.size() > AgentAnswer::kOptions) others.resize(AgentAnswer::kOptions);
  for (const PlaceLook* place : others) {
    answer.options.push_back(MakeOption(*place, place->best.front()));
    Demand demand;
    demand.agent_kind = kind;
    demand.agent = id;
    (place->charging ? demand.charge.value : demand.task.value) = place->site;
    answer.forcings.push_back(Force(demand));
  }
  return answer;
}

DecisionQuality Explainer::Quality() const {
  DecisionQuality quality;
  quality.best = exact_.best();
  for (const AgentKind kind : kAgentKinds) {
    for (const AgentState& agent : situation_.agents(kind)) {
      if (!agent.idle(situation_.now_us)) continue;
      const Action action = DoneBy(kind, agent.id);
      // A pair counts once, with its UAV.
      if (IsPair(action.kind) && kind != AgentKind::kUav) continue;
      const std::optional<double> weight = look_.WeightOf(action);
      quality.weight += weight.value_or(0);
      if (!weight || std::abs(*weight - action.weight) > kSame) quality.own_weights = true;
    }
  }
  return quality;
}

}  // namespace muster::scheduler
