#include "tools/live/mission_geojson.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/map/local_frame.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

class Features {
 public:
  explicit Features(Origin corner) : frame_(corner) {}

  void Add(const std::string& id, Point at, Json properties) {
    const Origin place = frame_.ToPlace(at);
    list_.push_back(
        {{"type", "Feature"},
         {"id", id},
         {"geometry",
          {{"type", "Point"}, {"coordinates", {place.longitude_deg, place.latitude_deg}}}},
         {"properties", std::move(properties)}});
  }
  std::string Text() const {
    return Json{{"type", "FeatureCollection"}, {"features", list_}}.dump(
        -1, ' ', false, Json::error_handler_t::replace);
  }

 private:
  LocalFrame frame_;
  Json list_ = Json::array();
};

/// Minutes of the mission; null: never.
Json Minutes(TimeUs t) { return t == kNever ? Json() : Json(ToMinutes(t)); }

void AddTasks(const Timeline& timeline, Features* features) {
  const Scenario& scenario = timeline.scenario();
  std::map<std::int32_t, const activity_t*> latest;  // sensing, by task
  for (const activity_t& a : timeline.activities().rows) {
    if (a.kind == ActivityKind::kSensing) latest[a.site_id] = &a;
  }
  for (std::size_t x = 0; x < scenario.n_tasks(); ++x) {
    const Task& task = scenario.tasks[x];
    const auto& changes = timeline.tasks()[x].rows;
    const auto status =
        changes.empty() ? TaskStatus::kOpen : static_cast<TaskStatus>(changes.back().status);
    if (status == TaskStatus::kUnreported) continue;
    Json properties = {{"kind", "task"},
                       {"task", x},
                       {"name", task.name},
                       {"status", ToString(status)},
                       {"priority", static_cast<int>(task.priority)},
                       {"reported_min", Minutes(task.reported_us)},
                       {"due_min", Minutes(task.due_us)},
                       {"expires_min", Minutes(task.expires_us)},
                       {"external_id", task.external_id}};
    const auto activity = latest.find(static_cast<std::int32_t>(x));
    if (activity != latest.end() && status != TaskStatus::kOpen) {
      properties["uav"] = activity->second->uav_id;
      properties["worker"] = activity->second->partner_id;
      properties["begins_min"] = Minutes(activity->second->start_us);
      properties["ends_min"] = Minutes(activity->second->end_us);
    }
    features->Add(fmt::format("task:{}", x), task.at, std::move(properties));
  }
}

void AddAgents(const Timeline& timeline, Features* features) {
  for (const AgentKind kind : kAgentKinds) {
    for (std::size_t id = 0; id < timeline.scenario().n_agents(kind); ++id) {
      const Timeline::Agent& agent = timeline.agents()[timeline.IndexOf(kind, id)];
      if (!agent.last) continue;
      const std::string name = fmt::format("{}:{}", ToString(kind), id);
      Json properties = {{"kind", ToString(kind)},
                         {"agent", name},
                         {"status", ToString<AgentStatus>(agent.last->status)}};
      if (kind == AgentKind::kUav) properties["range_km"] = agent.last->range_left_m / 1000;
      features->Add(name, {agent.last->x_m, agent.last->y_m}, std::move(properties));
    }
  }
}

}  // namespace

std::optional<std::string> MissionGeoJson(const Timeline& timeline) {
  const Scenario& scenario = timeline.scenario();
  if (!scenario.origin) return {};
  Features features(*scenario.origin);
  AddTasks(timeline, &features);
  for (std::size_t y = 0; y < scenario.charging_points.size(); ++y) {
    features.Add(fmt::format("charge:{}", y), scenario.charging_points[y].at,
                 {{"kind", "charging point"}});
  }
  AddAgents(timeline, &features);
  return features.Text();
}

}  // namespace muster::tools
