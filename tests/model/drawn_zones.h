#ifndef MUSTER_TESTS_MODEL_DRAWN_ZONES_H_
#define MUSTER_TESTS_MODEL_DRAWN_ZONES_H_

#include <cmath>
#include <vector>

#include "base/random.h"
#include "model/zone.h"

namespace muster::testing {

/// Zones drawn in a square of that extent: stars (concave), triangles, some with a hole, touching
/// and overlapping as it comes. Corners in whole millimetres.
inline std::vector<Zone> DrawnZones(Random* random, double extent_m, int n) {
  std::vector<Zone> zones;
  for (int i = 0; i < n; ++i) {
    const double x_m = random->Uniform(0.15, 0.85) * extent_m;
    const double y_m = random->Uniform(0.15, 0.85) * extent_m;
    const double radius_m = random->Uniform(0.03, 0.15) * extent_m;
    const int corners = 3 + static_cast<int>(random->Below(8));
    const auto ring = [&](double scale) {
      std::vector<Point> places;
      for (int k = 0; k < corners; ++k) {
        const double angle = 2 * 3.14159265358979 * k / corners;
        const double out_m = scale * radius_m * (k % 2 == 0 ? 1 : random->Uniform(0.4, 1.2));
        const auto mm = [](double m) { return std::round(m * 1000) / 1000; };
        places.push_back({mm(x_m + out_m * std::cos(angle)), mm(y_m + out_m * std::sin(angle))});
      }
      return places;
    };
    Zone zone;
    zone.rings.push_back(ring(1));
    if (random->Below(4) == 0) zone.rings.push_back(ring(0.3));
    zones.push_back(zone);
  }
  return zones;
}

}  // namespace muster::testing

#endif  // MUSTER_TESTS_MODEL_DRAWN_ZONES_H_
