#include "model/road_area.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/number_text.h"
#include "base/text.h"
#include "base/units.h"
#include "model/polygon_reader.h"

namespace muster {
namespace {

constexpr double kFarthestAway_km = kFarthestRoad_mm * 1e-6;

RoadArea::Ids ReadIds(const ObjectReader& object) {
  RoadArea::Ids ids;
  for (const JsonValue& id : object.Array("roads")) {
    ids.ids.push_back(object.ReadInteger("roads", id, INT64_MIN, INT64_MAX));
  }
  if (ids.ids.empty()) object.Fail("roads", "no id", "ids of roads, as the road file has them");
  return ids;
}

RoadPoint Rounded(Point place) {
  return {static_cast<std::int32_t>(RoundHalfAway(place.x_m * 1000)),
          static_cast<std::int32_t>(RoundHalfAway(place.y_m * 1000))};
}

/// Above 0: c is to the left of the line from a to b; 0: on it.
std::int64_t Side(RoadPoint a, RoadPoint b, RoadPoint c) {
  const auto diff = [](std::int32_t x, std::int32_t y) { return std::int64_t{x} - y; };
  const std::int64_t turn =
      diff(b.x_mm, a.x_mm) * diff(c.y_mm, a.y_mm) - diff(b.y_mm, a.y_mm) * diff(c.x_mm, a.x_mm);
  return (turn > 0) - (turn < 0);
}

bool IsBetween(RoadPoint a, RoadPoint b, RoadPoint on_line) {
  return std::min(a.x_mm, b.x_mm) <= on_line.x_mm && on_line.x_mm <= std::max(a.x_mm, b.x_mm) &&
         std::min(a.y_mm, b.y_mm) <= on_line.y_mm && on_line.y_mm <= std::max(a.y_mm, b.y_mm);
}

/// Whether two segments have a point in common.
bool Meet(RoadPoint a, RoadPoint b, RoadPoint c, RoadPoint d) {
  const auto c_side = Side(a, b, c), d_side = Side(a, b, d);
  const auto a_side = Side(c, d, a), b_side = Side(c, d, b);
  if (c_side * d_side < 0 && a_side * b_side < 0) return true;
  return (c_side == 0 && IsBetween(a, b, c)) || (d_side == 0 && IsBetween(a, b, d)) ||
         (a_side == 0 && IsBetween(c, d, a)) || (b_side == 0 && IsBetween(c, d, b));
}

/// The inside by the even-odd rule, and the border.
class Inside {
 public:
  explicit Inside(const RoadArea::Polygon& polygon) {
    for (const Point corner : polygon.corners) corners_.push_back(Rounded(corner));
  }

  bool Touches(RoadPoint a, RoadPoint b) const {
    bool is_in = false;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const RoadPoint c = corners_[i], d = corners_[(i + 1) % corners_.size()];
      if (Meet(a, b, c, d)) return true;
      if ((c.y_mm > a.y_mm) == (d.y_mm > a.y_mm)) continue;
      is_in ^= Side(c, d, a) == (d.y_mm > c.y_mm ? 1 : -1);
    }
    return is_in;
  }

 private:
  std::vector<RoadPoint> corners_;
};

double DistanceTo(Point place, RoadPoint from, RoadPoint to) {
  const Point a = ToPoint(from), b = ToPoint(to);
  const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
  const double share = std::clamp(
      ((place.x_m - a.x_m) * dx + (place.y_m - a.y_m) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  return Distance(place, Lerp(a, b, share));
}

/// Calls visit(a, b) for the segments of a road, as long as it returns false; whether it ended so.
template <class Visit>
bool AnySegment(const Roads& roads, const Road& road, const Visit& visit) {
  for (std::size_t i = 1; i < road.points.size(); ++i) {
    if (visit(roads.points[static_cast<std::size_t>(road.points[i - 1])],
              roads.points[static_cast<std::size_t>(road.points[i])])) {
      return true;
    }
  }
  return false;
}

template <class Is>
std::vector<std::int32_t> Those(const Roads& roads, const Is& is) {
  std::vector<std::int32_t> found;
  for (std::size_t i = 0; i < roads.roads.size(); ++i) {
    if (is(roads.roads[i])) found.push_back(static_cast<std::int32_t>(i));
  }
  return found;
}

template <class... Visits>
struct Overloaded : Visits... {
  using Visits::operator()...;
};
template <class... Visits>
Overloaded(Visits...) -> Overloaded<Visits...>;

std::string Pair(Point p) { return fmt::format("{}, {}", ToText(p.x_m, kKm), ToText(p.y_m, kKm)); }

}  // namespace

RoadArea ReadRoadArea(const ObjectReader& object) {
  const auto n = std::count_if(std::begin(kRoadAreaKeys), std::end(kRoadAreaKeys),
                               [&](std::string_view key) { return object.Has(key); });
  constexpr std::string_view kExpected = "exactly one of area_km, circle_km, roads, near_km";
  if (n != 1) object.Fail("area_km", fmt::format("{} of them", n), kExpected);
  if (const JsonValue* area = object.Optional("area_km")) {
    return {RoadArea::Polygon{ReadCorners(object, "area_km", *area)}};
  }
  if (object.Has("roads")) return {ReadIds(object)};
  if (const JsonValue* circle = object.Optional("circle_km")) {
    const Circle read = ReadCircle(object, "circle_km", *circle);
    return {RoadArea::Circle{read.centre, read.radius_m}};
  }
  return {RoadArea::Nearest{ReadPair(object, "near_km", *object.Optional("near_km"))}};
}

std::optional<RoadArea> CircleFrom(std::string_view text) {
  const std::vector<std::string> parts = Split(text, '/');
  if (parts.size() != 3) return {};
  std::array<double, 3> km{};
  for (std::size_t i = 0; i < km.size(); ++i) {
    const auto number = ToNumber(parts[i]);
    if (!number || !(std::abs(*number) <= kFarthestAway_km)) return {};
    km[i] = *number;
  }
  if (km[2] < 0) return {};
  return RoadArea{RoadArea::Circle{{km[0] * 1000, km[1] * 1000}, km[2] * 1000}};
}

std::string RoadAreaToJson(const RoadArea& area) {
  return std::visit(Overloaded{
                        [](const RoadArea::Polygon& polygon) {
                          std::string corners;
                          for (const Point corner : polygon.corners) {
                            corners +=
                                fmt::format("{}[{}]", corners.empty() ? "" : ", ", Pair(corner));
                          }
                          return fmt::format("\"area_km\": [{}]", corners);
                        },
                        [](const RoadArea::Circle& circle) {
                          return fmt::format("\"circle_km\": [{}, {}]", Pair(circle.centre),
                                             ToText(circle.radius_m, kKm));
                        },
                        [](const RoadArea::Ids& ids) {
                          return fmt::format("\"roads\": [{}]", fmt::join(ids.ids, ", "));
                        },
                        [](const RoadArea::Nearest& nearest) {
                          return fmt::format("\"near_km\": [{}]", Pair(nearest.place));
                        },
                    },
                    area.of);
}

std::vector<std::int32_t> RoadsIn(const Roads& roads, const RoadArea& area) {
  return std::visit(
      Overloaded{
          [&](const RoadArea::Polygon& polygon) {
            const Inside inside(polygon);
            return Those(roads, [&](const Road& road) {
              return AnySegment(roads, road,
                                [&](RoadPoint a, RoadPoint b) { return inside.Touches(a, b); });
            });
          },
          [&](const RoadArea::Circle& circle) {
            return Those(roads, [&](const Road& road) {
              return AnySegment(roads, road, [&](RoadPoint a, RoadPoint b) {
                return DistanceTo(circle.centre, a, b) <= circle.radius_m;
              });
            });
          },
          [&](const RoadArea::Ids& ids) {
            return Those(roads, [&](const Road& road) {
              return std::find(ids.ids.begin(), ids.ids.end(), road.id) != ids.ids.end();
            });
          },
          [&](const RoadArea::Nearest& nearest) {
            double least_m = std::numeric_limits<double>::infinity();
            std::vector<std::int32_t> found(1);
            for (std::size_t i = 0; i < roads.roads.size(); ++i) {
              AnySegment(roads, roads.roads[i], [&](RoadPoint a, RoadPoint b) {
                const double away_m = DistanceTo(nearest.place, a, b);
                if (away_m >= least_m) return false;
                least_m = away_m;
                found[0] = static_cast<std::int32_t>(i);
                return false;
              });
            }
            return found;
          },
      },
      area.of);
}

}  // namespace muster
