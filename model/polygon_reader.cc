#include "model/polygon_reader.h"

#include <fmt/format.h>

#include "base/units.h"

namespace muster {
namespace {

constexpr std::size_t kMostCorners = 1000;
constexpr double kFarthest_km = 1000;

const std::vector<JsonValue>& Numbers(const ObjectReader& object, std::string_view key,
                                      const JsonValue& value, std::size_t n,
                                      std::string_view expected) {
  if (value.type != JsonValue::Type::kArray || value.items.size() != n) {
    object.Fail(key, value, expected);
  }
  return value.items;
}

Point ReadPlace(const ObjectReader& object, std::string_view key, const JsonValue& x,
                const JsonValue& y) {
  return {object.ReadNumber(key, x, kKm, -kFarthest_km, kFarthest_km),
          object.ReadNumber(key, y, kKm, -kFarthest_km, kFarthest_km)};
}

}  // namespace

std::vector<Point> ReadCorners(const ObjectReader& object, std::string_view key,
                               const JsonValue& corners) {
  const bool is_list = corners.type == JsonValue::Type::kArray;
  if (!is_list || corners.items.size() < 3 || corners.items.size() > kMostCorners) {
    object.Fail(key, is_list ? fmt::format("{} corners", corners.items.size()) : "no list",
                fmt::format("3 to {} corners, [x_km, y_km] each", kMostCorners));
  }
  std::vector<Point> places;
  for (const JsonValue& corner : corners.items) {
    const auto& xy = Numbers(object, key, corner, 2, "corners as [x_km, y_km]");
    places.push_back(ReadPlace(object, key, xy[0], xy[1]));
  }
  return places;
}

Point ReadPair(const ObjectReader& object, std::string_view key, const JsonValue& pair) {
  const auto& xy = Numbers(object, key, pair, 2, "[x_km, y_km]");
  return ReadPlace(object, key, xy[0], xy[1]);
}

Circle ReadCircle(const ObjectReader& object, std::string_view key, const JsonValue& circle) {
  const auto& xyr = Numbers(object, key, circle, 3, "[x_km, y_km, radius_km]");
  return {ReadPlace(object, key, xyr[0], xyr[1]),
          object.ReadNumber(key, xyr[2], kKm, 0, kFarthest_km)};
}

}  // namespace muster
