#pragma once

#include <cmath>

#include "base/units.h"

namespace muster {

/// A place in the map frame: local ENU, metres east and north of the area's south-west corner.
struct Point {
  double x_m = 0;
  double y_m = 0;
  bool operator==(const Point&) const = default;
};

/// Euclidean distance in metres (the paper's Dis).
inline double Distance(Point a, Point b) {
  const double dx = a.x_m - b.x_m;
  const double dy = a.y_m - b.y_m;
  return std::sqrt(dx * dx + dy * dy);
}

inline Point Lerp(Point a, Point b, double fraction) {
  return {a.x_m + (b.x_m - a.x_m) * fraction, a.y_m + (b.y_m - a.y_m) * fraction};
}

/// Time in which `amount` comes about at `rate` a second, in microseconds.
inline TimeUs DurationUs(double amount, double rate) { return ToUs(amount / rate); }

/// Time to travel a way of `way_m` metres at `speed_m_s`, in microseconds.
inline TimeUs TravelUs(double way_m, double speed_m_s) { return DurationUs(way_m, speed_m_s); }

}  // namespace muster
