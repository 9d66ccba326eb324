#include "scheduler/solver/actions.h"

#include <algorithm>
#include <tuple>

#include "base/index.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;

/// By the indices of the instance; -1: none.
Action ActionOf(const BuiltInstance& built, const Situation& situation, Index uav, Index partner,
                Index site, double weight) {
  const Index charge = site - built.n_tasks();
  Action action = MakeAction(*situation.site, uav >= 0 ? built.uavs[At(uav)] : nullptr,
                             partner >= 0 ? built.partners[At(partner)] : nullptr,
                             site >= 0 && charge < 0 ? built.tasks[At(site)] : TaskId(),
                             site >= 0 && charge >= 0 ? built.charges[At(charge)] : ChargeId());
  action.weight = weight;
  return action;
}

}  // namespace

std::vector<Action> ActionsOf(const BuiltInstance& built, const Assignment& assignment,
                              const Situation& situation) {
  const Instance& instance = built.instance;
  std::vector<Action> actions;
  std::vector<bool> busy(built.partners.size(), false);
  for (Index u = 0; u < instance.n_uavs(); ++u) {
    const Assignment::Choice& choice = assignment.uavs[At(u)];
    Index partner = -1;
    double weight = instance.uavs[At(u)].stay;
    if (choice.site >= 0) {
      const auto& arc = instance.uav_arcs[At(choice.uav_arc)];
      weight = arc.solo;
      if (choice.partner_arc >= 0) {
        const auto& partner_arc = instance.partner_arcs[At(choice.partner_arc)];
        weight = Instance::PairWeight(arc, partner_arc);
        partner = partner_arc.partner;
        busy[At(partner)] = true;
      }
    }
    actions.push_back(ActionOf(built, situation, u, partner, choice.site, weight));
  }
  for (Index p = 0; p < instance.n_partners(); ++p) {
    if (busy[At(p)]) continue;
    const Index arc = assignment.partner_solo[At(p)];
    const auto& begins = instance.partner_begin;
    const auto site =
        arc < 0 ? -1 : std::upper_bound(begins.begin(), begins.end(), arc) - begins.begin() - 1;
    const double weight =
        arc < 0 ? instance.partners[At(p)].stay : instance.partner_arcs[At(arc)].gain;
    actions.push_back(ActionOf(built, situation, -1, p, static_cast<Index>(site), weight));
  }
  std::sort(actions.begin(), actions.end(), [](const Action& a, const Action& b) {
    return std::tie(a.kind, a.uav, a.worker, a.vehicle, a.task, a.charge) <
           std::tie(b.kind, b.uav, b.worker, b.vehicle, b.task, b.charge);
  });
  return actions;
}

}  // namespace muster::scheduler
