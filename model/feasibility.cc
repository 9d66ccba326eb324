#include "model/feasibility.h"

#include <algorithm>
#include <limits>

namespace muster {

double NearestChargeM(const Ways& ways, Point p, std::span<const ChargingPoint> points) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const ChargingPoint& point : points) {
    nearest = std::min(nearest, ways.Length(AgentKind::kUav, p, point.at));
  }
  return nearest;
}

}  // namespace muster
