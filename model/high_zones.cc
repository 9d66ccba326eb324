#include "model/high_zones.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace muster {
namespace {

double ToSegment(Point at, Point a, Point b) {
  const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
  const double length2 = dx * dx + dy * dy;
  double share = 0;
  if (length2 > 0) {
    share = std::clamp(((at.x_m - a.x_m) * dx + (at.y_m - a.y_m) * dy) / length2, 0.0, 1.0);
  }
  return Distance(at, {a.x_m + share * dx, a.y_m + share * dy});
}

/// Of which side of the line from a to b the place is: above 0 to the left.
double SideOf(Point at, Point a, Point b) {
  return (b.x_m - a.x_m) * (at.y_m - a.y_m) - (b.y_m - a.y_m) * (at.x_m - a.x_m);
}

bool Cross(Point a, Point b, Point c, Point d) {
  return SideOf(a, c, d) * SideOf(b, c, d) < 0 && SideOf(c, a, b) * SideOf(d, a, b) < 0;
}

bool AreWithin(Point a, Point b, Point c, Point d, double metres) {
  return Cross(a, b, c, d) || std::min({ToSegment(a, c, d), ToSegment(b, c, d), ToSegment(c, a, b),
                                        ToSegment(d, a, b)}) < metres;
}

bool Touches(Point a, Point b, const HighZone& zone) {
  if (std::max(a.x_m, b.x_m) < zone.low.x_m || std::min(a.x_m, b.x_m) > zone.high.x_m ||
      std::max(a.y_m, b.y_m) < zone.low.y_m || std::min(a.y_m, b.y_m) > zone.high.y_m) {
    return false;
  }
  for (const std::vector<Point>& ring : zone.zone.rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      if (AreWithin(a, b, ring[i], ring[(i + 1) % ring.size()], zone.margin_m)) return true;
    }
  }
  return IsInside(zone.zone, a);
}

}  // namespace

bool IsHigh(const PlannedZone& zone, const ScenarioAir& air) {
  return air.separation && zone.lower_m >= air.separation->lowest_m + air.separation->vertical_m;
}

std::vector<HighZone> HighZonesOf(const Scenario& scenario) {
  std::vector<HighZone> zones;
  if (!scenario.air) return zones;
  const ScenarioAir& air = *scenario.air;
  for (const PlannedZone& planned : air.zones) {
    if (!IsHigh(planned, air)) continue;
    HighZone zone;
    zone.zone = planned.zone;
    zone.margin_m = air.margin_m;
    zone.highest_m = planned.lower_m - air.separation->vertical_m;
    zone.until_us = planned.until_us;
    const std::vector<Point>& outline = zone.zone.rings.front();
    zone.low = zone.high = outline.front();
    for (const Point at : outline) {
      zone.low = {std::min(zone.low.x_m, at.x_m), std::min(zone.low.y_m, at.y_m)};
      zone.high = {std::max(zone.high.x_m, at.x_m), std::max(zone.high.y_m, at.y_m)};
    }
    zone.low = {zone.low.x_m - air.margin_m, zone.low.y_m - air.margin_m};
    zone.high = {zone.high.x_m + air.margin_m, zone.high.y_m + air.margin_m};
    zones.push_back(std::move(zone));
  }
  return zones;
}

bool IsTooHigh(const Trajectory& path, double to_m, const HighZone& zone) {
  for (std::size_t i = 0; i < path.knots.size(); ++i) {
    const Trajectory::Knot& from = path.knots[i];
    const Trajectory::Knot& to = path.knots[std::min(i + 1, path.knots.size() - 1)];
    const double up_m = std::max(from.up_m, to.up_m);
    if (up_m <= 0 || std::max(up_m, to_m) <= zone.highest_m) continue;
    if (Touches(from.at, to.at, zone)) return true;
  }
  return false;
}

}  // namespace muster
