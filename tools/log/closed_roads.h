#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/scenario.h"

namespace muster::tools {

/// A road that an order has closed for some time.
struct ClosedRoad {
  std::int32_t road = -1;  ///< index
  std::string order;       ///< its id
  std::string name;        ///< of the closure, as people call it
  TimeUs from_us = 0;
  TimeUs until_us = kNever;  ///< kNever: until the end
};

/// All of a mission, by what its orders have changed: in the order in which they were closed.
std::vector<ClosedRoad> ClosedRoadsOf(const Scenario& scenario);

}  // namespace muster::tools
