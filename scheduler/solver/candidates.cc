#include "scheduler/solver/candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "base/index.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;

/// Each site's partner arcs, ascending by partner.
std::vector<Index> ByPartner(const Instance& instance) {
  std::vector<Index> arcs(instance.partner_arcs.size());
  std::iota(arcs.begin(), arcs.end(), 0);
  for (std::size_t s = 0; s < instance.capacity.size(); ++s) {
    std::sort(arcs.begin() + instance.partner_begin[s],
              arcs.begin() + instance.partner_begin[s + 1], [&](Index a, Index b) {
                return instance.partner_arcs[At(a)].partner < instance.partner_arcs[At(b)].partner;
              });
  }
  return arcs;
}

void SetFoundation(Foundation foundation, const Situation& situation, BuiltInstance* built) {
  for (auto& arc : built->instance.uav_arcs) {
    const AgentState& uav = *built->uavs[At(arc.uav)];
    const double share = uav.range_full_m > 0 ? situation.range_m(uav) / uav.range_full_m : 0;
    arc.base =
        arc.missing_m < 0 ? SenseFoundation(foundation) : ChargeFoundation(foundation, share);
  }
}

Elements ElementsOf(const BuiltInstance& built, const Situation& situation) {
  Elements elements;
  elements.n_uavs = static_cast<int>(built.uavs.size());
  elements.n_workers = built.n_workers;
  elements.n_vehicles = static_cast<int>(built.partners.size()) - elements.n_workers;
  elements.n_tasks = built.n_tasks();
  elements.capacity.assign(At(elements.n_agents() + elements.n_tasks), 1);
  for (std::size_t y = 0; y < situation.site->charging_points.size(); ++y) {
    elements.capacity.push_back(situation.free_places(ChargeId(y)));
  }
  return elements;
}

/// Entry `id` is the index of the agent (task) with that id; -1: there is none.
void Note(Index id, Index index, std::vector<Index>* index_of_id) {
  if (At(id) >= index_of_id->size()) index_of_id->resize(At(id) + 1, -1);
  (*index_of_id)[At(id)] = index;
}

Index Look(const std::vector<Index>& index_of_id, Index id) {
  return id >= 0 && At(id) < index_of_id.size() ? index_of_id[At(id)] : -1;
}

}  // namespace

Candidates EnumerateCandidates(const Situation& situation, Foundation foundation) {
  Candidates list{BuildInstance(situation), {}, {}};
  if (foundation != Foundation::kHierarchical) SetFoundation(foundation, situation, &list.built);
  const BuiltInstance& built = list.built;
  const Instance& instance = built.instance;
  list.elements = ElementsOf(built, situation);

  const Index n_tasks = built.n_tasks(), n_workers = built.n_workers;
  const auto row_of = [&](Index p) { return p < n_workers ? p : p - n_workers; };
  const auto site_of = [&](Index s) {
    return s < n_tasks ? s : built.charges[At(s - n_tasks)].value;
  };
  const ArcsByAgent of_uav = UavArcsOf(instance), of_partner = PartnerArcsOf(instance);
  const std::vector<Index> by_partner = ByPartner(instance);
  std::vector<Node>& nodes = list.nodes;
  for (Index u = 0; u < instance.n_uavs(); ++u) {
    nodes.push_back({instance.uavs[At(u)].stay, u, -1, -1, ActionKind::kUavStays});
    for (Index k = of_uav.begin[At(u)]; k < of_uav.begin[At(u) + 1]; ++k) {
      const auto [s, i] = of_uav.site_arc[At(k)];
      const Instance::UavArc& arc = instance.uav_arcs[At(i)];
      const bool task = s < n_tasks;
      nodes.push_back(
          {arc.solo, u, -1, site_of(s), task ? ActionKind::kUavToTask : ActionKind::kUavToCharge});
      for (Index j = instance.partner_begin[At(s)]; j < instance.partner_begin[At(s) + 1]; ++j) {
        const auto& partner = instance.partner_arcs[At(by_partner[At(j)])];
        if (!instance.Compatible(arc, partner)) continue;
        nodes.push_back({Instance::PairWeight(arc, partner), u, row_of(partner.partner), site_of(s),
                         task ? ActionKind::kSense : ActionKind::kCharge});
      }
    }
  }
  for (Index p = 0; p < instance.n_partners(); ++p) {
    const bool worker = p < n_workers;
    nodes.push_back({instance.partners[At(p)].stay, -1, row_of(p), -1,
                     worker ? ActionKind::kWorkerStays : ActionKind::kVehicleStays});
    for (Index k = of_partner.begin[At(p)]; k < of_partner.begin[At(p) + 1]; ++k) {
      const auto [s, j] = of_partner.site_arc[At(k)];
      nodes.push_back({instance.partner_arcs[At(j)].gain, -1, row_of(p), site_of(s),
                       worker ? ActionKind::kWorkerToTask : ActionKind::kVehicleToCharge});
    }
  }
  return list;
}

const AgentState& Candidates::UavOf(const Node& node) const { return *built.uavs[At(node.uav)]; }

const AgentState& Candidates::PartnerOf(const Node& node) const {
  return *built.partners[At(IsCharging(node.kind) ? elements.n_workers + node.partner
                                                  : node.partner)];
}

Action Candidates::ToAction(const Situation& situation, const Node& node) const {
  const bool has_site = node.site >= 0, charging = IsCharging(node.kind);
  Action action = MakeAction(*situation.site, node.uav >= 0 ? &UavOf(node) : nullptr,
                             node.partner >= 0 ? &PartnerOf(node) : nullptr,
                             has_site && !charging ? built.tasks[At(node.site)] : TaskId(),
                             has_site && charging ? ChargeId(node.site) : ChargeId());
  action.weight = node.weight;
  return action;
}

std::string Candidates::NameOf(Index element) const {
  if (element < elements.n_agents()) {
    const AgentState& agent = element < elements.n_uavs
                                  ? *built.uavs[At(element)]
                                  : *built.partners[At(element - elements.n_uavs)];
    return fmt::format("{}:{}", ToString(agent.kind), agent.id);
  }
  const Index task = element - elements.task(0);
  if (task < elements.n_tasks) return fmt::format("task:{}", built.tasks[At(task)].value);
  return fmt::format("charge:{}", element - elements.charge(0));
}

ActionWeights::ActionWeights(const Situation& situation)
    : built_(BuildInstance(situation, 1, kExactPlaces, std::numeric_limits<std::size_t>::max())),
      of_uav_(UavArcsOf(built_.instance)),
      of_partner_(PartnerArcsOf(built_.instance)) {
  for (const auto* agents : {&built_.uavs, &built_.partners}) {
    for (std::size_t i = 0; i < agents->size(); ++i) {
      const AgentState& agent = *(*agents)[i];
      Note(agent.id, static_cast<Index>(i), &agent_of_id_[agent.kind]);
    }
  }
  for (Index x = 0; x < built_.n_tasks(); ++x) Note(built_.tasks[At(x)].value, x, &site_of_task_);
}

std::optional<double> ActionWeights::Of(const Action& action) const {
  const auto shape = ShapeOf(action.kind);
  if (!shape) return {};
  const Instance& instance = built_.instance;
  const bool has_partner = shape->worker || shape->vehicle;
  const Index u = Look(agent_of_id_.uavs, action.uav.value);
  const Index p = shape->worker ? Look(agent_of_id_.workers, action.worker.value)
                                : Look(agent_of_id_.vehicles, action.vehicle.value);
  if ((shape->uav && u < 0) || (has_partner && p < 0)) return {};
  if (IsStay(action.kind)) {
    return shape->uav ? instance.uavs[At(u)].stay : instance.partners[At(p)].stay;
  }
  const Index s = shape->task ? Look(site_of_task_, action.task.value)
                              : Look(built_.site_of_charge, action.charge.value);
  if (s < 0) return {};
  const Index i = shape->uav ? of_uav_.Find(u, s) : -1;
  const Index j = has_partner ? of_partner_.Find(p, s) : -1;
  if ((shape->uav && i < 0) || (has_partner && j < 0)) return {};
  if (!has_partner) return instance.uav_arcs[At(i)].solo;
  const Instance::PartnerArc& partner = instance.partner_arcs[At(j)];
  if (!shape->uav) return partner.gain;
  const Instance::UavArc& uav = instance.uav_arcs[At(i)];
  if (!instance.Compatible(uav, partner)) return {};
  return Instance::PairWeight(uav, partner);
}

}  // namespace muster::scheduler
