#include "scheduler/policy.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace muster::scheduler {

Action MakeAction(const Site& site, const AgentState* uav, const AgentState* partner, TaskId task,
                  ChargeId charge) {
  // What the action is called: of the UAV alone, of the partner alone, of both.
  const auto kind = [&](ActionKind of_uav, ActionKind of_partner, ActionKind of_both) {
    return uav == nullptr ? of_partner : partner == nullptr ? of_uav : of_both;
  };
  Action action;
  action.task = task;
  action.charge = charge;
  if (uav != nullptr) action.uav = UavId(uav->id);
  const bool is_worker = partner != nullptr && partner->kind == AgentKind::kWorker;
  if (is_worker) action.worker = WorkerId(partner->id);
  if (partner != nullptr && !is_worker) action.vehicle = VehicleId(partner->id);
  if (task.valid()) {
    action.kind = kind(ActionKind::kUavToTask, ActionKind::kWorkerToTask, ActionKind::kSense);
    action.to = site.tasks[task.index()].at;
  } else if (charge.valid()) {
    action.kind = kind(ActionKind::kUavToCharge, ActionKind::kVehicleToCharge, ActionKind::kCharge);
    action.to = site.charging_points[charge.index()].at;
  } else {
    const ActionKind stays = is_worker ? ActionKind::kWorkerStays : ActionKind::kVehicleStays;
    action.kind = kind(ActionKind::kUavStays, stays, ActionKind::kNone);
    action.to = (uav != nullptr ? uav : partner)->to;
  }
  return action;
}

Action MakeStay(const Site& site, const AgentState& agent) {
  const bool is_uav = agent.kind == AgentKind::kUav;
  return MakeAction(site, is_uav ? &agent : nullptr, is_uav ? nullptr : &agent, {}, {});
}

void SortActions(std::vector<Action>* actions) {
  const auto key = [](const Action& a) {
    return std::tuple(a.kind, a.uav, a.worker, a.vehicle, a.task, a.charge);
  };
  std::sort(actions->begin(), actions->end(),
            [&key](const Action& a, const Action& b) { return key(a) < key(b); });
}

Decision MakeDecision(std::vector<Action> actions, std::int64_t candidates) {
  Decision decision;
  decision.candidates = candidates;
  decision.actions = std::move(actions);
  SortActions(&decision.actions);
  for (const Action& action : decision.actions) decision.weight += action.weight;
  return decision;
}

}  // namespace muster::scheduler
