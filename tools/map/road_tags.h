#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/roads.h"
#include "tools/map/map_file.h"

namespace muster::tools {

/// The speed at which vehicles make their full speed.
inline constexpr double kFullRoadSpeed_km_h = 80;

/// What is usual on a kind of road.
struct UsualRoad {
  std::string_view name;    ///< the value of `highway`
  int workers_percent = 0;  ///< of their speed
  double vehicles_km_h = 0;
  bool one_way = false;
};

/// The table of docs/guide/roads.md.
const std::vector<UsualRoad>& UsualRoads();

/// How a line of a map is a road.
struct RoadUse {
  RoadClass road_class;
  bool backward = false;  ///< its one way is from its last point to its first
};

/// Says which lines of a map are roads, and counts the others.
class RoadTags {
 public:
  /// None: nobody goes there.
  std::optional<RoadUse> Read(const MapTags& tags);

  /// Lines that are no roads, by what they are instead.
  const std::map<std::string, std::size_t>& left_out() const { return left_out_; }
  /// Values of `maxspeed` that mean no speed to us, with the first of them.
  std::size_t unknown_speeds() const { return unknown_speeds_; }
  const std::string& unknown_speed() const { return unknown_speed_; }

 private:
  int VehiclesPercent(const UsualRoad& usual, const MapTags& tags, std::string* name);

  std::map<std::string, std::size_t> left_out_;
  std::size_t unknown_speeds_ = 0;
  std::string unknown_speed_;
};

/// "50", "50 km/h", "30 mph", "walk", "none" (no limit) in km/h; none: no speed.
std::optional<double> SpeedLimit(std::string_view maxspeed);

/// Whether a point of a map stops vehicles: a bollard, a locked gate, ...
bool StopsVehicles(const MapTags& tags);

}  // namespace muster::tools
