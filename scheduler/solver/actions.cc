#include "scheduler/solver/actions.h"

#include <algorithm>
#include <tuple>

#include "base/index.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;

}  // namespace

std::vector<Action> ActionsOf(const BuiltInstance& built, const Assignment& assignment,
                              const Situation& situation) {
  const Instance& instance = built.instance;
  const auto n_workers = static_cast<std::size_t>(
      std::find_if(built.partners.begin(), built.partners.end(),
                   [](const AgentState* p) { return p->kind == AgentKind::kVehicle; }) -
      built.partners.begin());
  std::vector<Action> actions;
  std::vector<bool> busy(built.partners.size(), false);
  const auto go = [&](Action* action, Index site) {
    if (site < built.n_tasks()) {
      action->task = built.tasks[At(site)];
      action->to = situation.site->tasks[action->task.index()].at;
    } else {
      action->charge = built.charges[At(site - built.n_tasks())];
      action->to = situation.site->charging_points[action->charge.index()].at;
    }
  };
  const auto name_partner = [&](Action* action, std::size_t p) {
    const std::int32_t id = built.partners[p]->id;
    if (p < n_workers) {
      action->worker = WorkerId(id);
    } else {
      action->vehicle = VehicleId(id);
    }
  };
  for (std::size_t u = 0; u < assignment.uavs.size(); ++u) {
    const Assignment::Choice& choice = assignment.uavs[u];
    Action action;
    action.uav = UavId(built.uavs[u]->id);
    if (choice.site < 0) {
      action.kind = ActionKind::kUavStays;
      action.to = PositionAt(*built.uavs[u], situation.now_us);
      action.weight = instance.uavs[u].stay;
    } else {
      const bool task = choice.site < built.n_tasks();
      const auto& arc = instance.uav_arcs[At(choice.uav_arc)];
      go(&action, choice.site);
      if (choice.partner_arc < 0) {
        action.kind = task ? ActionKind::kUavToTask : ActionKind::kUavToCharge;
        action.weight = arc.solo;
      } else {
        const auto& partner = instance.partner_arcs[At(choice.partner_arc)];
        action.kind = task ? ActionKind::kSense : ActionKind::kCharge;
        action.weight = Instance::PairWeight(arc, partner);
        name_partner(&action, At(partner.partner));
        busy[At(partner.partner)] = true;
      }
    }
    actions.push_back(action);
  }
  for (std::size_t p = 0; p < built.partners.size(); ++p) {
    if (busy[p]) continue;
    Action action;
    name_partner(&action, p);
    const bool worker = p < n_workers;
    const Index arc = assignment.partner_solo[p];
    if (arc < 0) {
      action.kind = worker ? ActionKind::kWorkerStays : ActionKind::kVehicleStays;
      action.to = PositionAt(*built.partners[p], situation.now_us);
      action.weight = instance.partners[p].stay;
    } else {
      const auto& begins = instance.partner_begin;
      const auto site = std::upper_bound(begins.begin(), begins.end(), arc) - begins.begin() - 1;
      go(&action, static_cast<Index>(site));
      action.kind = worker ? ActionKind::kWorkerToTask : ActionKind::kVehicleToCharge;
      action.weight = instance.partner_arcs[At(arc)].gain;
    }
    actions.push_back(action);
  }
  std::sort(actions.begin(), actions.end(), [](const Action& a, const Action& b) {
    return std::tie(a.kind, a.uav, a.worker, a.vehicle, a.task, a.charge) <
           std::tie(b.kind, b.uav, b.worker, b.vehicle, b.task, b.charge);
  });
  return actions;
}

}  // namespace muster::scheduler
