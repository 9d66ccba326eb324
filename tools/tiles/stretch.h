#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace muster::tools {

/// Side of a tile in units of its shapes; their y grows to the south.
inline constexpr int kTileUnits = 4096;

/// A part of a line, from (x, y) to (x + dx, y + dy) in a tile's units.
struct Stretch {
  std::int32_t x = 0, y = 0, dx = 0, dy = 0;

  double Length() const;
};

/// The longest stretch of a line {x, y, x, y, ...} that is nearly straight, lies in the tile or not
/// far beyond its edge, and has its middle in the tile: there a street's name can stand.
std::optional<Stretch> LongestStretch(const std::vector<std::int32_t>& places);

}  // namespace muster::tools
