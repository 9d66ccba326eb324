#include "tools/report/background.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/check.h"

namespace muster::tools {
namespace {

using nlohmann::ordered_json;

constexpr double kMetresPerDegree = 111'000;  ///< of latitude; roughly, to leave out what is far
constexpr double kDecimals = 1e5;             ///< a metre

enum Kind { kPoints, kLine, kPolygon };

class Drawing {
 public:
  Drawing(std::string_view file, const Scenario& scenario)
      : file_(file),
        south_(scenario.origin->latitude_deg),
        west_(scenario.origin->longitude_deg),
        high_(scenario.height_m / kMetresPerDegree),
        wide_(scenario.width_m / kMetresPerDegree /
              std::max(0.01, std::cos(south_ * std::numbers::pi / 180))) {}

  void AddFeature(const ordered_json& feature) {
    std::string name;
    if (const auto properties = feature.find("properties");
        properties != feature.end() && properties->is_object()) {
      const auto named = properties->find("name");
      if (named != properties->end() && named->is_string()) name = named->get<std::string>();
    }
    AddGeometry(feature.value("geometry", ordered_json()), name);
  }

  ordered_json Take() { return std::move(shapes_); }

 private:
  void AddGeometry(const ordered_json& geometry, const std::string& name) {
    if (!geometry.is_object()) return;  // a feature without a place
    const std::string type = geometry.value("type", "");
    if (type == "GeometryCollection") {
      for (const auto& part : geometry.value("geometries", ordered_json::array())) {
        AddGeometry(part, name);
      }
      return;
    }
    const ordered_json places = geometry.value("coordinates", ordered_json());
    const ordered_json one = ordered_json::array({places});
    if (type == "Point") return Add(kPoints, name, ordered_json::array({one}));
    if (type == "MultiPoint" || type == "LineString") {
      return Add(type == "LineString" ? kLine : kPoints, name, one);
    }
    if (type == "Polygon") return Add(kPolygon, name, places);
    if (!places.is_array()) Refuse(places, "coordinates");
    for (const auto& part : places) {
      if (type == "MultiLineString") Add(kLine, name, ordered_json::array({part}));
      if (type == "MultiPolygon") Add(kPolygon, name, part);
    }
  }

  void Add(Kind kind, const std::string& name, const ordered_json& rings) {
    if (!rings.is_array()) Refuse(rings, "coordinates");
    ordered_json shape = ordered_json::array({static_cast<int>(kind), name});
    bool near = false;
    for (const auto& ring : rings) {
      ordered_json flat = ordered_json::array();
      double north = -90, south = 90, east = -180, west = 180;
      if (!ring.is_array()) Refuse(ring, "a list of places");
      for (const auto& place : ring) {
        if (!place.is_array() || place.size() < 2 || !place[0].is_number() ||
            !place[1].is_number() || std::abs(place[0].get<double>()) > 180 ||
            std::abs(place[1].get<double>()) > 90) {
          Refuse(place, "[longitude, latitude] in degrees");
        }
        const double latitude = place[1].get<double>(), longitude = place[0].get<double>();
        north = std::max(north, latitude), south = std::min(south, latitude);
        east = std::max(east, longitude), west = std::min(west, longitude);
        flat.push_back(std::round(latitude * kDecimals) / kDecimals);
        flat.push_back(std::round(longitude * kDecimals) / kDecimals);
      }
      near = near || (north >= south_ - high_ && south <= south_ + 2 * high_ &&
                      east >= west_ - wide_ && west <= west_ + 2 * wide_);
      shape.push_back(std::move(flat));
    }
    if (near) shapes_.push_back(std::move(shape));
  }

  [[noreturn]] void Refuse(const ordered_json& found, const char* expected) const {
    throw InputError(file_, "geometry", found.dump().substr(0, 60), expected);
  }

  std::string_view file_;
  double south_, west_, high_, wide_;  // of the area, degrees
  ordered_json shapes_ = ordered_json::array();
};

}  // namespace

ordered_json Background(std::string_view text, std::string_view file, const Scenario& scenario) {
  if (!scenario.origin) {
    throw InputError(fmt::format("{}: scenario '{}' has no origin, so degrees have no place on it",
                                 file, scenario.name));
  }
  const ordered_json tree = ordered_json::parse(text, nullptr, false);
  const std::string type = tree.is_object() ? tree.value("type", "") : "";
  Drawing drawing(file, scenario);
  if (type == "FeatureCollection") {
    for (const auto& feature : tree.value("features", ordered_json::array())) {
      if (feature.is_object()) drawing.AddFeature(feature);
    }
  } else if (type == "Feature") {
    drawing.AddFeature(tree);
  } else {
    throw InputError(file, "top level", tree.is_discarded() ? "no JSON" : tree.dump().substr(0, 60),
                     "GeoJSON: a FeatureCollection, or a Feature");
  }
  return drawing.Take();
}

}  // namespace muster::tools
