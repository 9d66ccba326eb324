#include "tools/tiles/ground_class.h"

#include <algorithm>
#include <span>
#include <utility>

namespace muster::tools {
namespace {

bool IsOneOf(std::string_view word, std::span<const std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Layers of OpenMapTiles, Protomaps and Shortbread.
constexpr std::string_view kWater[] = {"water", "water_polygons", "ocean",
                                       "lakes", "waterway",       "water_lines"};
constexpr std::string_view kLand[] = {"landcover", "landuse", "park", "land", "natural", "sites"};
constexpr std::string_view kBuildings[] = {"building", "buildings"};
constexpr std::string_view kRoads[] = {"transportation", "roads", "streets", "street_polygons",
                                       "transit"};
constexpr std::string_view kNamedRoads[] = {"transportation_name", "roads", "street_labels"};
constexpr std::string_view kPlaces[] = {"place", "places", "place_labels"};

constexpr std::string_view kGreen[] = {
    "wood",        "forest",         "grass",      "park",  "meadow",        "grassland",
    "scrub",       "garden",         "cemetery",   "pitch", "national_park", "nature_reserve",
    "wetland",     "orchard",        "vineyard",   "heath", "village_green", "recreation_ground",
    "golf_course", "protected_area", "public_park"};
constexpr std::string_view kBuiltUp[] = {"residential", "commercial", "industrial",   "retail",
                                         "suburb",      "school",     "university",   "hospital",
                                         "urban_area",  "quarter",    "neighbourhood"};
constexpr std::string_view kMotorways[] = {"motorway", "trunk", "highway", "motorway_link",
                                           "trunk_link"};
constexpr std::string_view kMainRoads[] = {"primary", "secondary", "major_road", "primary_link",
                                           "secondary_link"};
constexpr std::string_view kStreets[] = {
    "tertiary",    "minor",      "residential", "unclassified", "living_street",
    "medium_road", "minor_road", "street",      "busway",       "tertiary_link"};
constexpr std::string_view kPaths[] = {"service",    "track",    "path",  "footway",
                                       "pedestrian", "cycleway", "steps", "other"};
constexpr std::string_view kRails[] = {"rail", "subway",       "light_rail",
                                       "tram", "narrow_gauge", "transit"};
constexpr std::pair<std::string_view, int> kRanks[] = {
    {"city", 0},    {"capital", 0},  {"state_capital", 0}, {"town", 1},
    {"village", 2}, {"locality", 2}, {"suburb", 3},        {"borough", 3},
    {"hamlet", 4},  {"island", 4},   {"neighbourhood", 5}, {"quarter", 5}};

std::optional<GroundClass> RoadClassOf(std::string_view kind) {
  if (IsOneOf(kind, kMotorways)) return GroundClass::kMotorway;
  if (IsOneOf(kind, kMainRoads)) return GroundClass::kMainRoad;
  if (IsOneOf(kind, kStreets)) return GroundClass::kStreet;
  if (IsOneOf(kind, kPaths)) return GroundClass::kPath;
  if (IsOneOf(kind, kRails)) return GroundClass::kRail;
  return {};
}

}  // namespace

std::optional<GroundClass> ClassOf(std::string_view layer, std::string_view kind, bool is_area) {
  if (IsOneOf(layer, kWater)) return is_area ? GroundClass::kWater : GroundClass::kWaterway;
  if (is_area) {
    if (IsOneOf(layer, kBuildings)) return GroundClass::kBuilding;
    if (!IsOneOf(layer, kLand)) return {};
    if (layer == "park" || IsOneOf(kind, kGreen)) return GroundClass::kGreen;
    if (IsOneOf(kind, kBuiltUp)) return GroundClass::kBuiltUp;
    return {};
  }
  return IsOneOf(layer, kRoads) ? RoadClassOf(kind) : std::nullopt;
}

std::optional<int> RankOfStreet(std::string_view layer, std::string_view kind) {
  if (!IsOneOf(layer, kNamedRoads)) return {};
  const auto its_class = RoadClassOf(kind);
  if (!its_class || *its_class == GroundClass::kRail) return {};
  return *its_class == GroundClass::kPath ? 8 : *its_class == GroundClass::kStreet ? 7 : 6;
}

bool NamesPlaces(std::string_view layer) { return IsOneOf(layer, kPlaces); }

std::optional<int> RankOf(std::string_view kind) {
  const auto rank = std::find_if(std::begin(kRanks), std::end(kRanks),
                                 [&](const auto& entry) { return entry.first == kind; });
  if (rank == std::end(kRanks)) return {};
  return rank->second;
}

}  // namespace muster::tools
