#pragma once

#include <cstdint>
#include <vector>

#include "model/action.h"

namespace muster::scheduler {

/// Index of a node in Candidates::nodes.
using NodeId = std::int32_t;
inline constexpr NodeId kNoNode = -1;

/// A node of the conflict graph, compact: agents and sites are numbered as in Elements; -1: none.
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
/// tasks, all charging points. Each admits one node, a charging point as many as it has free
/// places. Two nodes conflict when they share an element that admits one: UiTx and WjTx of one task
/// too.
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

}  // namespace muster::scheduler
