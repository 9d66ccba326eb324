#include "model/made_up.h"

#include <cmath>

namespace muster {

Roads StreetGrid(int n, double block_m, std::uint64_t seed, bool plain) {
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

std::vector<Zone> DrawnZones(Random* random, double extent_m, int n) {
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

}  // namespace muster
