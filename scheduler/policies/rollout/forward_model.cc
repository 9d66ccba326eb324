#include "scheduler/policies/rollout/forward_model.h"

#include <algorithm>

#include "base/check.h"

namespace muster::scheduler {
namespace {

/// null: it is not named.
AgentState* Find(Situation* situation, AgentKind kind, std::int32_t id) {
  if (id < 0) return nullptr;
  auto& agents = ByKind(kind, situation->uavs, situation->workers, situation->vehicles);
  const auto agent = std::lower_bound(agents.begin(), agents.end(), id,
                                      [](const AgentState& a, std::int32_t i) { return a.id < i; });
  MUSTER_CHECK(agent != agents.end() && agent->id == id, "{}:{}", ToString(kind), id);
  return &*agent;
}

}  // namespace

void CarryOut(const Action& action, Situation* situation) {
  AgentState* uav = Find(situation, AgentKind::kUav, action.uav.value);
  AgentState* worker = Find(situation, AgentKind::kWorker, action.worker.value);
  AgentState* vehicle = Find(situation, AgentKind::kVehicle, action.vehicle.value);
  for (AgentState* agent : {uav, worker, vehicle}) {
    if (agent != nullptr) {
      Begin(agent, action, situation->decision, situation->now_us, Disturbances(),
            situation->site->seed);
    }
  }
  if (!IsPair(action.kind)) return;
  AgentState* partner = action.kind == ActionKind::kSense ? worker : vehicle;
  const Activity activity = PlanActivity(*uav, *partner, situation->site->tasks);
  for (AgentState* agent : {uav, partner}) {
    agent->activity = activity;
    agent->busy_until_us = activity.end_us;
  }
  if (action.kind == ActionKind::kSense) {
    situation->task_status[action.task.index()] = TaskStatus::kReserved;
  } else {
    ++situation->charging_load[action.charge.index()];
  }
}

std::shared_ptr<const std::vector<AgentState>> ComingAgents(const Situation& situation) {
  const Site& site = *situation.site;
  auto coming = std::make_shared<std::vector<AgentState>>();
  for (const Shift& shift : site.shifts) {
    if (shift.spec.online_from_us <= situation.now_us) continue;
    coming->push_back(StartOf(shift.kind, shift.id, shift.spec, *site.ways));
    coming->back().measured.reset();  // the forecast computes it
  }
  return coming;
}

bool Future::MayBeDone(std::size_t task) const {
  const std::vector<TaskStatus>& status = situation.task_status;
  return IsToDo(status[task]) ||
         (status[task] == TaskStatus::kUnreported && task + expected >= status.size());
}

ForwardModel::ForwardModel(Future future) : future_(std::move(future)) {}

bool ForwardModel::anybody() const {
  const Situation& s = situation();
  return anybody_comes() || !s.uavs.empty() || !s.workers.empty() || !s.vehicles.empty();
}

void ForwardModel::Add(const AgentState& agent) {
  Situation& s = future_.situation;
  auto& agents = ByKind(agent.kind, s.uavs, s.workers, s.vehicles);
  const auto after = [](const AgentState& a, std::int32_t id) { return a.id < id; };
  agents.insert(std::lower_bound(agents.begin(), agents.end(), agent.id, after), agent);
}

void ForwardModel::Step(const std::vector<Action>& actions) {
  Situation& s = future_.situation;
  for (const Action& action : actions) CarryOut(action, &s);
  const Rules& rules = s.site->rules;
  ++s.decision;
  AdvanceTo(std::min(rules.NextDecisionUs(s.now_us), rules.limit_us));
}

void ForwardModel::AdvanceTo(TimeUs t) {
  Situation& s = future_.situation;
  s.now_us = t;
  for (const AgentState& uav : s.uavs) {
    if (uav.action == ActionKind::kNone || !uav.activity) continue;
    const Activity& activity = *uav.activity;
    const auto site = static_cast<std::size_t>(activity.site);
    if (activity.end_us > t) {
      if (activity.kind == Activity::Kind::kSensing && activity.start_us <= t) {
        s.task_status[site] = TaskStatus::kSensing;
      }
    } else if (activity.kind == Activity::Kind::kSensing) {
      s.task_status[site] = TaskStatus::kDone;
      done_.push_back(activity);
    } else {
      --s.charging_load[site];
    }
  }
  const std::vector<Task>& tasks = s.site->tasks;
  for (std::size_t x = tasks.size() - future_.expected; x < tasks.size(); ++x) {
    TaskStatus& status = s.task_status[x];
    if (status == TaskStatus::kUnreported && tasks[x].reported_us <= t) status = TaskStatus::kOpen;
  }
  const Verdict none;
  for (auto* agents : {&s.uavs, &s.workers, &s.vehicles}) {
    for (AgentState& agent : *agents) Settle(&agent, none, t, s.site->tasks);
    std::erase_if(*agents, [t](const AgentState& agent) {
      return agent.failed || (!agent.online(t) && agent.busy_until_us <= t);
    });
  }
  for (; anybody_comes(); ++come_) {
    const AgentState& agent = (*future_.coming)[come_];
    if (agent.online_from_us > t) break;
    if (agent.online(t)) Add(agent);
  }
}

}  // namespace muster::scheduler
