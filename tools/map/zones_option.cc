#include "tools/map/zones_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "model/high_zones.h"
#include "tools/map/local_frame.h"
#include "tools/map/zone_file.h"

namespace muster::tools {
namespace {

/// UAVs fly below it. Zones that begin higher are none of theirs. Source: the open category of
/// Regulation (EU) 2019/947.
constexpr double kCeiling_m = 120;

double AreaOf(Point a, Point b, Point c) {
  return ((b.x_m - a.x_m) * (c.y_m - a.y_m) - (b.y_m - a.y_m) * (c.x_m - a.x_m)) / 2;
}

/// Leaves out corners that point inwards, those that add the least first, until there are so few:
/// what is left contains the ring. Corners that point outwards stay.
void Simplify(std::size_t most, std::vector<Point>* ring) {
  double area = 0;
  for (std::size_t i = 1; i + 1 < ring->size(); ++i) {
    area += AreaOf((*ring)[0], (*ring)[i], (*ring)[i + 1]);
  }
  while (ring->size() > most) {
    double least = std::numeric_limits<double>::infinity();
    std::size_t drop = ring->size();
    for (std::size_t i = 0; i < ring->size(); ++i) {
      const std::size_t before = (i + ring->size() - 1) % ring->size();
      const double turn = AreaOf((*ring)[before], (*ring)[i], (*ring)[(i + 1) % ring->size()]) *
                          (area < 0 ? -1 : 1);
      if (turn <= 0 && -turn < least) {
        least = -turn;
        drop = i;
      }
    }
    if (drop == ring->size()) return;
    ring->erase(ring->begin() + static_cast<std::ptrdiff_t>(drop));
  }
}

class ZoneTaker {
 public:
  ZoneTaker(const Scenario& scenario, std::set<std::string> authorised)
      : scenario_(scenario), frame_(*scenario.origin), authorised_(std::move(authorised)) {}

  void Take(const MapZone& zone, double margin_m, const std::string& file) {
    if (zone.rule == MapZone::Rule::kOther) return Leave("neither prohibited nor restricted");
    if (authorised_.contains(zone.id)) {
      met_.insert(zone.id);
      return Leave("authorised");
    }
    if (zone.lower_m >= kCeiling_m) return Leave(fmt::format("above {:g} m", kCeiling_m));
    PlannedZone planned;
    planned.lower_m = zone.lower_m;
    planned.zone.name = zone.name.empty() ? zone.id : zone.name;
    if (!ReadTimes(zone, &planned)) return Leave("at another time");
    if (!ReadShape(zone, margin_m, file, &planned.zone)) {
      return Leave(planned.zone.rings.empty() ? "without an area" : "elsewhere");
    }
    if (IsHigh(planned, ScenarioAir())) ++high_;
    zones_.push_back(std::move(planned));
  }

  std::vector<PlannedZone> zones() const { return zones_; }

  std::vector<std::string> Summary(const std::string& file, std::size_t n) const {
    std::vector<std::string> said = {fmt::format("zones: {}: {}, of which {} are kept out of",
                                                 std::filesystem::path(file).filename().string(), n,
                                                 zones_.size())};
    for (const auto& [why, count] : left_)
      said.push_back(fmt::format("  left out: {} {}", count, why));
    if (high_ > 0)
      said.push_back(fmt::format("  {} begin above the ground: UAVs fly below them", high_));
    if (without_start_ > 0) {
      said.push_back(
          fmt::format("  {} have a time: without --start they hold all the time", without_start_));
    }
    if (recurring_ > 0) {
      said.push_back(
          fmt::format("  {} hold on some days or hours only: here all the time", recurring_));
    }
    if (simplified_ > 0) {
      said.push_back(fmt::format("  {} made larger, to have at most {} corners", simplified_,
                                 kMostZoneCorners));
    }
    for (const std::string& id : authorised_) {
      if (!met_.contains(id))
        said.push_back(fmt::format("  --authorised {}: there is no such zone", id));
    }
    return said;
  }

 private:
  void Leave(const std::string& why) { ++left_[why]; }

  /// False: it does not hold during the mission.
  bool ReadTimes(const MapZone& zone, PlannedZone* planned) {
    if (zone.recurs) ++recurring_;
    if (!zone.from && !zone.until) return true;
    if (!scenario_.start) {
      ++without_start_;
      return true;
    }
    const auto since_start = [&](const Moment& moment) {
      return moment.unix_us - scenario_.start->unix_us;
    };
    if (zone.from) planned->from_us = std::max<TimeUs>(0, since_start(*zone.from));
    if (zone.until) planned->until_us = since_start(*zone.until);
    return planned->until_us > planned->from_us && planned->from_us < scenario_.rules.limit_us;
  }

  /// False: it is not in the area of the scenario, or, without rings, has no area itself.
  bool ReadShape(const MapZone& map_zone, double margin_m, const std::string& file, Zone* zone) {
    if (map_zone.radius_m > 0) {
      const Point centre = frame_.ToPoint(map_zone.centre);
      zone->rings = {CornersAround(centre, map_zone.radius_m)};
      return IsNear({centre}, margin_m + 1.1 * map_zone.radius_m);
    }
    for (const std::vector<Origin>& places : map_zone.rings) {
      std::vector<Point> ring;
      for (const Origin& place : places) {
        const Point at = frame_.ToPoint(place);
        const Point mm{std::round(at.x_m * 1000) / 1000, std::round(at.y_m * 1000) / 1000};
        if (ring.empty() || ring.back() != mm) ring.push_back(mm);
      }
      while (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
      if (ring.size() >= 3) zone->rings.push_back(std::move(ring));
    }
    if (zone->rings.empty() || !IsNear(zone->rings[0], margin_m)) return false;
    std::size_t corners = 0;
    for (const auto& ring : zone->rings) corners += ring.size();
    if (corners > kMostZoneCorners) {
      ++simplified_;
      zone->rings.resize(1);  // a hole is closed: that, too, is more to keep out of
      Simplify(kMostZoneCorners, zone->rings.data());
    }
    if (zone->rings[0].size() > kMostZoneCorners) {
      throw InputError(file, zone->name, fmt::format("{} corners", zone->rings[0].size()),
                       fmt::format("at most {}", kMostZoneCorners));
    }
    return true;
  }

  bool IsNear(const std::vector<Point>& ring, double reach_m) const {
    Point low{1e300, 1e300}, high{-1e300, -1e300};
    for (const Point at : ring) {
      if (std::isnan(at.x_m)) return false;  // beyond the horizon
      low = {std::min(low.x_m, at.x_m), std::min(low.y_m, at.y_m)};
      high = {std::max(high.x_m, at.x_m), std::max(high.y_m, at.y_m)};
    }
    return low.x_m - reach_m <= scenario_.width_m && low.y_m - reach_m <= scenario_.height_m &&
           high.x_m + reach_m >= 0 && high.y_m + reach_m >= 0;
  }

  const Scenario& scenario_;
  const LocalFrame frame_;
  std::set<std::string> authorised_, met_;
  std::vector<PlannedZone> zones_;
  std::map<std::string, std::size_t> left_;
  std::size_t high_ = 0, without_start_ = 0, recurring_ = 0, simplified_ = 0;
};

}  // namespace

void AddZonesOptions(Options* options) {
  options->Group("Zone");
  options->Add(
      "zones", "FILE",
      "UAVs keep out of these zones: polygons of GeoJSON or KML, ED-269 or ED-318 (prohibited, "
      "and those that need an authorisation)");
  options->Add("zone-margin", "M", "Metres that UAVs stay away from a zone")
      .Number({1, 10'000})
      .Default(30);
  options->Add("authorised", "ID,ID,...",
               "Zones of the file that the mission is authorised to fly in (of KML by name)");
  options->Flag("keep-apart",
                "UAVs are kept apart from each other; orders may add zones. --zones does so, too");
  options->Group("");
}

std::vector<std::string> TakeZones(const Arguments& arguments, Scenario* scenario) {
  if (!arguments.Has("zones")) {
    if (arguments.Has("authorised")) {
      throw InputError("command line", "--zones", "none", "one with --authorised");
    }
    if (arguments.Has("keep-apart")) UseAir({}, scenario);
    return {};
  }
  const std::string file = arguments.Get("zones");
  if (!scenario->origin) {
    throw InputError("command line", "--origin", "none",
                     "LAT,LON of the area's south-west corner, to place the zones");
  }
  const auto [zones, n_others] = ReadZones(file);
  std::set<std::string> authorised;
  if (arguments.Has("authorised")) {
    for (std::string& id : Split(arguments.Get("authorised"), ','))
      authorised.insert(std::move(id));
  }
  ScenarioAir air;
  air.margin_m = arguments.Get<double>("zone-margin");
  ZoneTaker taker(*scenario, std::move(authorised));
  for (const MapZone& zone : zones) taker.Take(zone, air.margin_m, file);
  air.zones = taker.zones();
  UseAir(std::move(air), scenario);
  std::vector<std::string> said = taker.Summary(file, zones.size());
  if (n_others > 0) said.push_back(fmt::format("  left out: {} without an area", n_others));
  return said;
}

}  // namespace muster::tools
