#pragma once

#include <string_view>
#include <vector>

#include "base/geometry.h"
#include "base/object_reader.h"

namespace muster {

struct Circle {
  Point centre;
  double radius_m = 0;
};

/// Reads 3 to 1,000 corners [x_km, y_km], each at most 1,000 km from 0. Throws InputError.
std::vector<Point> ReadCorners(const ObjectReader& object, std::string_view key,
                               const JsonValue& corners);

/// Reads [x_km, y_km]. Throws InputError.
Point ReadPair(const ObjectReader& object, std::string_view key, const JsonValue& pair);

/// Reads [x_km, y_km, radius_km]. Throws InputError.
Circle ReadCircle(const ObjectReader& object, std::string_view key, const JsonValue& circle);

}  // namespace muster
