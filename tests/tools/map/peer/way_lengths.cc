// way_lengths SCENARIO.json FROM_LAT FROM_LON TO_LAT TO_LON: prints the corners of the shortest way
// on foot and by vehicle. way_lengths SCENARIO.json N SEED: draws N pairs of places on the roads of
// a scenario and prints, for each, where they are and how long the shortest way between them is, on
// foot and by vehicle. A peer is asked the same (peer.mjs).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "base/random.h"
#include "model/road_ways.h"
#include "model/scenario_json.h"
#include "tools/map/local_frame.h"

namespace muster::tools {
namespace {

struct Place {
  Point at;
  std::int64_t map_id = 0;
};

/// The middle of a segment, so that no other road is as near.
Place Draw(const Roads& roads, Random* random) {
  for (;;) {
    const Road& road = roads.roads[random->Below(static_cast<std::uint32_t>(roads.roads.size()))];
    const PerKind<std::int32_t>& percent =
        roads.classes[static_cast<std::size_t>(road.road_class)].percent;
    if (percent.workers == 0 || percent.vehicles == 0) continue;
    const auto n = static_cast<std::uint32_t>(road.points.size() - 1);
    const std::size_t i = random->Below(n);
    const RoadPoint a = roads.points[static_cast<std::size_t>(road.points[i])];
    const RoadPoint b = roads.points[static_cast<std::size_t>(road.points[i + 1])];
    return {{(a.x_mm / 2000.0) + (b.x_mm / 2000.0), (a.y_mm / 2000.0) + (b.y_mm / 2000.0)},
            road.id};
  }
}

/// The shortest way and not the fastest: all roads are alike.
RoadWays WaysAlike(const Scenario& scenario) {
  Roads roads = *scenario.roads->network;
  for (RoadClass& road_class : roads.classes) {
    // The peer closes cycleways to people on foot; we do not (docs/guide/roads.md).
    if (road_class.name.starts_with("cycleway")) road_class.percent.workers = 0;
    for (std::int32_t* percent : {&road_class.percent.workers, &road_class.percent.vehicles}) {
      if (*percent > 0) *percent = 100;
    }
  }
  return RoadWays(std::make_shared<const Roads>(std::move(roads)), scenario.roads->open_ground, {});
}

int PrintCorners(const Scenario& scenario, Origin from, Origin to) {
  const RoadWays ways = WaysAlike(scenario);
  const LocalFrame frame(*scenario.origin);
  for (const AgentKind kind : {AgentKind::kWorker, AgentKind::kVehicle}) {
    for (const Ways::Corner& corner : ways.Corners(kind, frame.ToPoint(from), frame.ToPoint(to))) {
      const Origin at = frame.ToPlace(corner.at);
      fmt::print("{},{:.7f},{:.7f}\n", ToString(kind), at.latitude_deg, at.longitude_deg);
    }
  }
  return 0;
}

int PrintLengths(const Scenario& scenario, int n, std::uint64_t seed) {
  const Roads& roads = *scenario.roads->network;
  const RoadWays ways = WaysAlike(scenario);
  const LocalFrame frame(*scenario.origin);
  Random random(seed, Stream::kTest);
  fmt::print("from_lat,from_lon,from_id,to_lat,to_lon,to_id,worker_m,vehicle_m\n");
  for (int i = 0; i < n; ++i) {
    const Place from = Draw(roads, &random), to = Draw(roads, &random);
    const Origin begin = frame.ToPlace(from.at), end = frame.ToPlace(to.at);
    fmt::print("{:.7f},{:.7f},{},{:.7f},{:.7f},{},{:.3f},{:.3f}\n", begin.latitude_deg,
               begin.longitude_deg, from.map_id, end.latitude_deg, end.longitude_deg, to.map_id,
               ways.Length(AgentKind::kWorker, from.at, to.at),
               ways.Length(AgentKind::kVehicle, from.at, to.at));
  }
  return 0;
}

}  // namespace
}  // namespace muster::tools

int main(int argc, char** argv) {
  using namespace muster;
  try {
    if (argc != 4 && argc != 6) throw InputError("way_lengths SCENARIO.json N SEED");
    const Scenario scenario = LoadScenario(argv[1]);
    if (!scenario.roads || !scenario.origin) {
      throw InputError(argv[1], "roads, origin", "none", "a scenario with both");
    }
    const auto number = [&](int i) { return std::atof(argv[i]); };
    if (argc == 6) {
      return tools::PrintCorners(scenario, {number(2), number(3)}, {number(4), number(5)});
    }
    return tools::PrintLengths(scenario, std::atoi(argv[2]),
                               static_cast<std::uint64_t>(std::atoi(argv[3])));
  } catch (const std::exception& error) {
    fmt::print(stderr, "way_lengths: {}\n", error.what());
    return 2;
  }
}
