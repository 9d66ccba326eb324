#pragma once

#include <functional>
#include <string>

#include "tools/bench/hard_suite.h"

namespace muster::tools {

/// Every decision of whole missions by `certified`, whose data set, size, time limit, interval and
/// mode are drawn by the seed; of the options: seeds. A row's family is its number of nodes, its
/// times are wall time, and CBC is not asked.
void RunRandomMissions(const BenchOptions& options,
                       const std::function<void(const HardRow&)>& report);
/// What they are drawn from, for a person.
std::string RandomMissionsLimits();

}  // namespace muster::tools
