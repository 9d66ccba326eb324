#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/random.h"
#include "model/roads.h"

namespace muster::testing {

/// Streets at right angles, `n` by `n` junctions about `block_m` apart, moved a little; some
/// streets are missing, bend, are one-way, are for people only, or for vehicles only.
inline Roads StreetGrid(int n, double block_m, std::uint64_t seed, bool plain = false) {
  Random random(seed, Stream::kTest);
  Roads roads;
  roads.source = "made up";
  roads.classes = {{"street", {0, 100, 100}, false},
                   {"lane", {0, 100, 40}, false},
                   {"one-way street", {0, 90, 70}, true},
                   {"path", {0, 80, 0}, false},
                   {"motorway", {0, 0, 100}, true}};
  const auto mm = [&](double m) { return static_cast<std::int32_t>(1000 * m); };
  const auto shift = [&] { return plain ? 0 : (random.Uniform() - 0.5) * 0.4 * block_m; };
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      roads.points.push_back(
          {mm((x + 0.5) * block_m + shift()), mm((y + 0.5) * block_m + shift())});
    }
  }
  const auto add = [&](int a, int b) {
    const double draw = plain ? 0 : random.Uniform();
    if (draw > 0.9) return;
    Road road;
    road.id = static_cast<std::int64_t>(roads.roads.size()) + 100;
    road.road_class = draw < 0.5 ? 0 : draw < 0.6 ? 1 : draw < 0.7 ? 2 : draw < 0.8 ? 3 : 4;
    road.points = {a, b};
    if (!plain && random.Uniform() < 0.3) {
      const RoadPoint p = roads.points[static_cast<std::size_t>(a)];
      const RoadPoint q = roads.points[static_cast<std::size_t>(b)];
      road.points.insert(road.points.begin() + 1, static_cast<std::int32_t>(roads.points.size()));
      roads.points.push_back(
          {(p.x_mm + q.x_mm) / 2 + mm(shift()), (p.y_mm + q.y_mm) / 2 + mm(shift())});
    }
    roads.roads.push_back(road);
  };
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      if (x + 1 < n) add(y * n + x, y * n + x + 1);
      if (y + 1 < n) add(y * n + x, y * n + x + n);
    }
  }
  return roads;
}

}  // namespace muster::testing
