#pragma once

#include "model/scenario.h"

namespace muster::tools {

/// A part of the earth, in degrees.
struct DegreeBox {
  double south = 0, west = 0, north = 0, east = 0;
};

/// The scenario's area, so many metres wider on each side. The scenario must have an origin.
DegreeBox BoxAround(const Scenario& scenario, double around_m);

}  // namespace muster::tools
