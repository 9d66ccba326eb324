#include "model/ways.h"

#include <utility>

namespace muster {
namespace {

std::shared_ptr<const Ways>& Default() {
  static std::shared_ptr<const Ways> ways(&StraightWays(), [](const Ways*) {});
  return ways;
}

}  // namespace

double Ways::BentLength(AgentKind, Point from, Point to) const { return Distance(from, to); }

std::vector<Point> Ways::BentCorners(AgentKind, Point, Point) const { return {}; }

Point Ways::BentPlaceAfter(AgentKind kind, Point from, Point to, double share) const {
  std::vector<Point> stops = BentCorners(kind, from, to);
  stops.push_back(to);
  double whole_m = 0;
  Point last = from;
  for (const Point& stop : stops) {
    whole_m += Distance(last, stop);
    last = stop;
  }
  double left_m = share * whole_m;
  last = from;
  for (const Point& stop : stops) {
    const double step_m = Distance(last, stop);
    if (left_m < step_m) return Lerp(last, stop, left_m / step_m);
    left_m -= step_m;
    last = stop;
  }
  return to;
}

double Ways::BentGroundLength(AgentKind kind, Point from, Point to) const {
  return BentLength(kind, from, to);
}

Ways::Stop Ways::BentStopNear(AgentKind, Point wanted) const { return {wanted}; }

Point Ways::BentStopBefore(AgentKind kind, Point from, Point to, double share) const {
  return BentPlaceAfter(kind, from, to, share);
}

std::optional<Point> Ways::BentNumberedStop(AgentKind, std::int32_t) const { return {}; }

const Ways& StraightWays() {
  static const Ways ways;
  return ways;
}

std::shared_ptr<const Ways> DefaultWays() { return Default(); }

ScopedDefaultWays::ScopedDefaultWays(std::shared_ptr<const Ways> ways)
    : before_(std::exchange(Default(), std::move(ways))) {}

ScopedDefaultWays::~ScopedDefaultWays() { Default() = std::move(before_); }

}  // namespace muster
