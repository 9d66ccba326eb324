#include "scheduler/explain/forced.h"

#include <algorithm>

#include "base/index.h"
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

bool Meets(const Instance& instance, const Assignment& assignment, const PairDemand& demand) {
  return std::any_of(
      assignment.uavs.begin(), assignment.uavs.end(), [&](const Assignment::Choice& choice) {
        if (choice.partner_arc < 0) return false;
        const auto& partner = instance.partner_arcs[At(choice.partner_arc)];
        return (demand.site < 0 || choice.site == demand.site) &&
               (demand.uav < 0 || instance.uav_arcs[At(choice.uav_arc)].uav == demand.uav) &&
               (demand.partner < 0 || partner.partner == demand.partner);
      });
}

}  // namespace

std::optional<ForcedAssignment> SolveWith(const Instance& instance, const PairDemand& demand) {
  Instance raised = instance;
  const double bonus = MoreThanAnyLoss(instance);
  for (std::int32_t site = 0; site < raised.n_sites(); ++site) {
    if (demand.site >= 0 && site != demand.site) continue;
    if (demand.partner < 0) {
      for (auto i = raised.uav_begin[At(site)]; i < raised.uav_begin[At(site) + 1]; ++i) {
        auto& arc = raised.uav_arcs[At(i)];
        const bool meets = demand.uav < 0 || arc.uav == demand.uav;
        if (meets && arc.pair_gain != Instance::kNone) arc.pair_gain += bonus;
      }
      continue;
    }
    for (auto j = raised.partner_begin[At(site)]; j < raised.partner_begin[At(site) + 1]; ++j) {
      auto& arc = raised.partner_arcs[At(j)];
      if (arc.partner != demand.partner) continue;
      arc.gain += bonus;
      arc.solo = false;  // its weight would have the bonus, too
    }
  }
  const SolverResult solution = Solve(raised);
  if (!Meets(instance, solution.assignment, demand)) return {};
  ForcedAssignment forced;
  forced.weight = WeightOf(instance, solution.assignment);
  forced.bound = std::max(solution.bound - bonus, forced.weight);
  forced.assignment = solution.assignment;
  return forced;
}

}  // namespace muster::scheduler
