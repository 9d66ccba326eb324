#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "model/action.h"
#include "scheduler/situation.h"
#include "scheduler/weights.h"

namespace muster::scheduler {

/// Which actions are feasible now, one by one and without enumerating pairs. Rows and columns are
/// those of Weights. An action is feasible when its agents are idle, its task is open or its
/// charging point has a free place, constraints (5) and (6) hold, and, in availability mode strict,
/// it ends by every participant's LatestEnd (a pair's activity ends, a solo move arrives).
class Feasibility {
 public:
  /// Both must outlive this.
  Feasibility(const Situation& situation, const Weights& weights);

  bool UavToTask(int u, int x) const {
    return weights_->senseable(u, x) &&
           Arrives(weights_->uav_task.travel_us(u, x), uav_latest_[at(u)]);
  }
  bool WorkerToTask(int w, int x) const {
    return Arrives(weights_->worker_task.travel_us(w, x), worker_latest_[at(w)]);
  }
  bool UavToCharge(int u, int y) const {
    return free_places_[at(y)] > 0 && weights_->chargeable(u, y) &&
           Arrives(weights_->uav_charge.travel_us(u, y), uav_latest_[at(u)]);
  }
  bool VehicleToCharge(int v, int y) const {
    return free_places_[at(y)] > 0 &&
           Arrives(weights_->vehicle_charge.travel_us(v, y), vehicle_latest_[at(v)]);
  }
  /// Whether the pair may sense, constraint (6) included.
  bool Sense(int u, int x, int w) const {
    return weights_->senseable(u, x) &&
           EndsBy(SenseEnd(u, x, w), std::min(uav_latest_[at(u)], worker_latest_[at(w)]));
  }
  /// Whether the pair may charge, constraint (5) included.
  bool Charge(int u, int y, int v) const {
    return free_places_[at(y)] > 0 && weights_->chargeable(u, y) &&
           EndsBy(ChargeEnd(u, y, v), std::min(uav_latest_[at(u)], vehicle_latest_[at(v)]));
  }

  /// When the pair would be done, as PlanActivity: the later arrival plus the duration.
  TimeUs SenseEnd(int u, int x, int w) const;
  TimeUs ChargeEnd(int u, int y, int v) const;

  /// LatestEnd of the idle agents.
  TimeUs uav_latest(int u) const { return uav_latest_[at(u)]; }
  TimeUs worker_latest(int w) const { return worker_latest_[at(w)]; }
  TimeUs vehicle_latest(int v) const { return vehicle_latest_[at(v)]; }
  /// Free places of charging point y; a large number when unlimited.
  std::int32_t free_places(int y) const { return free_places_[at(y)]; }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  bool Arrives(TimeUs travel_us, TimeUs latest) const;
  /// What would never end is not offered in either availability mode.
  static bool EndsBy(TimeUs end, TimeUs latest) { return end != kNever && end <= latest; }

  const Situation* situation_;
  const Weights* weights_;
  std::vector<TimeUs> uav_latest_, worker_latest_, vehicle_latest_;
  std::vector<std::int32_t> free_places_;
  std::vector<const AgentState*> uavs_, vehicles_;
};

/// Index of a node in Candidates::nodes.
using NodeId = std::int32_t;
inline constexpr NodeId kNoNode = -1;

/// A node of the conflict graph, compact. Rows and columns are those of Weights; -1: none.
struct Node {
  double weight = 0;
  std::int32_t uav = -1;
  std::int32_t partner = -1;  ///< worker of Wj, WjTx, UiTxWj; vehicle of Vk, VkCy, UiCyVk
  std::int32_t site = -1;     ///< open task, or charging point
  ActionKind kind = ActionKind::kNone;
};

/// The label L of a node: 2 for UiTxWj, 1 for UiCyVk, else 0. Source: section 4.2.1.
inline int Level(ActionKind kind) {
  return kind == ActionKind::kSense ? 2 : kind == ActionKind::kCharge ? 1 : 0;
}

/// Elements that nodes occupy, numbered through: idle UAVs, idle workers, idle vehicles, open
/// tasks, charging points. Each admits one node, a charging point as many as it has free places.
/// Two nodes conflict when they share an element that admits one: UiTx and WjTx of one task too.
struct Elements {
  int n_uavs = 0, n_workers = 0, n_vehicles = 0, n_tasks = 0;
  std::vector<std::int32_t> capacity;  ///< [n_elements]

  int size() const { return static_cast<int>(capacity.size()); }
  int worker(int w) const { return n_uavs + w; }
  int vehicle(int v) const { return n_uavs + n_workers + v; }
  int task(int x) const { return n_uavs + n_workers + n_vehicles + x; }
  int charge(int y) const { return n_uavs + n_workers + n_vehicles + n_tasks + y; }
  int n_agents() const { return n_uavs + n_workers + n_vehicles; }
};

/// The elements of one node: first agents (UAV first), then the site.
struct NodeElements {
  std::int32_t element[3] = {-1, -1, -1};
  int n = 0;
  const std::int32_t* begin() const { return element; }
  const std::int32_t* end() const { return element + n; }
};

/// Whether the node is about charging points: Vk, UiCy, VkCy, UiCyVk. Its partner is then a
/// vehicle.
inline bool IsCharging(ActionKind kind) {
  return kind == ActionKind::kVehicleStays || kind == ActionKind::kUavToCharge ||
         kind == ActionKind::kVehicleToCharge || kind == ActionKind::kCharge;
}

inline NodeElements ElementsOf(const Node& node, const Elements& elements) {
  NodeElements result;
  const bool charging = IsCharging(node.kind);
  if (node.uav >= 0) result.element[result.n++] = node.uav;
  if (node.partner >= 0) {
    result.element[result.n++] =
        charging ? elements.vehicle(node.partner) : elements.worker(node.partner);
  }
  if (node.site >= 0) {
    result.element[result.n++] = charging ? elements.charge(node.site) : elements.task(node.site);
  }
  return result;
}

/// All feasible nodes of a situation, in the order in which Algorithm 1 makes them: per UAV its
/// stay, its tasks (the move, then the pairs), its charging points (likewise); per worker and per
/// vehicle its stay and its moves. The edges are never stored: Solution finds conflicts from the
/// elements. Source: Alg. 1 (WUGCA) without the edges.
struct Candidates {
  Weights weights;
  Elements elements;
  std::vector<Node> nodes;

  Action ToAction(const Situation& situation, const Node& node) const;
};

/// 24 bytes and O(1) a node.
Candidates EnumerateCandidates(const Situation& situation,
                               Foundation foundation = Foundation::kHierarchical);

/// What EnumerateCandidates would give, node by node, to a function `void(const Node&)`.
template <class Visit>
void VisitCandidates(const Weights& weights, const Feasibility& feasible, Visit&& visit) {
  const auto nx = weights.n_tasks();
  const auto ny = weights.n_charging_points();
  for (int u = 0; u < weights.n_uavs(); ++u) {
    visit(Node{weights.stay, u, -1, -1, ActionKind::kUavStays});
    for (int x = 0; x < nx; ++x) {
      if (!feasible.UavToTask(u, x)) continue;  // nor can it sense there
      visit(Node{weights.uav_to_task(u, x), u, -1, x, ActionKind::kUavToTask});
      for (int w = 0; w < weights.n_workers(); ++w) {
        if (feasible.Sense(u, x, w)) {
          visit(Node{weights.Sense(u, x, w), u, w, x, ActionKind::kSense});
        }
      }
    }
    for (int y = 0; y < ny; ++y) {
      if (!feasible.UavToCharge(u, y)) continue;
      visit(Node{weights.uav_to_charge(u, y), u, -1, y, ActionKind::kUavToCharge});
      for (int v = 0; v < weights.n_vehicles(); ++v) {
        if (feasible.Charge(u, y, v)) {
          visit(Node{weights.Charge(u, y, v), u, v, y, ActionKind::kCharge});
        }
      }
    }
  }
  for (int w = 0; w < weights.n_workers(); ++w) {
    visit(Node{weights.stay, -1, w, -1, ActionKind::kWorkerStays});
    for (int x = 0; x < nx; ++x) {
      if (feasible.WorkerToTask(w, x)) {
        visit(Node{weights.worker_to_task(w, x), -1, w, x, ActionKind::kWorkerToTask});
      }
    }
  }
  for (int v = 0; v < weights.n_vehicles(); ++v) {
    visit(Node{weights.stay, -1, v, -1, ActionKind::kVehicleStays});
    for (int y = 0; y < ny; ++y) {
      if (feasible.VehicleToCharge(v, y)) {
        visit(Node{weights.vehicle_to_charge(v, y), -1, v, y, ActionKind::kVehicleToCharge});
      }
    }
  }
}

/// The elements of a situation whose weights are given.
Elements ElementsOf(const Weights& weights, const Feasibility& feasible);

/// The action that a node stands for.
Action ToAction(const Situation& situation, const Weights& weights, const Node& node);

}  // namespace muster::scheduler
