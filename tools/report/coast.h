#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/scenario.h"
#include "tools/tiles/degree_box.h"

namespace muster::tools {

/// Shores as GSHHG's binned files hold them: the earth in square bins, a shore cut where it leaves
/// its bin. Levels: 0 sea, 1 land, 2 lake, 3 island in a lake, 4 pond on it; even ones are water.
struct ShoreGrid {
  /// The largest coordinate within a bin; 0: its west or south side.
  static constexpr std::int64_t kSide = 65535;
  struct Place {
    std::int64_t x = 0, y = 0;
  };
  struct Bin {
    std::array<int, 4> corners{};  ///< levels: south-west, south-east, north-east, north-west
    std::vector<std::vector<Place>> segments;  ///< from side to side, or closed
  };

  double bin_deg = 0;
  int columns = 0, rows = 0;  ///< from 0 degrees east; from the south pole
  std::string source;         ///< "GSHHG 2.3.7, full resolution"
  std::function<Bin(int column, int row)> read;
};

/// The land within a box as rings, [latitude, longitude, ...] in degrees, of which what lies within
/// an odd number is land. Rings that the box cuts run along its sides. Throws InputError when the
/// grid contradicts itself. Source: ours; levels along the border of the bins change where a shore
/// meets it, and at no other place.
std::vector<std::vector<double>> LandWithin(const ShoreGrid& grid, const DegreeBox& box);

/// For the page: {"source", "box": [south, west, north, east], "rings": [[latitude, longitude, then
/// differences], ...]} in 1e-5 degrees, of the scenario's area and what a map shows around it. The
/// scenario must have an origin.
nlohmann::ordered_json Coast(const ShoreGrid& grid, const Scenario& scenario);

}  // namespace muster::tools
