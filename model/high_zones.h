#pragma once

#include <vector>

#include "base/geometry.h"
#include "base/units.h"
#include "model/scenario.h"
#include "model/separation.h"

namespace muster {

/// A zone that begins so high above the ground that UAVs fly below it (docs/reference/zones.md).
struct HighZone {
  Zone zone;
  Point low, high;       ///< corners of the box around it and its margin
  double margin_m = 0;   ///< across
  double highest_m = 0;  ///< above the ground, to be flown within it and its margin
  TimeUs until_us = kNever;
};

/// Whether UAVs fly below the zone, and not around it: they are kept apart, so each has an
/// altitude, and the lowest one is at least the vertical minimum below the zone.
bool IsHigh(const PlannedZone& zone, const ScenarioAir& air);

/// Those of the scenario.
std::vector<HighZone> HighZonesOf(const Scenario& scenario);

/// Whether some part of the flight touches the zone or its margin and is too high there, or on its
/// way to a greater altitude, where it might be stopped. `to_m`: the altitude that is flown in the
/// end. Parts are those between two knots, as a whole.
bool IsTooHigh(const Trajectory& path, double to_m, const HighZone& zone);

}  // namespace muster
