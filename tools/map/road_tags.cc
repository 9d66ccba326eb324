#include "tools/map/road_tags.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "base/text.h"

namespace muster::tools {
namespace {

constexpr double kKmPerMile = 1.609344;
constexpr double kWalk_km_h = 5;

std::string_view TagOf(const MapTags& tags, std::string_view key) {
  const auto tag = tags.find(key);
  return tag == tags.end() ? std::string_view() : std::string_view(tag->second);
}

bool IsOneOf(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// The first of these keys that the line has decides.
bool MayPass(const MapTags& tags, std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) {
    if (const std::string_view value = TagOf(tags, key); !value.empty()) {
      return !IsOneOf(value, {"no", "private"});
    }
  }
  return true;
}
bool MayWalk(const MapTags& tags) { return MayPass(tags, {"foot", "access"}); }
bool MayDrive(const MapTags& tags) {
  return MayPass(tags, {"motorcar", "motor_vehicle", "vehicle", "access"});
}

/// 1: as its points run; -1: against them; 0: both ways.
int Direction(const UsualRoad& usual, const MapTags& tags) {
  const std::string_view said = TagOf(tags, "oneway");
  if (IsOneOf(said, {"yes", "true", "1", "f"})) return 1;
  if (IsOneOf(said, {"-1", "reverse", "t"})) return -1;
  if (IsOneOf(said, {"no", "false", "b"})) return 0;
  const bool is_round = IsOneOf(TagOf(tags, "junction"), {"roundabout", "circular"});
  return usual.one_way || is_round ? 1 : 0;
}

}  // namespace

const std::vector<UsualRoad>& UsualRoads() {
  static const std::vector<UsualRoad> usual = {
      {"motorway", 0, 100, true}, {"motorway_link", 0, 60, true}, {"trunk", 100, 80},
      {"trunk_link", 100, 60},    {"primary", 100, 60},           {"primary_link", 100, 55},
      {"secondary", 100, 55},     {"secondary_link", 100, 50},    {"tertiary", 100, 45},
      {"tertiary_link", 100, 40}, {"unclassified", 100, 30},      {"residential", 100, 30},
      {"road", 100, 30},          {"living_street", 100, 15},     {"service", 100, 15},
      {"track", 90, 15},          {"pedestrian", 100, 0},         {"footway", 100, 0},
      {"path", 100, 0},           {"cycleway", 100, 0},           {"bridleway", 90, 0},
      {"steps", 50, 0},
  };
  return usual;
}

std::optional<double> SpeedLimit(std::string_view maxspeed) {
  if (maxspeed == "walk") return kWalk_km_h;
  if (maxspeed == "none") return kFullRoadSpeed_km_h;
  double unit = 1;
  for (const auto& [name, km_h] : {std::pair<std::string_view, double>{"mph", kKmPerMile},
                                   {"km/h", 1},
                                   {"kmh", 1},
                                   {"kph", 1}}) {
    if (!maxspeed.ends_with(name)) continue;
    maxspeed.remove_suffix(name.size());
    while (maxspeed.ends_with(' ')) maxspeed.remove_suffix(1);
    unit = km_h;
    break;
  }
  const auto number = ToNumber(maxspeed);
  if (!number || *number <= 0) return std::nullopt;
  return *number * unit;
}

bool StopsVehicles(const MapTags& tags) {
  const std::string_view barrier = TagOf(tags, "barrier");
  if (IsOneOf(barrier, {"block", "bollard", "chain", "cycle_barrier", "debris", "jersey_barrier",
                        "kissing_gate", "log", "stile", "turnstile"})) {
    return true;
  }
  return IsOneOf(barrier, {"gate", "lift_gate", "swing_gate"}) &&
         (TagOf(tags, "locked") == "yes" || !MayDrive(tags));
}

int RoadTags::VehiclesPercent(const UsualRoad& usual, const MapTags& tags, std::string* name) {
  if (usual.vehicles_km_h == 0) return 0;
  if (!MayDrive(tags)) {
    *name += ", no vehicles";
    return 0;
  }
  double km_h = usual.vehicles_km_h;
  const std::string_view told = TagOf(tags, "maxspeed");
  // 0 stands in tables that have a column for it.
  if (!told.empty() && told != "0") {
    if (const auto limit = SpeedLimit(told)) {
      km_h = *limit;
      *name += fmt::format(", {:.0f} km/h", km_h);
    } else if (++unknown_speeds_ == 1) {
      unknown_speed_ = told;
    }
  }
  return std::clamp(static_cast<int>(std::lround(100 * km_h / kFullRoadSpeed_km_h)), 1, 100);
}

std::optional<RoadUse> RoadTags::Read(const MapTags& tags) {
  // `fclass` and `type` are what Geofabrik's shapefiles call it.
  std::string_view value = TagOf(tags, "highway");
  if (value.empty()) value = TagOf(tags, "fclass");
  if (value.empty()) value = TagOf(tags, "type");
  const std::vector<UsualRoad>& roads = UsualRoads();
  const auto usual = std::find_if(roads.begin(), roads.end(),
                                  [&](const UsualRoad& road) { return road.name == value; });
  if (usual == roads.end()) {
    ++left_out_[value.empty() ? "without a highway tag" : Printable(value)];
    return std::nullopt;
  }
  if (TagOf(tags, "area") == "yes") {
    ++left_out_["areas"];
    return std::nullopt;
  }
  RoadUse use;
  use.road_class.name = usual->name;
  use.road_class.percent.vehicles = VehiclesPercent(*usual, tags, &use.road_class.name);
  use.road_class.percent.workers = usual->workers_percent;
  if (usual->workers_percent > 0 && !MayWalk(tags)) {
    use.road_class.percent.workers = 0;
    use.road_class.name += ", not on foot";
  }
  if (use.road_class.percent.workers == 0 && use.road_class.percent.vehicles == 0) {
    ++left_out_["closed to all"];
    return std::nullopt;
  }
  if (use.road_class.percent.vehicles > 0) {
    const int direction = Direction(*usual, tags);
    use.road_class.one_way = direction != 0;
    use.backward = direction < 0;
    if (use.road_class.one_way) use.road_class.name += ", one-way";
  }
  return use;
}

}  // namespace muster::tools
