#include "tools/map/local_frame.h"

#include <limits>

namespace muster::tools {
namespace {

/// Depth below the corner's tangent plane at which a place counts as beyond the horizon: 1,100 km
/// away, where ENU means nothing any more.
constexpr double kDeepestM = -100'000;

}  // namespace

LocalFrame::LocalFrame(Origin corner) : local_(corner.latitude_deg, corner.longitude_deg) {}

Point LocalFrame::ToPoint(Origin place) const {
  Point point;
  double z_m = 0;
  local_.Forward(place.latitude_deg, place.longitude_deg, 0, point.x_m, point.y_m, z_m);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  return z_m < kDeepestM ? Point{kNan, kNan} : point;
}

Origin LocalFrame::ToPlace(Point point) const {
  Origin place;
  double height_m = 0;
  local_.Reverse(point.x_m, point.y_m, 0, place.latitude_deg, place.longitude_deg, height_m);
  return place;
}

}  // namespace muster::tools
