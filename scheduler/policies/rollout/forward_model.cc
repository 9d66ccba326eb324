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

ForwardModel::ForwardModel(const Situation& situation, std::size_t expected)
    : situation_(situation), expected_(expected) {}

bool ForwardModel::anybody() const {
  return !situation_.uavs.empty() || !situation_.workers.empty() || !situation_.vehicles.empty();
}

void ForwardModel::Add(const AgentState& agent) {
  auto& agents = ByKind(agent.kind, situation_.uavs, situation_.workers, situation_.vehicles);
  const auto after = [](const AgentState& a, std::int32_t id) { return a.id < id; };
  agents.insert(std::lower_bound(agents.begin(), agents.end(), agent.id, after), agent);
}

void ForwardModel::Step(const std::vector<Action>& actions) {
  for (const Action& action : actions) CarryOut(action, &situation_);
  const Rules& rules = situation_.site->rules;
  ++situation_.decision;
  AdvanceTo(std::min(situation_.now_us + rules.interval_us, rules.limit_us));
}

void ForwardModel::AdvanceTo(TimeUs t) {
  situation_.now_us = t;
  for (const AgentState& uav : situation_.uavs) {
    if (uav.action == ActionKind::kNone || !uav.activity) continue;
    const Activity& activity = *uav.activity;
    const auto site = static_cast<std::size_t>(activity.site);
    if (activity.end_us > t) {
      if (activity.kind == Activity::Kind::kSensing && activity.start_us <= t) {
        situation_.task_status[site] = TaskStatus::kSensing;
      }
    } else if (activity.kind == Activity::Kind::kSensing) {
      situation_.task_status[site] = TaskStatus::kDone;
      done_.push_back(activity);
    } else {
      --situation_.charging_load[site];
    }
  }
  const std::vector<Task>& tasks = situation_.site->tasks;
  for (std::size_t x = tasks.size() - expected_; x < tasks.size(); ++x) {
    TaskStatus& status = situation_.task_status[x];
    if (status == TaskStatus::kUnreported && tasks[x].reported_us <= t) status = TaskStatus::kOpen;
  }
  const Verdict none;
  for (auto* agents : {&situation_.uavs, &situation_.workers, &situation_.vehicles}) {
    for (AgentState& agent : *agents) Settle(&agent, none, t, situation_.site->tasks);
    std::erase_if(*agents, [t](const AgentState& agent) {
      return agent.failed || (!agent.online(t) && agent.busy_until_us <= t);
    });
  }
}

}  // namespace muster::scheduler
