#include "model/feasibility.h"

#include <algorithm>
#include <limits>

namespace muster {

double NearestChargeDistance(Point p, std::span<const ChargingPoint> points) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const ChargingPoint& point : points) nearest = std::min(nearest, Distance(p, point.at));
  return nearest;
}

}  // namespace muster
