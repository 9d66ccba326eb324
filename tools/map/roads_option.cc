#include "tools/map/roads_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <memory>
#include <utility>

#include "base/check.h"
#include "base/text_file.h"
#include "tools/map/local_frame.h"
#include "tools/map/map_file.h"
#include "tools/map/road_builder.h"
#include "tools/map/road_tags.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kOsmCredit = "(c) OpenStreetMap contributors, ODbL 1.0";

double Km(std::int64_t mm) { return static_cast<double>(mm) / 1e6; }

/// "18.41, -72.47"
std::string Shown(Origin place) {
  return fmt::format("{:.2f}, {:.2f}", place.latitude_deg, place.longitude_deg);
}

/// Where the roads of a map are, in degrees.
struct Extent {
  Origin south_west = {90, 180}, north_east = {-90, -180};
  void Take(Origin place) {
    south_west = {std::min(south_west.latitude_deg, place.latitude_deg),
                  std::min(south_west.longitude_deg, place.longitude_deg)};
    north_east = {std::max(north_east.latitude_deg, place.latitude_deg),
                  std::max(north_east.longitude_deg, place.longitude_deg)};
  }
  std::string Text() const {
    return fmt::format("between {} and {}", Shown(south_west), Shown(north_east));
  }
};

std::string NameOf(const std::string& file) { return fs::path(file).filename().string(); }

std::string SourceOf(const std::string& file, const Arguments& arguments) {
  std::string credit;
  if (MapFormatOf(file) == MapFormat::kOsm) credit = kOsmCredit;
  arguments.Read("roads-credit", &credit);
  return credit.empty() ? NameOf(file) : fmt::format("{}; {}", NameOf(file), credit);
}

/// What is no road, the most first.
std::string Listed(const std::map<std::string, std::size_t>& counts) {
  std::vector<std::pair<std::string, std::size_t>> sorted(counts.begin(), counts.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  constexpr std::size_t kMostShown = 6;
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < std::min(sorted.size(), kMostShown); ++i) {
    texts.push_back(fmt::format("{} {}", sorted[i].second, sorted[i].first));
  }
  if (sorted.size() > kMostShown) texts.emplace_back("...");
  return fmt::format("{}", fmt::join(texts, ", "));
}

/// Reads a map into the text of a road file.
class MapReader {
 public:
  MapReader(const std::string& file, const Scenario& scenario, double join_m)
      : file_(file),
        corner_(*scenario.origin),
        area_{scenario.width_m, scenario.height_m},
        frame_(corner_),
        builder_(area_.x_m, area_.y_m, join_m) {}

  std::string Read(std::string source) {
    ReadMap(file_, [this](const MapFeature& feature) { Take(feature); });
    if (roads_ == 0) {
      throw InputError(
          file_, "content",
          lines_ == 0 ? "no line"
                      : fmt::format("{} lines, none a road ({})", lines_, Listed(tags_.left_out())),
          "lines with a key highway (or fclass, or type) like residential");
    }
    if (builder_.empty()) {
      throw InputError(file_, "roads", fmt::format("some {} only", extent_.Text()),
                       fmt::format("some in the area, which is between {} and {}", Shown(corner_),
                                   Shown(frame_.ToPlace(area_))));
    }
    built_ = builder_.Build(std::move(source), file_);
    return RoadsToJson(built_.roads);
  }

  std::vector<std::string> Summary() const {
    std::vector<std::string> said;
    const auto say = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
      said.push_back(fmt::format(format, std::forward<Args>(args)...));
    };
    say("roads: {}: {} lines, {} of them roads, {} in the area or within {:.0f} km of it",
        NameOf(file_), lines_, roads_, built_.lines, kRoadMargin_m / 1000);
    if (!tags_.left_out().empty()) say("  not roads: {}", Listed(tags_.left_out()));
    if (tags_.unknown_speeds() > 0) {
      say("  {} speed limits that are no speed, like '{}': the usual speed counts there",
          tags_.unknown_speeds(), tags_.unknown_speed());
    }
    if (built_.joined > 0)
      say("  {} points moved to one beside them (--roads-join)", built_.joined);
    if (built_.barriers > 0) say("  barriers that stop vehicles: {}", built_.barriers);
    if (built_.cut_off > 0) {
      say("  left out: {} of {} roads are reachable from nowhere (in all {:.1f} km)",
          built_.cut_off, built_.lines, Km(built_.cut_off_mm));
    }
    say("  {:.1f} km, {:.1f} of them for vehicles, in {} pieces; junctions: {}",
        Km(built_.length_mm), Km(built_.driven_mm), built_.roads.roads.size(), built_.junctions);
    return said;
  }

 private:
  void Take(const MapFeature& feature) {
    if (feature.point && StopsVehicles(feature.tags)) {
      builder_.AddBarrier(frame_.ToPoint(*feature.point));
    }
    if (feature.lines.empty()) return;
    ++lines_;
    const auto use = tags_.Read(feature.tags);
    if (!use) return;
    ++roads_;
    for (const std::vector<Origin>& line : feature.lines) {
      std::vector<Point> points;
      points.reserve(line.size());
      for (const Origin& place : line) {
        extent_.Take(place);
        points.push_back(frame_.ToPoint(place));
      }
      if (use->backward) std::reverse(points.begin(), points.end());
      builder_.AddLine(feature.id, use->road_class, points);
    }
  }

  const std::string& file_;
  const Origin corner_;
  const Point area_;
  const LocalFrame frame_;
  RoadBuilder builder_;
  RoadTags tags_;
  Extent extent_;
  std::size_t lines_ = 0, roads_ = 0;
  BuiltRoads built_;
};

template <class Item>
std::size_t CountNear(const RoadWays& ways, AgentKind kind, const std::vector<Item>& items) {
  return static_cast<std::size_t>(std::count_if(items.begin(), items.end(), [&](const Item& item) {
    return ways.ToRoad(kind, item.at).has_value();
  }));
}

void SayReach(const Scenario& scenario, std::vector<std::string>* said) {
  const auto* ways = dynamic_cast<const RoadWays*>(scenario.ways.get());
  MUSTER_CHECK(ways != nullptr);
  const auto say = [&](std::string_view who, AgentKind kind, double reach_m, std::string_view what,
                       std::size_t sites, std::size_t n_sites) {
    const std::vector<AgentSpec>& agents = scenario.agents(kind);
    said->push_back(fmt::format("  {}: {} of {} {} are within {} km of a road, and {} of {} starts",
                                who, sites, n_sites, what, reach_m / 1000,
                                CountNear(*ways, kind, agents), agents.size()));
  };
  const PerKind<OpenGround>& ground = scenario.roads->open_ground;
  say("workers", AgentKind::kWorker, ground.workers.reach_m, "tasks",
      CountNear(*ways, AgentKind::kWorker, scenario.tasks), scenario.tasks.size());
  say("vehicles", AgentKind::kVehicle, ground.vehicles.reach_m, "charging points",
      CountNear(*ways, AgentKind::kVehicle, scenario.charging_points),
      scenario.charging_points.size());
}

/// The road file's name, beside the scenario's: mine.json has mine.roads.json.
std::string RoadFileFor(const std::string& scenario_file) {
  return fs::path(scenario_file).stem().string() + std::string(kRoadFileEnd);
}

}  // namespace

void AddRoadsOptions(Options* options) {
  options->Group("Road");
  options->Add("roads", "FILE",
               "Workers and vehicles travel by these roads: .osm.pbf, .osm, .geojson, .json, .shp, "
               "or a road file *.roads.json; one is written beside --out");
  options
      ->Add("roads-join", "M",
            "Metres: join points of roads that are no further apart, for maps whose lines "
            "have no points in common where they meet")
      .Number({0, 100})
      .Default(0);
  options->Add("roads-credit", "TEXT",
               "Name that the roads' licence asks to give (default: that of OpenStreetMap, for its "
               "formats)");
  options->Group("");
}

std::vector<std::string> TakeRoads(const Arguments& arguments, Scenario* scenario) {
  const auto fail = [](std::string_view option, std::string_view found, std::string_view expected) {
    throw InputError("command line", option, found, expected);
  };
  if (!arguments.Has("roads")) {
    for (const char* name : {"roads-join", "roads-credit"}) {
      if (arguments.Has(name)) fail("--roads", "none", fmt::format("one with --{}", name));
    }
    return {};
  }
  if (!arguments.Has("out")) fail("--out", "none", "a file: a road file is written beside it");
  const auto start = std::chrono::steady_clock::now();
  const std::string file = arguments.Get("roads");
  ScenarioRoads roads;
  roads.file = RoadFileFor(arguments.Get("out"));
  std::vector<std::string> said;
  if (file.ends_with(kRoadFileEnd)) {
    for (const char* name : {"roads-join", "roads-credit"}) {
      if (arguments.Has(name)) {
        fail(fmt::format("--{}", name), "it with a road file", "it with a map");
      }
    }
    roads.text = ReadTextFile(file, "roads");
    UseRoads(std::move(roads), file, scenario);
    said.push_back(fmt::format("roads: {}: as they are, {} pieces", NameOf(file),
                               scenario->roads->network->roads.size()));
  } else {
    if (!scenario->origin) {
      MapFormatOf(file);
      fail("--origin", "none", "LAT,LON of the area's south-west corner, to place the roads");
    }
    MapReader reader(file, *scenario, arguments.Get<double>("roads-join"));
    roads.text = reader.Read(SourceOf(file, arguments));
    said = reader.Summary();
    UseRoads(std::move(roads), file, scenario);
  }
  SayReach(*scenario, &said);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  said.push_back(fmt::format("  prepared in {:.1f} s", took.count()));
  return said;
}

}  // namespace muster::tools
