#include <fmt/format.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "base/check.h"
#include "model/agent.h"
#include "tools/files/new_folder.h"
#include "tools/log/closed_roads.h"
#include "tools/log/export.h"
#include "tools/log/legs.h"
#include "tools/log/mission_stream.h"

namespace muster::tools {
namespace {

using nlohmann::ordered_json;

/// A FeatureCollection, written feature by feature.
class Collection {
 public:
  explicit Collection(NewFolder::File* file) : file_(file) {
    file_->Write("{\"type\": \"FeatureCollection\", \"features\": [");
  }
  void Add(const ordered_json& geometry, const ordered_json& properties) {
    const ordered_json feature = {
        {"type", "Feature"}, {"geometry", geometry}, {"properties", properties}};
    file_->Write((first_ ? "\n" : ",\n") + feature.dump());
    first_ = false;
  }
  void End() { file_->Write("\n]}\n"); }

 private:
  NewFolder::File* file_;
  bool first_ = true;
};

struct Position {
  double x_m = 0, y_m = 0;
  std::int64_t unix_us = 0;
};

/// An agent's way as a line in space and time. Agents stand still or go straight at one speed, so
/// only the places where that changes are kept: memory does not grow with the ticks. (In degrees
/// such a way is bent, by decimetres on 10 km.)
class Trip {
 public:
  /// Positions in the order of their times; one that is said again or late is left out.
  void Add(const Position& at) {
    if (held_ && at.unix_us <= held_->unix_us) return;
    if (held_ && !bends_.empty() && !OnLine(bends_.back(), *held_, at)) bends_.push_back(*held_);
    if (bends_.empty()) bends_.push_back(at);
    held_ = at;
  }
  /// A line has two points.
  std::vector<Position> Bends() const {
    std::vector<Position> bends = bends_;
    if (held_ && held_->unix_us > bends.back().unix_us) bends.push_back(*held_);
    if (bends.size() < 2) bends.clear();
    return bends;
  }

 private:
  /// Whether `at` lies within a millimetre of the straight way from `from` to `to`.
  static bool OnLine(const Position& from, const Position& at, const Position& to) {
    const double share = static_cast<double>(at.unix_us - from.unix_us) /
                         static_cast<double>(to.unix_us - from.unix_us);
    return std::abs(from.x_m + (to.x_m - from.x_m) * share - at.x_m) < 1e-3 &&
           std::abs(from.y_m + (to.y_m - from.y_m) * share - at.y_m) < 1e-3;
  }

  std::vector<Position> bends_;
  std::optional<Position> held_;  ///< the newest
};

/// Degrees of the places of the map.
class Degrees {
 public:
  explicit Degrees(Origin corner) : local_(corner.latitude_deg, corner.longitude_deg) {}
  ordered_json operator()(Point at) const {
    double latitude = 0, longitude = 0, height = 0;
    local_.Reverse(at.x_m, at.y_m, 0, latitude, longitude, height);
    return ordered_json::array({longitude, latitude});
  }
  ordered_json PointAt(Point at) const { return {{"type", "Point"}, {"coordinates", (*this)(at)}}; }
  ordered_json Line(const std::vector<Point>& places) const {
    ordered_json coordinates = ordered_json::array();
    for (const Point& at : places) coordinates.push_back((*this)(at));
    return {{"type", "LineString"}, {"coordinates", std::move(coordinates)}};
  }

 private:
  GeographicLib::LocalCartesian local_;
};

using Trips = std::map<std::pair<int, std::int32_t>, Trip>;  // by class and id
using DoneTasks = std::map<std::int32_t, event_t>;

ordered_json WayProperties(const Leg& leg, std::int64_t epoch_us) {
  const AgentState& a = leg.agent;
  const std::string_view kind = ToString<AgentKind>(a.kind);
  return {{"agent", fmt::format("{}:{}", kind, a.id)},
          {"class", kind},
          {"decision", a.decision},
          {"action", ToString<ActionKind>(a.action)},
          {"depart", IsoTime(epoch_us + a.depart_us)},
          {"arrive", IsoTime(epoch_us + a.arrive_us)},
          {"until", IsoTime(epoch_us + leg.until_us)},
          {"way_m", a.leg_ways->Length(a.kind, a.from, a.to)},
          {"straight_m", Distance(a.from, a.to)}};
}

void WriteTrips(const Trips& trips, const Degrees& degrees, NewFolder* folder) {
  Collection lines(&folder->Add("trips.geojson"));
  for (const auto& [agent, trip] : trips) {
    ordered_json coordinates = ordered_json::array();
    for (const Position& bend : trip.Bends()) {
      ordered_json at = degrees({bend.x_m, bend.y_m});
      at.push_back(0);
      at.push_back(static_cast<double>(bend.unix_us) * 1e-6);
      coordinates.push_back(std::move(at));
    }
    if (coordinates.empty()) continue;
    const std::string_view kind = ToString<AgentKind>(agent.first);
    lines.Add({{"type", "LineString"}, {"coordinates", std::move(coordinates)}},
              {{"agent", fmt::format("{}:{}", kind, agent.second)}, {"class", kind}});
  }
  lines.End();
}

void WriteSites(const Scenario& scenario, const DoneTasks& done, std::int64_t epoch_us,
                const Degrees& degrees, NewFolder* folder) {
  Collection sites(&folder->Add("sites.geojson"));
  for (std::size_t x = 0; x < scenario.n_tasks(); ++x) {
    const Task& task = scenario.tasks[x];
    ordered_json properties = {
        {"site", fmt::format("task:{}", x)}, {"kind", "task"}, {"cost_m", task.cost_m}};
    const auto event = done.find(static_cast<std::int32_t>(x));
    properties["done"] = event != done.end();
    if (event != done.end()) {
      properties["done_time"] = IsoTime(epoch_us + event->second.at_us);
      properties["uav"] = event->second.uav_id;
      properties["worker"] = event->second.worker_id;
    }
    sites.Add(degrees.PointAt(task.at), properties);
  }
  for (std::size_t y = 0; y < scenario.charging_points.size(); ++y) {
    sites.Add(degrees.PointAt(scenario.charging_points[y].at),
              {{"site", fmt::format("charge:{}", y)}, {"kind", "charging point"}});
  }
  sites.End();
}

/// roads.geojson: every road, with the times for which it was closed.
void WriteRoads(const Scenario& scenario, std::int64_t epoch_us, const Degrees& degrees,
                NewFolder* folder) {
  const Roads& roads = *scenario.roads->network;
  std::map<std::int32_t, ordered_json> closed;
  for (const ClosedRoad& c : ClosedRoadsOf(scenario)) {
    ordered_json times = {
        {"order", c.order}, {"name", c.name}, {"from", IsoTime(epoch_us + c.from_us)}};
    if (c.until_us != kNever) times["until"] = IsoTime(epoch_us + c.until_us);
    closed.try_emplace(c.road, ordered_json::array()).first->second.push_back(std::move(times));
  }
  Collection lines(&folder->Add("roads.geojson"));
  for (std::size_t i = 0; i < roads.roads.size(); ++i) {
    const Road& road = roads.roads[i];
    std::vector<Point> line;
    for (const std::int32_t point : road.points) {
      line.push_back(ToPoint(roads.points[static_cast<std::size_t>(point)]));
    }
    const auto times = closed.find(static_cast<std::int32_t>(i));
    lines.Add(degrees.Line(line),
              {{"road", i},
               {"map_id", road.id},
               {"class", roads.classes[static_cast<std::size_t>(road.road_class)].name},
               {"closed", times == closed.end() ? ordered_json::array() : times->second}});
  }
  lines.End();
}

}  // namespace

void ExportGeoJson(LogSource* source, const std::string& out, std::optional<Origin> origin) {
  const MissionHead head = ReadMissionHead(source);
  const Scenario& scenario = head.scenario;
  if (scenario.origin) origin = scenario.origin;
  if (!origin) {
    throw InputError("scenario", "origin", "none",
                     "latitude and longitude of the south-west corner, or --origin LAT,LON");
  }
  const Degrees degrees(*origin);

  NewFolder folder(out);
  Collection positions(&folder.Add("positions.geojson"));
  Trips trips;
  DoneTasks done;
  Collection ways(&folder.Add("ways.geojson"));
  LegReader legs;
  const auto add_way = [&](const Leg& leg) {
    ways.Add(degrees.Line(leg.Line()), WayProperties(leg, head.epoch_us));
  };
  TimeUs now_us = 0;
  const auto at_end = ForEachMessage(
      source, head.run_id, [&](const Message& message, const Packet&, const Scenario& so_far) {
        if (const auto* e = std::get_if<event_t>(&message)) {
          if (e->kind == EventKind::kSensingDone) done.try_emplace(e->task_id, *e);
        }
        const auto* m = std::get_if<agent_states_t>(&message);
        if (m == nullptr) return;
        now_us = std::max(now_us, m->header.sim_us);
        legs.Add(*m, so_far, add_way);
        const std::int64_t unix_us = head.epoch_us + m->header.sim_us;
        const auto n = static_cast<std::int32_t>(so_far.n_agents(static_cast<AgentKind>(m->kind)));
        for (const agent_t& a : m->agents) {
          if (a.id >= n) continue;  // room for one who has not joined
          const std::string_view kind = ToString<AgentKind>(m->kind);
          positions.Add(degrees.PointAt({a.x_m, a.y_m}),
                        {{"time", IsoTime(unix_us)},
                         {"sim_s", ToSeconds(m->header.sim_us)},
                         {"agent", fmt::format("{}:{}", kind, a.id)},
                         {"class", kind},
                         {"status", ToString<AgentStatus>(a.status)},
                         {"range_left_m", a.range_left_m}});
          trips[{m->kind, a.id}].Add({a.x_m, a.y_m, unix_us});
        }
      });
  positions.End();
  legs.Finish(now_us, add_way);
  ways.End();
  if (at_end && at_end->roads) WriteRoads(*at_end, head.epoch_us, degrees, &folder);
  WriteTrips(trips, degrees, &folder);
  WriteSites(at_end ? *at_end : head.scenario, done, head.epoch_us, degrees, &folder);
  folder.Commit();
}

}  // namespace muster::tools
