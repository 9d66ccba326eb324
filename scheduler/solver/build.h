#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "scheduler/policy.h"
#include "scheduler/situation.h"
#include "scheduler/solver/expected_costs.h"
#include "scheduler/solver/instance.h"

namespace muster::scheduler {

/// An Instance and what its indices mean.
struct BuiltInstance {
  Instance instance;
  std::vector<const AgentState*> uavs;       ///< [n_uavs]
  std::vector<const AgentState*> partners;   ///< [n_partners] workers, then vehicles
  std::vector<TaskId> tasks;                 ///< sites [0, n_tasks)
  std::vector<ChargeId> charges;             ///< sites [n_tasks, n_sites)
  std::vector<std::int32_t> site_of_charge;  ///< [n_charging_points]; -1: no free place
  std::int32_t n_workers = 0;
  double weights_s = 0;     ///< wall time spent on expected costs and gains
  double candidates_s = 0;  ///< on finding and ordering the arcs

  std::int32_t n_tasks() const { return static_cast<std::int32_t>(tasks.size()); }
};

/// In mode overrun any partner may go to any site. Beyond that many (partner, site), only those of
/// each site's nearest levels are listed; the bound counts the others.
inline constexpr std::size_t kAllPairs = 1'000'000;

/// The candidate actions of a situation with their weights: idle agents, open tasks, charging
/// points with a free place, constraints (5) and (6), availability. `threads` may be 1 or 2; the
/// result does not depend on it.
BuiltInstance BuildInstance(const Situation& situation, int threads = 1,
                            std::size_t exact_up_to = kExactPlaces,
                            std::size_t all_pairs_up_to = kAllPairs);

}  // namespace muster::scheduler
