#include "scheduler/explain/exact.h"

#include <algorithm>

#include "base/index.h"
#include "scheduler/explain/forced.h"
#include "scheduler/solver/actions.h"
#include "scheduler/solver/solver.h"

namespace muster::scheduler {
namespace {

/// Index of the agent of that kind and id, or -1.
std::int32_t IndexOf(const std::vector<const AgentState*>& agents, AgentKind kind,
                     std::int32_t id) {
  for (std::size_t i = 0; i < agents.size(); ++i) {
    if (agents[i]->kind == kind && agents[i]->id == id) return static_cast<std::int32_t>(i);
  }
  return -1;
}

template <class Id>
std::int32_t IndexOf(const std::vector<Id>& ids, Id id) {
  const auto found = std::find(ids.begin(), ids.end(), id);
  return found == ids.end() ? -1 : static_cast<std::int32_t>(found - ids.begin());
}

}  // namespace

ExactDecisions::ExactDecisions(const Situation& situation)
    : situation_(situation), built_(BuildInstance(situation)) {
  const SolverResult solution = Solve(built_.instance);
  best_ = {solution.assignment.weight, std::max(solution.bound, solution.assignment.weight),
           ActionsOf(built_, solution.assignment, situation)};
}

std::optional<Optimum> ExactDecisions::Forced(const Demand& demand) const {
  PairDemand pair;
  if (demand.task.valid()) {
    pair.site = IndexOf(built_.tasks, demand.task);
    if (pair.site < 0) return {};
  } else if (demand.charge.valid()) {
    pair.site = IndexOf(built_.charges, demand.charge);
    if (pair.site < 0) return {};
    pair.site += built_.n_tasks();
  }
  if (demand.agent_kind) {
    const bool is_uav = *demand.agent_kind == AgentKind::kUav;
    std::int32_t& index = is_uav ? pair.uav : pair.partner;
    index = IndexOf(is_uav ? built_.uavs : built_.partners, *demand.agent_kind, demand.agent);
    if (index < 0) return {};
  }
  const auto forced = SolveWith(built_.instance, pair);
  if (!forced) return {};
  return Optimum{forced->weight, forced->bound, ActionsOf(built_, forced->assignment, situation_)};
}

}  // namespace muster::scheduler
