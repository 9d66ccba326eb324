#include "tools/map/map_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/check.h"
#include "base/text.h"
#include "base/text_file.h"
#include "tools/map/ogr.h"

namespace muster::tools {
namespace {

constexpr int kMostDepth = 32;  ///< of objects and arrays in one another

using Json = nlohmann::json;

constexpr std::string_view kGeoJson = "GeoJSON: a FeatureCollection of lines";

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

/// The text from that quote on to its end, which `text` then begins behind; none where it has none.
std::optional<std::string> TakeQuoted(std::string_view* text) {
  if (!text->starts_with('"')) return std::nullopt;
  std::string taken;
  for (std::size_t i = 1; i < text->size(); ++i) {
    const char c = (*text)[i];
    if (c == '"') {
      text->remove_prefix(i + 1);
      return taken;
    }
    if (c == '\\' && i + 1 < text->size()) {
      taken += (*text)[++i];
    } else {
      taken += c;
    }
  }
  return std::nullopt;
}

std::string Shown(const Json& value) {
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  constexpr std::size_t kMostShown = 40;
  if (text.size() > kMostShown) text = text.substr(0, kMostShown) + "...";
  return Printable(text);
}

/// Reads one feature of GeoJSON.
class FeatureReader {
 public:
  /// `number`: of the feature in the file, from 1.
  FeatureReader(const std::string& file, std::int64_t number) : file_(file), number_(number) {}

  MapFeature Read(const Json& feature) const {
    MapFeature read;
    read.id = IdOf(feature);
    if (const auto properties = feature.find("properties"); properties != feature.end()) {
      ReadTags(*properties, &read.tags);
    }
    if (const auto geometry = feature.find("geometry"); geometry != feature.end()) {
      ReadGeometry(*geometry, &read);
    }
    return read;
  }

 private:
  /// A whole number, or a text that ends in one, like "way/123".
  static std::optional<std::int64_t> Whole(const Json& value) {
    if (value.is_number_integer()) return value.get<std::int64_t>();
    if (!value.is_string()) return std::nullopt;
    const auto& text = value.get_ref<const std::string&>();
    return ToInteger(std::string_view(text).substr(text.rfind('/') + 1));
  }

  std::int64_t IdOf(const Json& feature) const {
    const auto of = [](const Json& object, const char* key) -> std::optional<std::int64_t> {
      if (!object.is_object()) return std::nullopt;
      const auto found = object.find(key);
      return found == object.end() ? std::nullopt : Whole(*found);
    };
    if (const auto id = of(feature, "id")) return *id;
    if (const auto properties = feature.find("properties"); properties != feature.end()) {
      for (const char* key : {"osm_id", "@id", "id"}) {
        if (const auto id = of(*properties, key)) return *id;
      }
    }
    return number_;
  }

  static void ReadTags(const Json& properties, MapTags* tags) {
    if (!properties.is_object()) return;
    for (const auto& [key, value] : properties.items()) {
      if (value.is_string()) {
        tags->insert_or_assign(Lower(key), Lower(value.get_ref<const std::string&>()));
      } else if (value.is_number() || value.is_boolean()) {
        tags->insert_or_assign(Lower(key), value.dump());
      }
    }
    // Where GDAL, and those who made shapefiles with it, put what has no column of its own.
    for (const char* all : {"other_tags", "tags"}) {
      const auto text = tags->find(all);
      if (text == tags->end()) continue;
      const std::string other = text->second;
      tags->erase(text);
      AddTags(other, tags);
    }
  }

  void ReadGeometry(const Json& geometry, MapFeature* read) const {
    if (!geometry.is_object()) return;
    const auto type = geometry.find("type");
    const auto coordinates = geometry.find("coordinates");
    if (type == geometry.end() || !type->is_string()) return;
    const auto& name = type->get_ref<const std::string&>();
    if (name != "LineString" && name != "MultiLineString" && name != "Point") return;
    if (coordinates == geometry.end() || !coordinates->is_array()) {
      Fail("geometry.coordinates", coordinates == geometry.end() ? "nothing" : Shown(*coordinates),
           "an array");
    }
    if (name == "Point") {
      read->point = ReadPlace(*coordinates, "geometry.coordinates");
    } else if (name == "LineString") {
      read->lines.push_back(ReadLine(*coordinates, "geometry.coordinates"));
    } else {
      for (std::size_t i = 0; i < coordinates->size(); ++i) {
        read->lines.push_back(
            ReadLine((*coordinates)[i], fmt::format("geometry.coordinates[{}]", i)));
      }
    }
  }

  std::vector<Origin> ReadLine(const Json& coordinates, const std::string& key) const {
    if (!coordinates.is_array()) Fail(key, Shown(coordinates), "an array of places");
    std::vector<Origin> places;
    places.reserve(coordinates.size());
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      places.push_back(ReadPlace(coordinates[i], key, i));
    }
    return places;
  }

  Origin ReadPlace(const Json& place, const std::string& key,
                   std::optional<std::size_t> index = {}) const {
    constexpr std::string_view kExpected =
        "degrees, [longitude, latitude] within 180 and 90 (WGS84)";
    const auto fail = [&] {
      Fail(index ? fmt::format("{}[{}]", key, *index) : key, Shown(place), kExpected);
    };
    if (!place.is_array() || place.size() < 2 || !place[0].is_number() || !place[1].is_number()) {
      fail();
    }
    const auto longitude = place[0].get<double>(), latitude = place[1].get<double>();
    if (std::abs(longitude) > 180 || std::abs(latitude) > 90) fail();
    constexpr double kPerDegree = 1e7;
    return {std::round(latitude * kPerDegree) / kPerDegree,
            std::round(longitude * kPerDegree) / kPerDegree};
  }

  [[noreturn]] void Fail(const std::string& key, const std::string& found,
                         std::string_view expected) const {
    throw InputError(file_, fmt::format("feature {}: {}", number_, key), found, expected);
  }

  const std::string& file_;
  const std::int64_t number_;
};

bool IsFeature(const Json& value) {
  if (!value.is_object()) return false;
  const auto type = value.find("type");
  return type != value.end() && *type == "Feature";
}

[[noreturn]] void FailToParse(const Json::parse_error& error, std::string_view text,
                              const std::string& file) {
  if (error.byte > text.size()) {
    throw InputError(file, "content", "its end in the middle", kGeoJson);
  }
  const std::string_view before = text.substr(0, std::max<std::size_t>(error.byte, 1) - 1);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t begin = before.rfind('\n') + 1;  // npos + 1 is 0
  throw InputError(file, fmt::format("line {}, column {}", line, before.size() - begin + 1),
                   "what is no JSON", kGeoJson);
}

/// As ReadTextFile refuses it.
void CheckSize(const std::string& file) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("{}: cannot read roads from it: {}", file, why));
  };
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  if (error) refuse(error.message());
  if (bytes > kMostMapBytes) {
    refuse(
        fmt::format("found {} bytes, expected at most {}: cut out the area first, as with "
                    "osmium extract or ogr2ogr -spat",
                    bytes, kMostMapBytes));
  }
}

/// Not a feature where it is none. Names in an encoding that their file does not tell are not
/// UTF-8; nothing here depends on them.
Json ParseLine(std::string_view line) {
  Json feature = Json::parse(line, nullptr, false);
  if (!feature.is_discarded()) return feature;
  std::string plain(line);
  for (char& c : plain) c = (static_cast<unsigned char>(c) & 0x80U) != 0 ? '?' : c;
  return Json::parse(plain, nullptr, false);
}

void ReadFeatures(const std::string& file, const std::vector<std::string>& layer,
                  std::string_view expected, const std::function<void(const MapFeature&)>& take) {
  std::int64_t number = 0;
  std::string odd;  // no feature: mostly of a program that is about to fail
  ReadByOgr(file, layer, expected, [&](std::string_view line) {
    const Json feature = ParseLine(line);
    ++number;
    if (IsFeature(feature)) {
      take(FeatureReader(file, number).Read(feature));
    } else if (odd.empty()) {
      odd = fmt::format("line {} of ogr2ogr, which is no feature", number);
    }
  });
  if (!odd.empty()) throw InputError(file, "content", odd, expected);
}

}  // namespace

void AddTags(std::string_view text, MapTags* tags) {
  while (!text.empty()) {
    auto key = TakeQuoted(&text);
    if (!key || !text.starts_with('=')) return;
    text.remove_prefix(text.starts_with("=>") ? 2 : 1);
    auto value = TakeQuoted(&text);
    if (!value) return;
    tags->insert_or_assign(Lower(*key), Lower(*value));
    text.remove_prefix(std::min(text.find('"'), text.size()));
  }
}

MapFormat MapFormatOf(const std::string& file) {
  const std::string name = Lower(file);
  if (name.ends_with(".osm.pbf") || name.ends_with(".osm")) return MapFormat::kOsm;
  if (name.ends_with(".geojson") || name.ends_with(".json")) return MapFormat::kGeoJson;
  if (name.ends_with(".shp")) return MapFormat::kShapefile;
  throw InputError("command line", "--roads", "'" + file + "'",
                   "a file .osm.pbf, .osm, .geojson, .json or .shp, or a road file *.roads.json");
}

void ParseGeoJsonMap(std::string_view text, const std::string& file,
                     const std::function<void(const MapFeature&)>& take) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::int64_t number = 0;
  // The features of a collection are two deep. Each goes as soon as it is read.
  const auto keep = [&](int depth, Json::parse_event_t event, const Json& value) {
    // Values in values without end would exhaust the stack.
    if (depth > kMostDepth) {
      throw InputError(file, "content", "objects and arrays nested deeper",
                       fmt::format("at most {} levels", kMostDepth));
    }
    if (depth != 2 || event != Json::parse_event_t::object_end || !IsFeature(value)) return true;
    take(FeatureReader(file, ++number).Read(value));
    return false;
  };
  Json top;
  try {
    top = Json::parse(text.begin(), text.end(), keep);
  } catch (const Json::parse_error& error) {
    FailToParse(error, text, file);
  }
  if (IsFeature(top)) {
    take(FeatureReader(file, ++number).Read(top));
  } else if (number == 0) {
    const auto type = top.is_object() ? top.find("type") : top.end();
    throw InputError(file, "content",
                     type != top.end() && *type == "FeatureCollection" ? "no feature" : Shown(top),
                     kGeoJson);
  }
}

void ReadMap(const std::string& file, const std::function<void(const MapFeature&)>& take) {
  const MapFormat format = MapFormatOf(file);
  CheckSize(file);
  if (format == MapFormat::kGeoJson) {
    return ParseGeoJsonMap(ReadTextFile(file, "roads", kMostMapBytes), file, take);
  }
  if (format == MapFormat::kOsm) {
    for (const auto& [layer, key] : {std::pair{"points", "barrier"}, {"lines", "highway"}}) {
      ReadFeatures(file, {layer, "-where", fmt::format("{} IS NOT NULL", key)},
                   "OpenStreetMap data, whole", take);
    }
    return;
  }
  std::vector<std::string> options;
  // Without that file nobody knows what its coordinates are: they should be degrees.
  std::error_code ignored;
  for (const char* extension : {".prj", ".PRJ"}) {
    if (!std::filesystem::exists(std::filesystem::path(file).replace_extension(extension),
                                 ignored)) {
      continue;
    }
    options = {"-t_srs", "EPSG:4326"};
  }
  ReadFeatures(file, options, "a shapefile, whole, with its .shx and .dbf beside it", take);
}

}  // namespace muster::tools
