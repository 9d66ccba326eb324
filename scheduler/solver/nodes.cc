#include "scheduler/solver/nodes.h"

#include <algorithm>
#include <utility>

#include "base/index.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;

/// Arcs of one side by agent, each agent's ascending by site.
struct ByAgent {
  std::vector<Index> begin;  ///< [n_agents + 1]
  std::vector<std::pair<Index, Index>> site_arc;

  template <class Arc, class AgentOf>
  ByAgent(Index n_agents, const std::vector<Index>& arc_begin, const std::vector<Arc>& arcs,
          const AgentOf& agent_of)
      : begin(At(n_agents) + 1, 0), site_arc(arcs.size()) {
    for (const Arc& arc : arcs) ++begin[At(agent_of(arc)) + 1];
    for (std::size_t a = 1; a < begin.size(); ++a) begin[a] += begin[a - 1];
    std::vector<Index> next(begin.begin(), begin.end() - 1);
    for (std::size_t s = 0; s + 1 < arc_begin.size(); ++s) {
      for (Index i = arc_begin[s]; i < arc_begin[s + 1]; ++i) {
        site_arc[At(next[At(agent_of(arcs[At(i)]))]++)] = {static_cast<Index>(s), i};
      }
    }
  }
};

}  // namespace

ArcNodes ListNodes(const Situation& situation, Foundation foundation) {
  ArcNodes list{BuildInstance(situation), {}, {}};
  const BuiltInstance& built = list.built;
  Instance& instance = list.built.instance;
  const Index n_tasks = built.n_tasks();
  if (foundation != Foundation::kHierarchical) {
    for (auto& arc : instance.uav_arcs) {
      const AgentState& uav = *built.uavs[At(arc.uav)];
      const double share = uav.range_full_m > 0 ? situation.range_m(uav) / uav.range_full_m : 0;
      arc.base =
          arc.missing_m < 0 ? SenseFoundation(foundation) : ChargeFoundation(foundation, share);
    }
  }
  Elements& elements = list.elements;
  elements.n_uavs = instance.n_uavs();
  elements.n_workers = static_cast<int>(
      std::find_if(built.partners.begin(), built.partners.end(),
                   [](const AgentState* p) { return p->kind == AgentKind::kVehicle; }) -
      built.partners.begin());
  elements.n_vehicles = instance.n_partners() - elements.n_workers;
  elements.n_tasks = n_tasks;
  elements.capacity.assign(At(elements.n_agents()), 1);
  elements.capacity.insert(elements.capacity.end(), instance.capacity.begin(),
                           instance.capacity.end());

  // Each site's partner arcs by partner.
  std::vector<Index> by_partner(instance.partner_arcs.size());
  for (std::size_t j = 0; j < by_partner.size(); ++j) by_partner[j] = static_cast<Index>(j);
  for (std::size_t s = 0; s < instance.capacity.size(); ++s) {
    std::sort(by_partner.begin() + instance.partner_begin[s],
              by_partner.begin() + instance.partner_begin[s + 1], [&](Index a, Index b) {
                return instance.partner_arcs[At(a)].partner < instance.partner_arcs[At(b)].partner;
              });
  }
  const ByAgent of_uav(instance.n_uavs(), instance.uav_begin, instance.uav_arcs,
                       [](const Instance::UavArc& arc) { return arc.uav; });
  const ByAgent of_partner(instance.n_partners(), instance.partner_begin, instance.partner_arcs,
                           [](const Instance::PartnerArc& arc) { return arc.partner; });
  const auto row_of = [&](Index p) { return p < elements.n_workers ? p : p - elements.n_workers; };
  const auto site_of = [&](Index s) { return s < n_tasks ? s : s - n_tasks; };
  std::vector<Node>& nodes = list.nodes;
  for (Index u = 0; u < instance.n_uavs(); ++u) {
    nodes.push_back({instance.uavs[At(u)].stay, u, -1, -1, ActionKind::kUavStays});
    for (Index k = of_uav.begin[At(u)]; k < of_uav.begin[At(u) + 1]; ++k) {
      const auto [s, i] = of_uav.site_arc[At(k)];
      const Instance::UavArc& arc = instance.uav_arcs[At(i)];
      const bool task = s < n_tasks;
      if (arc.solo != Instance::kNone) {
        nodes.push_back({arc.solo, u, -1, site_of(s),
                         task ? ActionKind::kUavToTask : ActionKind::kUavToCharge});
      }
      if (arc.pair_gain == Instance::kNone) continue;
      for (Index j = instance.partner_begin[At(s)]; j < instance.partner_begin[At(s) + 1]; ++j) {
        const auto& partner = instance.partner_arcs[At(by_partner[At(j)])];
        if (!instance.Compatible(arc, partner)) continue;
        nodes.push_back({Instance::PairWeight(arc, partner), u, row_of(partner.partner), site_of(s),
                         task ? ActionKind::kSense : ActionKind::kCharge});
      }
    }
  }
  for (Index p = 0; p < instance.n_partners(); ++p) {
    const bool worker = p < elements.n_workers;
    nodes.push_back({instance.partners[At(p)].stay, -1, row_of(p), -1,
                     worker ? ActionKind::kWorkerStays : ActionKind::kVehicleStays});
    for (Index k = of_partner.begin[At(p)]; k < of_partner.begin[At(p) + 1]; ++k) {
      const auto [s, j] = of_partner.site_arc[At(k)];
      const Instance::PartnerArc& arc = instance.partner_arcs[At(j)];
      if (!arc.solo) continue;
      nodes.push_back({arc.gain, -1, row_of(p), site_of(s),
                       worker ? ActionKind::kWorkerToTask : ActionKind::kVehicleToCharge});
    }
  }
  return list;
}

Action ArcNodes::ToAction(const Situation& situation, const Node& node) const {
  Action action;
  action.kind = node.kind;
  action.weight = node.weight;
  const AgentState* mover = nullptr;
  if (node.uav >= 0) {
    mover = built.uavs[At(node.uav)];
    action.uav = UavId(mover->id);
  }
  if (node.partner >= 0) {
    const bool vehicle = IsCharging(node.kind);
    const AgentState* partner =
        built.partners[At(vehicle ? elements.n_workers + node.partner : node.partner)];
    if (vehicle) {
      action.vehicle = VehicleId(partner->id);
    } else {
      action.worker = WorkerId(partner->id);
    }
    if (mover == nullptr) mover = partner;
  }
  if (node.site < 0) {
    action.to = PositionAt(*mover, situation.now_us);
  } else if (IsCharging(node.kind)) {
    action.charge = built.charges[At(node.site)];
    action.to = situation.site->charging_points[action.charge.index()].at;
  } else {
    action.task = built.tasks[At(node.site)];
    action.to = situation.site->tasks[action.task.index()].at;
  }
  return action;
}

}  // namespace muster::scheduler
