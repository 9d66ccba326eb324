#include "scheduler/candidates.h"

#include <algorithm>

#include "base/index.h"
#include "model/feasibility.h"

namespace muster::scheduler {
namespace {

TimeUs Later(TimeUs t, TimeUs duration) { return duration > kNever - t ? kNever : t + duration; }

}  // namespace

Feasibility::Feasibility(const Situation& situation, const Weights& weights)
    : situation_(&situation), weights_(&weights) {
  const Rules& rules = situation.site->rules;
  for (const std::int32_t i : weights.uavs) {
    uavs_.push_back(&situation.uavs[at(i)]);
    uav_latest_.push_back(LatestEnd(*uavs_.back(), rules));
  }
  for (const std::int32_t i : weights.workers) {
    worker_latest_.push_back(LatestEnd(situation.workers[at(i)], rules));
  }
  for (const std::int32_t i : weights.vehicles) {
    vehicles_.push_back(&situation.vehicles[at(i)]);
    vehicle_latest_.push_back(LatestEnd(*vehicles_.back(), rules));
  }
  for (std::size_t y = 0; y < situation.site->charging_points.size(); ++y) {
    free_places_.push_back(situation.free_places(ChargeId(y)));
  }
}

bool Feasibility::Arrives(TimeUs travel_us, TimeUs latest) const {
  return EndsBy(Later(situation_->now_us, travel_us), latest);
}

TimeUs Feasibility::SenseEnd(int u, int x, int w) const {
  const TimeUs travel =
      std::max(weights_->uav_task.travel_us(u, x), weights_->worker_task.travel_us(w, x));
  const Task& task = situation_->site->tasks[weights_->tasks[at(x)].index()];
  return Later(Later(situation_->now_us, travel), SensingUs(task.cost_m, uavs_[at(u)]->speed_m_s));
}

TimeUs Feasibility::ChargeEnd(int u, int y, int v) const {
  const TimeUs travel =
      std::max(weights_->uav_charge.travel_us(u, y), weights_->vehicle_charge.travel_us(v, y));
  const double on_arrival = std::max(0.0, weights_->range_m(u) - weights_->uav_charge.way_m(u, y));
  return Later(Later(situation_->now_us, travel), ChargingUs(uavs_[at(u)]->range_full_m, on_arrival,
                                                             vehicles_[at(v)]->charge_rate_m_s));
}

Elements ElementsOf(const Weights& weights, const Feasibility& feasible) {
  Elements elements;
  elements.n_uavs = weights.n_uavs();
  elements.n_workers = weights.n_workers();
  elements.n_vehicles = weights.n_vehicles();
  elements.n_tasks = weights.n_tasks();
  elements.capacity.assign(At(elements.n_agents()) + At(elements.n_tasks), 1);
  for (int y = 0; y < weights.n_charging_points(); ++y) {
    elements.capacity.push_back(feasible.free_places(y));
  }
  return elements;
}

Action ToAction(const Situation& situation, const Weights& weights, const Node& node) {
  Action action;
  action.kind = node.kind;
  action.weight = node.weight;
  const AgentState* mover = nullptr;
  if (node.uav >= 0) {
    mover =
        &situation.uavs[static_cast<std::size_t>(weights.uavs[static_cast<std::size_t>(node.uav)])];
    action.uav = UavId(mover->id);
  }
  if (node.partner >= 0) {
    const bool vehicle = IsCharging(node.kind);
    const auto row = static_cast<std::size_t>(node.partner);
    const AgentState& partner =
        vehicle ? situation.vehicles[static_cast<std::size_t>(weights.vehicles[row])]
                : situation.workers[static_cast<std::size_t>(weights.workers[row])];
    if (vehicle) {
      action.vehicle = VehicleId(partner.id);
    } else {
      action.worker = WorkerId(partner.id);
    }
    if (mover == nullptr) mover = &partner;
  }
  switch (node.kind) {
    case ActionKind::kUavToTask:
    case ActionKind::kWorkerToTask:
    case ActionKind::kSense:
      action.task = weights.tasks[static_cast<std::size_t>(node.site)];
      action.to = situation.site->tasks[action.task.index()].at;
      break;
    case ActionKind::kUavToCharge:
    case ActionKind::kVehicleToCharge:
    case ActionKind::kCharge:
      action.charge = ChargeId(node.site);
      action.to = situation.site->charging_points[action.charge.index()].at;
      break;
    default:
      action.to = mover->to;
  }
  return action;
}

Action Candidates::ToAction(const Situation& situation, const Node& node) const {
  return scheduler::ToAction(situation, weights, node);
}

Candidates EnumerateCandidates(const Situation& situation, Foundation foundation) {
  Candidates candidates;
  candidates.weights = ComputeWeights(situation, foundation);
  const Feasibility feasible(situation, candidates.weights);
  candidates.elements = ElementsOf(candidates.weights, feasible);
  VisitCandidates(candidates.weights, feasible,
                  [&candidates](const Node& node) { candidates.nodes.push_back(node); });
  return candidates;
}

}  // namespace muster::scheduler
