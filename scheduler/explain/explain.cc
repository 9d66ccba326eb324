#include "scheduler/explain/explain.h"

#include <algorithm>
#include <map>
#include <utility>

namespace muster::scheduler {
namespace {

bool IsPairAction(const Action& action) { return IsPair(action.kind); }

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

/// An agent's state, if it is online or under way, and its condition.
AgentCondition ConditionOf(const Situation& situation, AgentKind kind, std::int32_t id,
                           const AgentSpec& spec, std::optional<AgentState>* state) {
  const TimeUs now = situation.now_us;
  if (const AgentState* agent = FindAgent(situation, kind, id)) {
    *state = *agent;
    if (agent->not_ready()) return AgentCondition::kNotReady;
    return agent->idle(now) ? AgentCondition::kIdle : AgentCondition::kBusy;
  }
  if (now < spec.online_from_us) return AgentCondition::kNotYetOnline;
  return now < spec.online_until_us ? AgentCondition::kFailed : AgentCondition::kOffline;
}

/// Groups the places where an agent has no pair, by obstacle and kind of place.
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

}  // namespace

std::string_view ToString(Terms terms) { return terms == Terms::kPaper ? "paper" : "horizon"; }

std::string_view ToString(TaskVerdict verdict) {
  constexpr std::string_view kNames[] = {"done",       "under way",  "chosen",    "planned",
                                         "lost",       "outbid",     "worthless", "infeasible",
                                         "impossible", "unreported", "expired"};
  return kNames[static_cast<int>(verdict)];
}

std::string_view ToString(AgentCondition condition) {
  constexpr std::string_view kNames[] = {"not yet online", "offline", "failed",
                                         "not ready",      "busy",    "idle"};
  return kNames[static_cast<int>(condition)];
}

const AgentState* FindAgent(const Situation& situation, AgentKind kind, std::int32_t id) {
  const auto& agents = situation.agents(kind);
  const auto found =
      std::lower_bound(agents.begin(), agents.end(), id,
                       [](const AgentState& a, std::int32_t wanted) { return a.id < wanted; });
  return found == agents.end() || found->id != id ? nullptr : &*found;
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

Action Score::DoneBy(AgentKind kind, std::int32_t id) const {
  for (const Action& action : commanded()) {
    if (MemberOf(action, kind) == id) return action;
  }
  Action stay;
  constexpr PerKind<ActionKind> kStays = {ActionKind::kUavStays, ActionKind::kWorkerStays,
                                          ActionKind::kVehicleStays};
  stay.kind = kStays[kind];
  ByKind(kind, stay.uav.value, stay.worker.value, stay.vehicle.value) = id;
  if (const AgentState* agent = FindAgent(look().situation(), kind, id)) stay.to = agent->to;
  return stay;
}

Forcing Score::ForcingOf(const Optimum& best, Optimum with) {
  constexpr double kSame = 1e-6;  // weights closer than this are equal
  Forcing forcing;
  forcing.cost = std::max(0.0, best.weight - with.weight);
  forcing.cost_low = std::max(0.0, best.weight - with.bound);
  forcing.cost_high = std::max(0.0, best.bound - with.weight);
  forcing.exact = best.proven() && with.proven();
  if (forcing.exact && forcing.cost < kSame) forcing.cost = 0;
  forcing.with = std::move(with);
  return forcing;
}

Option Explainer::MakeOption(const PlaceLook& look, const PairLook& pair) const {
  Option option;
  option.pair = pair;
  option.charging = look.charging;
  option.site = look.site;
  score_->Oppose(&option);
  return option;
}

std::vector<Action> Explainer::HoldersOf(TaskId task) const {
  std::vector<Action> holders;
  for (const Action& action : score_->commanded()) {
    if (IsStay(action.kind)) continue;
    const Look& look = score_->look();
    const bool holds =
        (action.uav.valid() && look.AtTask(task, action.uav).pairs_feasible > 0) ||
        (action.worker.valid() && look.AtTask(task, {}, action.worker).pairs_feasible > 0);
    if (holds) holders.push_back(action);
  }
  return holders;
}

bool Explainer::TellPlan(TaskId task, TaskAnswer* answer) const {
  const auto plan = std::find_if(plans_.begin(), plans_.end(), [task](const PairPlan& pair) {
    return pair.at(false, task.value);
  });
  if (plan == plans_.end()) return true;
  answer->verdict = TaskVerdict::kPlanned;
  answer->plan = *plan;
  answer->commanded.clear();
  for (const Action& action : score_->commanded()) {
    if (action.uav == plan->uav || MemberOf(action, AgentKind::kWorker) == plan->partner) {
      answer->commanded.push_back(action);
    }
  }
  return plan->second;
}

TaskAnswer Explainer::AboutTask(TaskId task) const {
  TaskAnswer answer;
  const TaskStatus status = situation().task_status[task.index()];
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
    answer.activity = UnderWayAt(situation(), task);
    return answer;
  }
  answer.verdict = by_paper() ? TaskVerdict::kInfeasible : TaskVerdict::kImpossible;
  answer.look = score_->look().AtTask(task);
  for (const Action& action : score_->commanded()) {
    if (action.task == task) answer.commanded.push_back(action);
  }
  if (std::any_of(answer.commanded.begin(), answer.commanded.end(), IsPairAction)) {
    answer.verdict = TaskVerdict::kChosen;
    return answer;
  }
  if (!TellPlan(task, &answer) || answer.look.obstacle != Obstacle::kNone) return answer;
  if (!answer.plan) {
    answer.verdict = by_paper()                            ? TaskVerdict::kLost
                     : answer.look.best.front().weight > 0 ? TaskVerdict::kOutbid
                                                           : TaskVerdict::kWorthless;
  }
  for (const PairLook& pair : answer.look.best) {
    answer.options.push_back(MakeOption(answer.look, pair));
  }
  if (by_paper()) answer.rivals = HoldersOf(task);
  Demand demand;
  demand.task = task;
  answer.forcing = score_->Force(demand);
  return answer;
}

void Explainer::AddOptions(AgentKind kind, std::int32_t id, const std::vector<PlaceLook>& places,
                           AgentAnswer* answer) const {
  const auto sent_to = [&](const PlaceLook& place) {
    if (by_paper() && IsPair(answer->did->kind)) {
      return (place.charging ? answer->did->charge.value : answer->did->task.value) == place.site;
    }
    return std::any_of(answer->plans.begin(), answer->plans.end(), [&](const PairPlan& pair) {
      return !pair.second && pair.at(place.charging, place.site);
    });
  };
  std::vector<const PlaceLook*> others;
  for (const PlaceLook& place : places) {
    if (place.obstacle != Obstacle::kNone) continue;
    ++answer->places_feasible;
    if (!sent_to(place)) others.push_back(&place);
  }
  std::stable_sort(others.begin(), others.end(), [](const PlaceLook* a, const PlaceLook* b) {
    return a->best.front().weight > b->best.front().weight;
  });
  if (others.size() > AgentAnswer::kOptions) others.resize(AgentAnswer::kOptions);
  for (const PlaceLook* place : others) {
    Option& option = answer->options.emplace_back(MakeOption(*place, place->best.front()));
    Demand demand;
    demand.agent_kind = kind;
    demand.agent = id;
    (place->charging ? demand.charge.value : demand.task.value) = place->site;
    option.forcing = score_->Force(demand);
  }
}

AgentAnswer Explainer::AboutAgent(AgentKind kind, std::int32_t id, const AgentSpec& spec) const {
  AgentAnswer answer;
  answer.condition = ConditionOf(situation(), kind, id, spec, &answer.state);
  if (answer.condition == AgentCondition::kIdle) answer.did = score_->DoneBy(kind, id);
  const Look& look = score_->look();
  const std::int32_t index = look.IndexOf(kind, id);
  if (index < 0) return answer;
  const Participant& participant = look.participants()[kind][static_cast<std::size_t>(index)];
  if (!participant.idle) answer.free_us = participant.ready_us;
  for (const PairPlan& pair : plans_) {
    if (pair.has(kind, id)) answer.plans.push_back(pair);
  }
  const std::vector<PlaceLook> places = look.PlacesOf(kind, id);
  answer.blocked = BlockedOf(places);
  AddOptions(kind, id, places, &answer);
  return answer;
}

}  // namespace muster::scheduler
