#include "model/zone.h"

#include <fmt/format.h>

#include <cmath>

#include "base/number_text.h"
#include "base/units.h"
#include "model/polygon_reader.h"

namespace muster {
namespace {

Point InMillimetres(Point place) {
  return {static_cast<double>(RoundHalfAway(place.x_m * 1000)) / 1000,
          static_cast<double>(RoundHalfAway(place.y_m * 1000)) / 1000};
}

/// Equal corners that follow each other count once.
std::vector<Point> ReadRing(const ObjectReader& object, std::string_view key,
                            const JsonValue& value) {
  std::vector<Point> ring;
  for (const Point corner : ReadCorners(object, key, value)) {
    const Point at = InMillimetres(corner);
    if (ring.empty() || ring.back() != at) ring.push_back(at);
  }
  while (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
  if (ring.size() < 3) {
    object.Fail(key, fmt::format("{} different corners", ring.size()), "at least 3");
  }
  return ring;
}

std::string RingText(const std::vector<Point>& ring) {
  std::string text;
  for (const Point corner : ring) {
    text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ", ToText(corner.x_m, kKm),
                        ToText(corner.y_m, kKm));
  }
  return "[" + text + "]";
}

}  // namespace

Zone ReadZone(const ObjectReader& object) {
  Zone zone;
  const JsonValue* const area = object.Optional("area_km");
  const JsonValue* const circle = object.Optional("circle_km");
  if ((area == nullptr) == (circle == nullptr)) {
    object.Fail("area_km", area ? "circle_km beside it" : "no such key",
                "exactly one of area_km, circle_km");
  }
  if (circle != nullptr) {
    const Circle read = ReadCircle(object, "circle_km", *circle);
    if (!(read.radius_m >= 1)) object.Fail("circle_km", *circle, "a radius of at least a metre");
    zone.rings.push_back(CornersAround(read.centre, read.radius_m));
    if (object.Has("holes_km")) {
      object.Fail("holes_km", *object.Optional("holes_km"), "nothing beside circle_km");
    }
    return zone;
  }
  zone.rings.push_back(ReadRing(object, "area_km", *area));
  if (object.Has("holes_km")) {
    for (const JsonValue& hole : object.Array("holes_km")) {
      zone.rings.push_back(ReadRing(object, "holes_km", hole));
    }
  }
  std::size_t corners = 0;
  for (const std::vector<Point>& ring : zone.rings) corners += ring.size();
  if (corners > kMostZoneCorners) {
    object.Fail("area_km", fmt::format("{} corners with those of holes", corners),
                fmt::format("at most {}", kMostZoneCorners));
  }
  return zone;
}

std::string ZoneToJson(const Zone& zone) {
  std::string text = fmt::format("\"area_km\": {}", RingText(zone.rings.front()));
  for (std::size_t i = 1; i < zone.rings.size(); ++i) {
    text += fmt::format("{}{}", i == 1 ? ", \"holes_km\": [" : ", ", RingText(zone.rings[i]));
  }
  return zone.rings.size() > 1 ? text + "]" : text;
}

std::vector<Point> CornersAround(Point centre, double radius_m) {
  // Cosines of 0, 22.5, 45, 67.5 and 90 degrees, and 1 / cos(11.25 degrees): written out, as a
  // library's may differ in the last digit.
  constexpr double kCos[] = {1, 0.92387953251128674, 0.70710678118654752, 0.38268343236508977, 0};
  constexpr double kOut = 1.0195911582083184;
  std::vector<Point> corners;
  for (int k = 0; k < 16; ++k) {
    const int quarter = k / 4, rest = k % 4;
    const double c = kCos[rest], s = kCos[4 - rest];
    const double x[] = {c, -s, -c, s}, y[] = {s, c, -s, -c};
    corners.push_back(InMillimetres(
        {centre.x_m + kOut * radius_m * x[quarter], centre.y_m + kOut * radius_m * y[quarter]}));
  }
  return corners;
}

bool IsInside(const Zone& zone, Point place) {
  bool is_in = false;
  for (const std::vector<Point>& ring : zone.rings) {
    for (std::size_t i = 0, before = ring.size() - 1; i < ring.size(); before = i++) {
      const Point a = ring[before], b = ring[i];
      if ((a.y_m > place.y_m) == (b.y_m > place.y_m)) continue;
      const double x_m = a.x_m + (b.x_m - a.x_m) * ((place.y_m - a.y_m) / (b.y_m - a.y_m));
      is_in ^= place.x_m < x_m;
    }
  }
  return is_in;
}

}  // namespace muster
