#include "scheduler/policies/external/situation_json.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/index.h"

namespace muster::scheduler {
namespace {

using Json = nlohmann::ordered_json;

Json Seconds(TimeUs t) { return t == kNever ? Json() : Json(ToSeconds(t)); }

/// All that is known of a task: a field of the scenario's tasks is one more line here.
Json TaskFields(const Situation& situation, std::size_t x) {
  const Task& task = situation.site->tasks[x];
  const double to_charge_m = situation.site->task_to_charge_m[x];
  Json json = {{"id", x},
               {"x_m", task.at.x_m},
               {"y_m", task.at.y_m},
               {"status", ToString(situation.task_status[x])},
               {"cost_m", task.cost_m},
               {"to_charge_m", std::isfinite(to_charge_m) ? Json(to_charge_m) : Json()}};
  if (task.IsPlain()) return json;
  json["priority"] = static_cast<int>(task.priority);
  json["reported_s"] = Seconds(task.reported_us);
  json["due_s"] = Seconds(task.due_us);
  json["expires_s"] = Seconds(task.expires_us);
  return json;
}

Json ChargingPointFields(const Situation& situation, std::size_t y) {
  const ChargingPoint& point = situation.site->charging_points[y];
  Json capacity, free;  // null: as many as like
  if (point.capacity) {
    capacity = *point.capacity;
    free = situation.free_places(ChargeId(y));
  }
  return {{"id", y},
          {"x_m", point.at.x_m},
          {"y_m", point.at.y_m},
          {"capacity", std::move(capacity)},
          {"free", std::move(free)}};
}

Json AgentFields(const Situation& situation, const AgentState& agent) {
  const TimeUs now = situation.now_us;
  const Point at = PositionAt(agent, now);
  Json json = {{"id", agent.id},
               {"idle", agent.idle(now)},
               {"status", ToString(StatusAt(agent, now))},
               {"x_m", at.x_m},
               {"y_m", at.y_m},
               {"speed_m_s", agent.speed_m_s},
               {"online_from_s", Seconds(agent.online_from_us)},
               {"online_until_s", Seconds(agent.online_until_us)}};
  if (agent.kind == AgentKind::kUav) {
    json["range_m"] = situation.range_m(agent);
    json["range_full_m"] = agent.range_full_m;
  }
  if (agent.kind == AgentKind::kVehicle) json["charge_rate_m_s"] = agent.charge_rate_m_s;
  Json forbidden = Json::array();
  for (const ForbiddenPair& pair : situation.site->forbidden) {
    if (pair.kind == agent.kind && pair.agent == agent.id) forbidden.push_back(pair.task);
  }
  if (!forbidden.empty()) json["forbidden_tasks"] = std::move(forbidden);
  if (!agent.idle(now)) {
    json["action"] = ToString(agent.action);
    json["target"] = agent.site();
    json["partner"] = agent.partner;
    json["free_at_s"] = Seconds(agent.busy_until_us);
    json["free_x_m"] = agent.to.x_m;
    json["free_y_m"] = agent.to.y_m;
  }
  return json;
}

Json NodeFields(const Situation& situation, const Candidates& candidates, const Node& node) {
  const Action action = candidates.ToAction(situation, node);
  Json json = {{"kind", ToString(action.kind)}};
  const auto add = [&json](const char* name, std::int32_t id) {
    if (id >= 0) json[name] = id;
  };
  add("uav", action.uav.value);
  add("worker", action.worker.value);
  add("vehicle", action.vehicle.value);
  add("task", action.task.value);
  add("charge", action.charge.value);
  json["weight"] = node.weight;
  Json elements = Json::array();
  for (const std::int32_t e : ElementsOf(node, candidates.elements)) elements.push_back(e);
  json["elements"] = std::move(elements);
  return json;
}

/// Pairs of nodes that share an element which admits one, each once; null: too many.
Json Edges(const Candidates& candidates) {
  std::vector<std::vector<std::int32_t>> at_element(At(candidates.elements.size()));
  for (std::size_t i = 0; i < candidates.nodes.size(); ++i) {
    for (const std::int32_t e : ElementsOf(candidates.nodes[i], candidates.elements)) {
      if (candidates.elements.capacity[At(e)] == 1) {
        at_element[At(e)].push_back(static_cast<std::int32_t>(i));
      }
    }
  }
  std::size_t pairs = 0;  // those that share two elements counted twice
  for (const auto& nodes : at_element) pairs += nodes.size() * (nodes.size() - 1) / 2;
  if (pairs > 2 * kMostEdges) return {};
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  for (const auto& nodes : at_element) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      for (std::size_t j = i + 1; j < nodes.size(); ++j) edges.emplace_back(nodes[i], nodes[j]);
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  if (edges.size() > kMostEdges) return {};
  Json json = Json::array();
  for (const auto& [i, j] : edges) json.push_back(Json::array({i, j}));
  return json;
}

}  // namespace

Json ToJson(const Situation& situation) {
  const Site& site = *situation.site;
  Json json = {
      {"decision", situation.decision},
      {"now_s", Seconds(situation.now_us)},
      {"seed", site.seed},
      {"width_m", site.width_m},
      {"height_m", site.height_m},
      {"rules",
       {{"interval_s", Seconds(site.rules.interval_us)},
        {"limit_s", Seconds(site.rules.limit_us)},
        {"availability", site.rules.availability == Availability::kStrict ? "strict" : "overrun"},
        {"start_on_meeting", site.rules.start_on_meeting}}}};
  for (const AgentKind kind : kAgentKinds) {
    Json agents = Json::array();
    for (const AgentState& agent : situation.agents(kind)) {
      agents.push_back(AgentFields(situation, agent));
    }
    json[std::string(ToString(kind)) + "s"] = std::move(agents);
  }
  Json tasks = Json::array(), points = Json::array();
  for (std::size_t x = 0; x < site.tasks.size(); ++x) {
    if (situation.task_status[x] != TaskStatus::kUnreported)
      tasks.push_back(TaskFields(situation, x));
  }
  for (std::size_t y = 0; y < site.charging_points.size(); ++y) {
    points.push_back(ChargingPointFields(situation, y));
  }
  json["tasks"] = std::move(tasks);
  json["charging_points"] = std::move(points);
  return json;
}

void AddGraph(const Situation& situation, const Candidates& candidates, const GraphWishes& wishes,
              Json* json) {
  if (candidates.nodes.size() > kMostNodes) {
    (*json)["elements"] = (*json)["nodes"] = nullptr;
    if (wishes.edges) (*json)["edges"] = nullptr;
    return;
  }
  Json elements = Json::array(), nodes = Json::array();
  for (std::int32_t e = 0; e < candidates.elements.size(); ++e) {
    const std::int32_t admits = candidates.elements.capacity[At(e)];
    elements.push_back(
        {{"name", candidates.NameOf(e)},
         {"admits", admits == std::numeric_limits<std::int32_t>::max() ? Json() : Json(admits)}});
  }
  for (const Node& node : candidates.nodes) {
    nodes.push_back(NodeFields(situation, candidates, node));
  }
  (*json)["elements"] = std::move(elements);
  (*json)["nodes"] = std::move(nodes);
  if (wishes.edges) (*json)["edges"] = Edges(candidates);
}

}  // namespace muster::scheduler
