#include "scheduler/explain/exact.h"

#include <algorithm>

#include "base/index.h"
#include "scheduler/solver/actions.h"
#include "scheduler/solver/solver.h"

namespace muster::scheduler {
namespace {

/// More than the nodes weigh together that one more pair can displace: those of its two agents and
/// of its site.
double MoreThanAnyLoss(const Instance& instance) {
  double stay = 0, uav = 0, partner = 0;
  for (const auto& u : instance.uavs) stay = std::max(stay, u.stay);
  for (const auto& p : instance.partners) stay = std::max(stay, p.stay);
  for (const auto& arc : instance.uav_arcs) {
    uav = std::max({uav, arc.solo, arc.base + arc.pair_gain});
  }
  for (const auto& arc : instance.partner_arcs) partner = std::max(partner, arc.gain);
  return 1 + 3 * (stay + uav + partner);
}

bool Meets(const Action& action, const Demand& demand) {
  if (!IsPair(action.kind)) return false;
  if (demand.task.valid() && action.task != demand.task) return false;
  if (demand.charge.valid() && action.charge != demand.charge) return false;
  if (!demand.agent_kind) return true;
  switch (*demand.agent_kind) {
    case AgentKind::kUav:
      return action.uav == UavId(demand.agent);
    case AgentKind::kWorker:
      return action.worker == WorkerId(demand.agent);
    case AgentKind::kVehicle:
      return action.vehicle == VehicleId(demand.agent);
  }
  return false;
}

}  // namespace

ExactDecisions::ExactDecisions(const Situation& situation)
    : situation_(situation), built_(BuildInstance(situation)) {
  const SolverResult solution = Solve(built_.instance);
  best_ = {solution.assignment.weight, std::max(solution.bound, solution.assignment.weight),
           ActionsOf(built_, solution.assignment, situation)};
}

std::optional<Optimum> ExactDecisions::Forced(const Demand& demand) const {
  BuiltInstance built = built_;
  Instance& instance = built.instance;
  const double bonus = MoreThanAnyLoss(instance);
  const auto is_agent = [&](const AgentState& agent) {
    return demand.agent_kind == agent.kind && demand.agent == agent.id;
  };
  const bool partner_demanded = demand.agent_kind && *demand.agent_kind != AgentKind::kUav;
  for (std::int32_t site = 0; site < instance.n_sites(); ++site) {
    const bool is_task = site < built.n_tasks();
    if (demand.task.valid() && !(is_task && built.tasks[At(site)] == demand.task)) continue;
    if (demand.charge.valid() &&
        !(!is_task && built.charges[At(site - built.n_tasks())] == demand.charge)) {
      continue;
    }
    for (auto i = instance.uav_begin[At(site)]; i < instance.uav_begin[At(site) + 1]; ++i) {
      auto& arc = instance.uav_arcs[At(i)];
      const bool meets = !demand.agent_kind || is_agent(*built.uavs[At(arc.uav)]);
      if (!partner_demanded && meets && arc.pair_gain != Instance::kNone) arc.pair_gain += bonus;
    }
    if (!partner_demanded) continue;
    for (auto j = instance.partner_begin[At(site)]; j < instance.partner_begin[At(site) + 1]; ++j) {
      auto& arc = instance.partner_arcs[At(j)];
      if (!is_agent(*built.partners[At(arc.partner)])) continue;
      arc.gain += bonus;
      arc.solo = false;  // its weight would have the bonus, too
    }
  }
  const SolverResult solution = Solve(instance);
  Optimum optimum;
  optimum.actions = ActionsOf(built_, solution.assignment, situation_);
  const bool met = std::any_of(optimum.actions.begin(), optimum.actions.end(),
                               [&](const Action& action) { return Meets(action, demand); });
  if (!met) return {};
  optimum.weight = WeightOf(built_.instance, solution.assignment);
  optimum.bound = std::max(solution.bound - bonus, optimum.weight);
  return optimum;
}

}  // namespace muster::scheduler
