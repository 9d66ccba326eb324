#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/geometry.h"
#include "base/object_reader.h"
#include "model/roads.h"

namespace muster {

/// Which roads an order or a scenario means. A road is one piece between two junctions; it is meant
/// as a whole where any part of it is.
struct RoadArea {
  struct Polygon {
    std::vector<Point> corners;  ///< at least 3; the roads that it touches
  };
  struct Circle {
    Point centre;
    double radius_m = 0;  ///< the roads that come so near
  };
  struct Ids {
    std::vector<std::int64_t> ids;  ///< of the map; all roads that have one of them
  };
  struct Nearest {
    Point place;  ///< the one road that is nearest
  };
  std::variant<Polygon, Circle, Ids, Nearest> of;
};

/// Keys of an object that can say which roads: it has exactly one of them.
inline constexpr std::string_view kRoadAreaKeys[] = {"area_km", "circle_km", "roads", "near_km"};

/// Reads the one key. Throws InputError where there is none, more than one, or no such area.
RoadArea ReadRoadArea(const ObjectReader& object);

/// A circle from "X_KM/Y_KM/RADIUS_KM"; none: it is not written so.
std::optional<RoadArea> CircleFrom(std::string_view text);

/// The inverse, without braces: "area_km": [[0, 0], ...]
std::string RoadAreaToJson(const RoadArea& area);

/// Indices of the roads in that area, ascending. The answer is the same on every machine: places
/// are rounded to millimetres, and polygons are compared in whole numbers.
std::vector<std::int32_t> RoadsIn(const Roads& roads, const RoadArea& area);

}  // namespace muster
