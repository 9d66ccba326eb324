#pragma once

#include <cstdint>
#include <optional>

#include "scheduler/solver/instance.h"

namespace muster::scheduler {

/// A pair that an assignment must hold, by the instance's numbers; -1: any.
struct PairDemand {
  std::int32_t site = -1;
  std::int32_t uav = -1;
  std::int32_t partner = -1;  ///< not together with a UAV
};

/// A heaviest assignment that meets a demand.
struct ForcedAssignment {
  Assignment assignment;
  double weight = 0;
  double bound = 0;  ///< proven: none that meets the demand weighs more; at least weight
};

/// None: no assignment meets the demand, or none was found within the solver's limit of work. A
/// weight that no other nodes can outweigh is added to the arcs that meet the demand, and taken off
/// again. Source: ours.
std::optional<ForcedAssignment> SolveWith(const Instance& instance, const PairDemand& demand);

}  // namespace muster::scheduler
