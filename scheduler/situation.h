#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/agent.h"
#include "model/clearance.h"
#include "model/high_zones.h"
#include "model/scenario.h"

namespace muster::scheduler {

/// One agent of the shift plan: from when on until when it is online, where it stands then.
struct Shift {
  AgentKind kind = AgentKind::kUav;
  std::int32_t id = -1;
  AgentSpec spec;
};

/// Places and rules of a mission: what a policy may know of the scenario. A policy sees the agents
/// that are online or under way, through Situation. Only one that is told that the shift plan is
/// known looks at that, too.
struct Site {
  std::vector<Task> tasks;
  std::vector<ChargingPoint> charging_points;
  std::shared_ptr<const Ways> ways;  ///< how agents travel
  std::shared_ptr<const RoadWays>
      open_roads;                        ///< the same while no road was closed; null: no roads
  std::vector<Closure> closures;         ///< of roads and air, in force
  std::vector<Directive> directives;     ///< of the commander, in force
  std::optional<Separation> separation;  ///< by how much UAVs are kept apart; none: they are not
  std::vector<HighZone> high_zones;      ///< that UAVs fly below
  std::vector<ForbiddenPair> forbidden;  ///< the pairs among them, sorted
  std::vector<double> task_to_charge_m;  ///< [n_tasks] a UAV's way to the nearest charging point
  std::vector<Shift> shifts;  ///< that begin after mission start, by their beginning, kind and id
  Rules rules;
  double width_m = 0;
  double height_m = 0;
  std::uint64_t seed = 0;  ///< for a policy's own draws: Stream::kPolicy, keyed by decision

  explicit Site(const Scenario& scenario);

  /// Whether the commander has forbidden the agent that task.
  bool Forbids(const ForbiddenPair& pair) const {
    return !forbidden.empty() && std::binary_search(forbidden.begin(), forbidden.end(), pair);
  }
  bool Forbids(const AgentState& agent, std::int32_t task) const {
    return Forbids({agent.kind, agent.id, task});
  }
};

/// Everything that a decision may rest on, fused and settled at now_us. Nothing in it is wall time
/// or message age, so the same situation always gives the same decision.
struct Situation {
  std::shared_ptr<const Site> site;
  std::int32_t decision = 0;
  TimeUs now_us = 0;
  /// Agents that are online or under way, ascending by id, settled at now_us. For a busy agent
  /// `to`, `busy_until_us` and `activity` say where and when it will be free.
  std::vector<AgentState> uavs, workers, vehicles;
  std::vector<TaskStatus> task_status;  ///< [n_tasks]
  std::vector<std::int32_t>
      charging_load;  ///< [n_charging_points] pairs charging there or on their way
  /// Of UAVs that are kept apart: by the last decision in force, by id. A UAV that is not listed
  /// has never left the ground.
  std::vector<Clearance> clearances;

  const std::vector<AgentState>& agents(AgentKind kind) const {
    return ByKind(kind, uavs, workers, vehicles);
  }
  /// Range of a UAV now, metres.
  double range_m(const AgentState& uav) const { return RangeAt(uav, now_us, site->tasks); }
  /// Free places at a charging point now; a large number where the capacity is unlimited.
  std::int32_t free_places(ChargeId charge) const;
};

}  // namespace muster::scheduler
