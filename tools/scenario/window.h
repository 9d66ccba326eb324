#pragma once

#include <cstddef>
#include <vector>

#include "base/geometry.h"
#include "model/scenario.h"

namespace muster::tools {

/// Places in the window's frame: local ENU at its south-west corner, in metres. A place beyond the
/// horizon (another continent) gets a point outside any window.
std::vector<Point> Project(const std::vector<Origin>& places, Origin corner);

/// Whether a point is in [0, width) x [0, height).
inline bool InWindow(Point p, double width_m, double height_m) {
  return p.x_m >= 0 && p.x_m < width_m && p.y_m >= 0 && p.y_m < height_m;
}

/// As scenarios have them: whole millionths of a degree.
Origin RoundToMicrodegrees(Origin place);

struct Window {
  Origin corner;  ///< south-west, in whole millionths of a degree
  std::size_t count = 0;
};

/// The window with the most places, to 100 m. Deterministic; ties: southern, then western. `places`
/// must not be empty. Cost: O(n log n) with n places, for each of a few rounds.
Window DensestWindow(const std::vector<Origin>& places, double width_m, double height_m);

}  // namespace muster::tools
