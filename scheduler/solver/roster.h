#pragma once

#include <cstdint>
#include <vector>

#include "scheduler/neighbourhood.h"
#include "scheduler/situation.h"
#include "scheduler/solver/levels.h"

namespace muster::scheduler {

/// The idle agents of one kind, numbered. Levels depend on speed alone, so agents of one speed
/// share their expected costs.
struct Crew {
  std::vector<const AgentState*> agents;
  std::vector<Point> at;               ///< [n_agents] where they stand
  std::vector<double> speeds;          ///< distinct ones, ascending
  std::vector<std::int32_t> speed_of;  ///< [n_agents] index of its speed
  std::vector<LevelOf> levels;         ///< [n_speeds]
  WaysOf ways;

  std::size_t size() const { return agents.size(); }
  const LevelOf& level_of(std::size_t agent) const {
    return levels[static_cast<std::size_t>(speed_of[agent])];
  }
};

/// The idle agents, the open tasks and the charging points with a free place, numbered: by id in a
/// small mission. In a large one neighbours get neighbouring numbers, as memory far apart is slow
/// to reach.
struct Roster {
  /// The situation must outlive the roster.
  explicit Roster(const Situation& situation);

  Neighbourhoods neighbourhoods;
  Crew uavs, workers, vehicles;
  std::vector<double> range_m;  ///< [n_uavs] now
  std::vector<TaskId> tasks;
  std::vector<ChargeId> charges;
  std::vector<Point> task_at, charge_at;     ///< open tasks; all charging points
  std::vector<std::int32_t> site_of_charge;  ///< [n_charging_points] tasks count first; -1: full
};

}  // namespace muster::scheduler
