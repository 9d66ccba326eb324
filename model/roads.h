#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/geometry.h"
#include "model/per_kind.h"

namespace muster {

/// Kinds of roads: what they are called and how fast one is on them.
struct RoadClass {
  std::string name;
  /// By agent class: the percentage of an agent's speed that it makes here; 0: it may not go here.
  /// UAVs fly: theirs means nothing.
  PerKind<std::int32_t> percent = {0, 100, 100};
  bool one_way = false;  ///< vehicles go from its first point to its last only; people go both ways
};

/// A place in whole millimetres of the map frame: sums of lengths are then the same on every
/// machine.
struct RoadPoint {
  std::int32_t x_mm = 0, y_mm = 0;
  bool operator==(const RoadPoint&) const = default;
};

/// In metres.
inline Point ToPoint(RoadPoint p) { return {p.x_mm / 1000.0, p.y_mm / 1000.0}; }

/// One road between two junctions or dead ends. No other road meets it in between.
struct Road {
  std::int64_t id = 0;  ///< of the map that it comes from; several may share one
  std::int32_t road_class = 0;
  std::vector<std::int32_t> points;  ///< indices; at least 2, first and last are its ends
};

/// The road network of a scenario (docs/reference/roads.md).
struct Roads {
  std::string source;  ///< where it comes from, with what its licence asks to be said
  std::vector<RoadClass> classes;
  std::vector<RoadPoint> points;
  std::vector<Road> roads;
};

inline constexpr std::string_view kRoadFileEnd = ".roads.json";  ///< of a road file's name
inline constexpr std::int32_t kFarthestRoad_mm = 1'000'000'000;  ///< of a point, from 0

/// Reads a road file. Throws InputError naming `file`, key, value found and value expected.
Roads ParseRoads(std::string_view json, std::string_view file);

/// The inverse: parsing it again gives the same roads.
std::string RoadsToJson(const Roads& roads);

/// Length of the straight line in millimetres, rounded up.
std::int64_t LengthMm(RoadPoint a, RoadPoint b);

}  // namespace muster
