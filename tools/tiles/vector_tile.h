#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/tiles/stretch.h"

namespace muster::tools {

/// What a base map shows, in the order in which it is drawn.
enum class GroundClass {
  kGreen,
  kBuiltUp,
  kWater,
  kWaterway,
  kBuilding,
  kPath,
  kRail,
  kStreet,
  kMainRoad,
  kMotorway,
};
inline constexpr int kGroundClasses = 10;
constexpr bool IsArea(GroundClass its_class) {
  return its_class <= GroundClass::kWater || its_class == GroundClass::kBuilding;
}

struct GroundShapes {
  struct Name {
    std::int32_t x = 0, y = 0;
    int rank = 0;  ///< 0: a city, to 5: a part of a village
    std::string text;
  };
  /// Where the name of a street has its place: along the line from (x, y) to (x + dx, y + dy).
  struct Street {
    Stretch along;
    int rank = 0;  ///< 6: a main road, to 8: a path
    std::string text;
  };
  /// [kGroundClasses] Lines, and rings that are wound as the specification says (holes the other
  /// way round): {x, y, x, y, ...}.
  std::vector<std::vector<std::vector<std::int32_t>>> shapes;
  std::vector<Name> names;
  std::vector<Street> streets;  ///< each name once, the most important first, then the longest
};

/// Of a Mapbox Vector Tile (specification 2.1), what a base map shows. Known are the layers of
/// OpenMapTiles, Protomaps and Shortbread; others are passed over. None: it is no such tile, or
/// contradicts itself.
std::optional<GroundShapes> ReadVectorTile(const std::string& bytes);

}  // namespace muster::tools
