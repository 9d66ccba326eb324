#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/geometry.h"
#include "base/object_reader.h"

namespace muster {

/// A part of the airspace that UAVs keep out of (docs/reference/zones.md).
struct Zone {
  std::string name;  ///< as people call it; "": not given
  /// The outline and then its holes, each at least 3 corners in whole millimetres. Inside is what a
  /// line to the east leaves through these an odd number of times.
  std::vector<std::vector<Point>> rings;
};

inline constexpr std::size_t kMostZoneCorners = 500;  ///< of all rings together

/// Reads area_km or circle_km, and holes_km. A circle becomes 16 corners around it. Throws
/// InputError.
Zone ReadZone(const ObjectReader& object);

/// The inverse, without braces: "area_km": [[0, 0], ...]
std::string ZoneToJson(const Zone& zone);

/// 16 corners of which every edge touches the circle.
std::vector<Point> CornersAround(Point centre, double radius_m);

/// Whether the place is inside, by the rings alone.
bool IsInside(const Zone& zone, Point place);

}  // namespace muster
