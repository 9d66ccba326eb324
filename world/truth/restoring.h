#pragma once

#include <cstdint>
#include <map>
#include <muster/restore_t.hpp>
#include <muster/rulings_t.hpp>
#include <muster/world_state_t.hpp>
#include <optional>
#include <vector>

#include "lcmtypes/protocol/convert.h"
#include "world/model/scenario.h"

namespace muster::world {

/// What the others still hold of a mission, while a world that starts again gathers it.
class Restoring {
 public:
  /// `scenario` must outlive this object.
  Restoring(const Scenario& scenario, std::int64_t run_id);

  /// Takes one answer; false: it is of no mission, of another one, or impossible.
  [[nodiscard]] bool Take(const restore_t& restore);

  struct State {
    std::int64_t tick = 0;  ///< to go on with; 0: the mission has not begun, all else is empty
    std::int32_t applied_decision = -1;
    /// The verdict on the tick before.
    std::vector<TaskStatus> task_status;
    std::vector<Activity> activities;
    std::vector<Ruling> rulings;
  };
  /// The newest tick whose states all agents have been heard with; none: something still lacks.
  std::optional<State> Newest() const;

 private:
  const Scenario& scenario_;
  const WireLimits limits_;
  const std::int64_t run_id_;
  bool not_begun_ = false;
  std::vector<std::int64_t> ticks_[3];  ///< [n_agents] tick of the newest states; -1: not heard
  std::map<std::int64_t, std::int32_t> applied_;  ///< by tick: the decision in force
  std::map<std::int64_t, world_state_t> worlds_;
  std::map<std::int64_t, rulings_t> rulings_;
};

}  // namespace muster::world
