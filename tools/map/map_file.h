#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/scenario.h"

namespace muster::tools {

/// What a map says of a thing: keys and values as OpenStreetMap has them, in small letters.
using MapTags = std::map<std::string, std::string, std::less<>>;

/// One thing of a map: a point, or a line in one or more parts. Places are in whole 1e-7 degrees.
struct MapFeature {
  std::int64_t id = 0;  ///< of the map; if it has none, the feature's number in the file, from 1
  MapTags tags;
  std::vector<std::vector<Origin>> lines;
  std::optional<Origin> point;
};

enum class MapFormat { kOsm, kGeoJson, kShapefile };

/// By the end of its name: .osm.pbf, .osm; .geojson, .json; .shp. Throws InputError on another.
MapFormat MapFormatOf(const std::string& file);

inline constexpr std::uintmax_t kMostMapBytes = 2'000'000'000;

/// Hands on the points and lines of a map: of OpenStreetMap data first the barriers, then the
/// lines with a `highway`; of other formats all, in their order. GeoJSON is read here, all else by
/// ogr2ogr. Throws InputError when the file cannot be used.
void ReadMap(const std::string& file, const std::function<void(const MapFeature&)>& take);

/// The same of a text.
void ParseGeoJsonMap(std::string_view text, const std::string& file,
                     const std::function<void(const MapFeature&)>& take);

/// Adds the tags of a text like `"oneway"=>"yes","lanes"=>"2"`, with = or =>. What is cut off at
/// its end is left out.
void AddTags(std::string_view text, MapTags* tags);

}  // namespace muster::tools
