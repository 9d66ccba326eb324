#include "tools/map/zone_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/text.h"
#include "base/text_file.h"
#include "tools/map/ogr.h"

namespace muster::tools {
namespace {

using ZoneJson = nlohmann::ordered_json;

constexpr double kFoot_m = 0.3048;

class Reader {
 public:
  Reader(const std::string& file, std::vector<MapZone>* zones) : file_(file), zones_(zones) {}

  void Read(const ZoneJson& top) {
    const bool is_object = top.is_object();
    for (const char* key : {"UASZoneList", "features"}) {
      if (!is_object || !top.contains(key) || !top[key].is_array()) continue;
      const ZoneJson& list = top[key];
      for (std::size_t i = 0; i < list.size(); ++i) {
        where_ = fmt::format("{}[{}]", key, i);
        ReadItem(list[i]);
      }
      return;
    }
    where_ = "top level";
    if (is_object && top.value("type", ZoneJson()) == "Feature") return ReadItem(top);
    throw InputError(file_, "content", "no zones",
                     "GeoJSON with polygons, ED-269 (UASZoneList or features) or ED-318");
  }

  /// A feature as ogr2ogr makes it of a placemark of KML. Returns whether it has an area.
  bool ReadPlacemark(const ZoneJson& feature, std::size_t number) {
    where_ = fmt::format("placemark {}", number);
    const ZoneJson& properties = At(feature, "properties");
    MapZone zone;
    zone.id = zone.name = TextOf(At(properties, "Name"));
    zone.from = TimeOf(At(properties, "begin"));
    zone.until = TimeOf(At(properties, "end"));
    const std::size_t before = zones_->size();
    ReadAreas(At(feature, "geometry"), zone);
    return zones_->size() > before;
  }

 private:
  [[noreturn]] void Fail(std::string_view key, const ZoneJson& found,
                         std::string_view expected) const {
    throw InputError(file_, fmt::format("{}.{}", where_, key),
                     found.is_null() ? "nothing" : found.dump().substr(0, 60), expected);
  }

  static const ZoneJson& At(const ZoneJson& object, const char* key) {
    static const ZoneJson kNone;
    return object.is_object() && object.contains(key) ? object[key] : kNone;
  }

  void ReadItem(const ZoneJson& item) {
    if (!item.is_object()) Fail("zone", item, "an object");
    const ZoneJson& geometry = At(item, "geometry");
    if (geometry.is_array()) return ReadEd269(item, geometry);
    const ZoneJson& properties = At(item, "properties");
    MapZone zone;
    zone.id = TextOf(At(properties, "identifier"));
    zone.name = NameOf(At(properties, "name"));
    if (properties.is_object() && properties.contains("type"))
      zone.rule = RuleOf(properties["type"]);
    ReadTimes(At(properties, "limitedApplicability"), &zone);
    ReadShape(geometry, zone);
  }

  /// One zone may have volumes of its own each.
  void ReadEd269(const ZoneJson& item, const ZoneJson& volumes) {
    MapZone zone;
    zone.id = TextOf(At(item, "identifier"));
    zone.name = NameOf(At(item, "name"));
    zone.rule = RuleOf(At(item, "restriction"));
    ReadTimes(At(item, "applicability"), &zone);
    for (const ZoneJson& volume : volumes) {
      zone.lower_m = LowerOf(At(volume, "lowerLimit"), At(volume, "lowerVerticalReference"),
                             At(volume, "uomDimensions"));
      ReadShape(At(volume, "horizontalProjection"), zone);
    }
  }

  static std::string TextOf(const ZoneJson& value) {
    return value.is_string() ? value.get<std::string>() : "";
  }

  /// A text, or texts in several languages: the English one, else the first.
  static std::string NameOf(const ZoneJson& value) {
    if (!value.is_array()) return TextOf(value);
    std::string name;
    for (const ZoneJson& one : value) {
      const bool is_english = TextOf(At(one, "lang")).starts_with("en");
      if (name.empty() || is_english) name = TextOf(At(one, "text"));
      if (is_english) break;
    }
    return name;
  }

  static MapZone::Rule RuleOf(const ZoneJson& value) {
    const std::string rule = TextOf(value);
    if (rule == "CONDITIONAL" || rule == "NO_RESTRICTION") return MapZone::Rule::kOther;
    // REQ_AUTHORISATION in ED-269, REQ_AUTHORIZATION in ED-318.
    return rule.starts_with("REQ_AUTHORI") ? MapZone::Rule::kAuthorisation
                                           : MapZone::Rule::kProhibited;
  }

  /// Numbers, texts and null occur.
  double LowerOf(const ZoneJson& limit, const ZoneJson& reference, const ZoneJson& unit) const {
    std::optional<double> value;
    if (limit.is_number()) value = limit.get<double>();
    if (limit.is_string()) value = ToNumber(limit.get<std::string>());
    if (limit.is_null()) value = 0;
    if (!value || !std::isfinite(*value)) Fail("lower limit", limit, "a number");
    // Without the ground's altitude a limit above the sea says nothing: then from the ground.
    if (TextOf(reference) != "AGL" && !reference.is_null()) return 0;
    const std::string of = TextOf(unit);
    return of == "FT" || of == "ft" ? *value * kFoot_m : *value;
  }

  std::optional<Moment> TimeOf(const ZoneJson& value) const {
    if (value.is_null()) return {};
    auto parsed = ParseMoment(TextOf(value));
    if (!parsed) Fail("time", value, kMomentExpected);
    return parsed;
  }

  void ReadTimes(const ZoneJson& periods, MapZone* zone) const {
    if (!periods.is_array() || periods.empty()) return;
    bool always = false, is_first = true;
    std::optional<Moment> from, until;
    for (const ZoneJson& period : periods) {
      for (const char* key : {"schedule", "dailyPeriod"}) {
        for (const ZoneJson& part : At(period, key)) {
          zone->recurs |= !At(part, "startTime").is_null() || !At(part, "day").empty();
        }
      }
      const auto begins = TimeOf(At(period, "startDateTime"));
      const auto ends = TimeOf(At(period, "endDateTime"));
      always |= TextOf(At(period, "permanent")) == "YES" || (!begins && !ends);
      if (is_first || (from && begins && begins->unix_us < from->unix_us) || !begins) from = begins;
      if (is_first || (until && ends && ends->unix_us > until->unix_us) || !ends) until = ends;
      is_first = false;
    }
    if (always) return;
    zone->from = from;
    zone->until = until;
  }

  Origin PlaceOf(const ZoneJson& pair) const {
    if (!pair.is_array() || pair.size() < 2 || !pair[0].is_number() || !pair[1].is_number() ||
        !(std::abs(pair[0].get<double>()) <= 180) || !(std::abs(pair[1].get<double>()) <= 90)) {
      Fail("coordinates", pair, "longitude and latitude in degrees");
    }
    return {pair[1].get<double>(), pair[0].get<double>()};
  }

  void AddPolygon(const ZoneJson& rings, MapZone zone) {
    if (!rings.is_array() || rings.empty()) Fail("coordinates", rings, "rings of a polygon");
    zone.rings.clear();
    for (const ZoneJson& ring : rings) {
      std::vector<Origin> places;
      if (!ring.is_array() || ring.size() < 3) Fail("coordinates", ring, "at least 3 corners");
      for (const ZoneJson& pair : ring) places.push_back(PlaceOf(pair));
      zone.rings.push_back(std::move(places));
    }
    zones_->push_back(std::move(zone));
  }

  void AddCircle(const ZoneJson& centre, const ZoneJson& radius, MapZone zone) {
    if (!radius.is_number() || !(radius.get<double>() > 0)) {
      Fail("radius", radius, "metres above 0");
    }
    zone.centre = PlaceOf(centre);
    zone.radius_m = radius.get<double>();
    zones_->push_back(std::move(zone));
  }

  void ReadShape(const ZoneJson& shape, MapZone zone) {
    const ZoneJson& layer = At(shape, "layer");
    if (layer.is_object()) {
      zone.lower_m = LowerOf(At(layer, "lower"), At(layer, "lowerReference"), At(layer, "uom"));
    }
    const std::string type = TextOf(At(shape, "type"));
    if (type == "Polygon") return AddPolygon(At(shape, "coordinates"), zone);
    if (type == "MultiPolygon") {
      for (const ZoneJson& polygon : At(shape, "coordinates")) AddPolygon(polygon, zone);
      return;
    }
    if (type == "GeometryCollection") {
      for (const ZoneJson& part : At(shape, "geometries")) ReadShape(part, zone);
      return;
    }
    if (type == "Circle") return AddCircle(At(shape, "center"), At(shape, "radius"), zone);
    const ZoneJson& extent = At(shape, "extent");
    if (type == "Point" && TextOf(At(extent, "subType")) == "Circle") {
      return AddCircle(At(shape, "coordinates"), At(extent, "radius"), zone);
    }
    Fail("geometry.type", At(shape, "type"), "Polygon, MultiPolygon or a circle");
  }

  /// The polygons of a geometry of any kind.
  void ReadAreas(const ZoneJson& geometry, const MapZone& zone) {
    const std::string type = TextOf(At(geometry, "type"));
    if (type == "Polygon" || type == "MultiPolygon") ReadShape(geometry, zone);
    if (type != "GeometryCollection") return;
    for (const ZoneJson& part : At(geometry, "geometries")) ReadAreas(part, zone);
  }

  const std::string& file_;
  std::string where_;
  std::vector<MapZone>* zones_;
};

MapZones ReadKml(const std::string& file) {
  constexpr std::string_view kExpected = "KML or KMZ with polygons";
  const std::ifstream in(file);
  if (!in) {
    throw InputError(fmt::format("{}: cannot read zones from it: {}", file, std::strerror(errno)));
  }
  MapZones read;
  Reader reader(file, &read.zones);
  std::size_t number = 0, odd = 0;  // odd: no JSON, mostly of a program that is about to fail
  ReadByOgr(file, {}, kExpected, [&](std::string_view line) {
    const ZoneJson feature = ZoneJson::parse(line, nullptr, false);
    ++number;
    if (feature.is_discarded()) {
      odd = number;
    } else if (!reader.ReadPlacemark(feature, number)) {
      ++read.n_others;
    }
  });
  if (odd > 0) {
    throw InputError(file, "content", fmt::format("line {} of ogr2ogr, which is no feature", odd),
                     kExpected);
  }
  if (read.zones.empty()) {
    throw InputError(file, "content", fmt::format("{} placemarks without an area", number),
                     kExpected);
  }
  return read;
}

}  // namespace

std::vector<MapZone> ParseZones(std::string_view text, const std::string& file) {
  ParseJson(text, file);  // for its own errors, which name line and column
  std::vector<MapZone> zones;
  Reader(file, &zones).Read(ZoneJson::parse(text));
  return zones;
}

MapZones ReadZones(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == ".kml" || ending == ".kmz") return ReadKml(file);
  return {ParseZones(ReadTextFile(file, "zones"), file)};
}

}  // namespace muster::tools
