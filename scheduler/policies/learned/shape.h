#pragma once

#include <cstdint>
#include <string>

#include "model/per_kind.h"
#include "model/scenario.h"

namespace muster::scheduler::learned {

/// Places that an agent chooses among at a decision, "stay" included, and how many of a UAV's are
/// tasks at most; the others are charging points.
inline constexpr int kOptions = 17;
inline constexpr int kTaskOptions = 12;
/// Numbers that describe an option, an agent, and maps that describe a situation (features.h).
inline constexpr int kOptionFeatures = 14;
inline constexpr int kAgentFeatures = 7;
inline constexpr int kMaps = 6;
/// Changes whenever a feature means something else: models of another version are refused.
inline constexpr int kFeatureVersion = 1;

/// What a model is made for: it has an input for each agent and each cell, so it decides for
/// scenarios of this shape only.
struct Shape {
  int columns = 0, rows = 0;  ///< cells of 1 km
  PerKind<int> agents;
  TimeUs interval_us = 0;
  TimeUs limit_us = 0;

  int n_agents() const { return agents.uavs + agents.workers + agents.vehicles; }
  /// Index of the first agent of that kind in the row of all: UAVs, workers, vehicles.
  int first(AgentKind kind) const {
    return ByKind(kind, 0, agents.uavs, agents.uavs + agents.workers);
  }
  friend bool operator==(const Shape& a, const Shape& b);

 private:
  static int ByKind(AgentKind kind, int u, int w, int v) {
    return kind == AgentKind::kUav ? u : kind == AgentKind::kWorker ? w : v;
  }
};

/// Without room for agents that orders may add: these stay where they are.
Shape ShapeOf(const Scenario& scenario);

/// "30 x 30 km, 30 UAVs, 50 workers, 20 vehicles, decisions every 10 min for 180 min"
std::string ToString(const Shape& shape);

}  // namespace muster::scheduler::learned
