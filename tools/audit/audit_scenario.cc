#include "tools/audit/audit_scenario.h"

#include <glib.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "tools/audit/road_ways.h"

namespace muster::tools::audit {
namespace {

using nlohmann::json;

constexpr const char* kLists[] = {"uavs", "workers", "vehicles"};
constexpr double kKm = 1000;
constexpr double kKmPerMin = 1000.0 / 60;

std::int64_t Microseconds(const json& value, double unit_us) {
  return std::llround(value.get<double>() * unit_us);
}
std::int64_t Minutes(const json& value) { return Microseconds(value, 60e6); }
std::int64_t MinutesOr(const json& item, const char* key, std::int64_t otherwise_us) {
  return item.contains(key) ? Minutes(item.at(key)) : otherwise_us;
}

Place PlaceOf(const json& item) {
  return {item.at("x_km").get<double>() * kKm, item.at("y_km").get<double>() * kKm};
}

Interval IntervalOf(const json& disturbances, const char* key, double unit) {
  if (!disturbances.contains(key)) return {};
  const json& ends = disturbances.at(key);
  return {ends.at(0).get<double>() * unit, ends.at(1).get<double>() * unit};
}

Scenario::Agent AgentOf(const json& item, int kind) {
  Scenario::Agent agent;
  agent.at = PlaceOf(item);
  agent.speed_m_s = item.at("speed_km_per_min").get<double>() * kKmPerMin;
  if (kind == kUav) {
    agent.range_full_m = item.at("full_range_km").get<double>() * kKm;
    agent.range_m = item.value("range_km", item.at("full_range_km").get<double>()) * kKm;
  }
  if (kind == kVehicle) {
    agent.charge_rate_m_s = item.at("charge_km_per_min").get<double>() * kKmPerMin;
  }
  return agent;
}

std::vector<Scenario::Agent> AgentsOf(const json& list, int kind) {
  std::vector<Scenario::Agent> agents;
  for (const json& item : list) {
    Scenario::Agent agent = AgentOf(item, kind);
    agent.online_from_us = Minutes(item.at("online_from_min"));
    agent.online_until_us = Minutes(item.at("online_until_min"));
    agent.measured = item.value("measured", false);
    agents.push_back(agent);
  }
  return agents;
}

std::shared_ptr<const RoadWays> WaysOf(const json& top, const std::string& roads,
                                       const std::vector<Scenario::Charge>& charges) {
  const json& key = top.at("roads");
  if (const std::string found = Sha256Of(roads); found != key.at("sha256").get<std::string>()) {
    throw std::invalid_argument("roads_t has the SHA-256 " + found + ", the scenario names " +
                                key.at("sha256").get<std::string>());
  }
  OpenGround ground[3] = {{}, {50, 1000}, {25, 1000}};
  const json open = key.value("open_ground", json::object());
  for (const int kind : {kWorker, kVehicle}) {
    if (!open.contains(kLists[kind])) continue;
    const json& its = open.at(kLists[kind]);
    ground[kind] = {its.at("percent").get<std::int64_t>(), its.at("reach_km").get<double>() * kKm};
  }
  std::vector<Place> sites;
  for (const json& task : top.at("tasks")) sites.push_back(PlaceOf(task));
  for (const Scenario::Charge& charge : charges) sites.push_back(charge.at);
  return ReadRoadWays(roads, ground, sites);
}

/// UAVs' ways to the nearest of some places, in time that hardly grows with their number: only
/// those less far to the east or west than the nearest so far are looked at.
class Nearest {
 public:
  Nearest(const std::vector<Scenario::Charge>& charges, const Ways& ways) : ways_(ways) {
    for (const Scenario::Charge& charge : charges) places_.push_back(charge.at);
    std::sort(places_.begin(), places_.end(),
              [](Place a, Place b) { return std::pair(a.x_m, a.y_m) < std::pair(b.x_m, b.y_m); });
  }

  /// Metres; infinity where there is none.
  double WayFrom(Place at) const {
    double nearest = std::numeric_limits<double>::infinity();
    const auto offer = [&](Place place) {
      if (Apart(at, place) < nearest) nearest = std::min(nearest, ways_.Length(kUav, at, place));
    };
    const auto middle =
        std::lower_bound(places_.begin(), places_.end(), at.x_m,
                         [](const Place& place, double x_m) { return place.x_m < x_m; });
    for (auto east = middle; east != places_.end() && east->x_m - at.x_m <= nearest; ++east) {
      offer(*east);
    }
    for (auto west = middle; west != places_.begin();) {
      --west;
      if (at.x_m - west->x_m > nearest) break;
      offer(*west);
    }
    return nearest;
  }

 private:
  const Ways& ways_;
  std::vector<Place> places_;  ///< from west to east
};

void TakeAir(const json& air, Scenario* s) {
  s->margin_m = air.value("margin_km", 0.03) * kKm;
  const json said = air.value("separation", json::object());
  if (said.is_object()) {
    const Scenario::Separation usual;
    s->separation = {
        said.value("horizontal_m", usual.across_m), said.value("vertical_m", usual.above_m),
        said.value("lowest_m", usual.lowest_m), said.value("ceiling_m", usual.ceiling_m)};
  }
  for (const json& zone : air.value("zones", json::array())) {
    const double lower_m = zone.value("lower_m", 0.0);
    const bool is_high =
        s->separation && lower_m >= s->separation->lowest_m + s->separation->above_m;
    s->zones.push_back({is_high ? kForever : MinutesOr(zone, "from_min", 0)});
    if (!is_high) continue;
    s->high_zones.push_back({ReadZone(zone.dump()), lower_m - s->separation->above_m,
                             MinutesOr(zone, "until_min", kForever)});
  }
  s->TakeWays();
}

}  // namespace

std::int64_t Scenario::TimeOf(std::int64_t tick) const {
  return tick >= last_tick() ? limit_us : tick * tick_us;
}

const Ways& Scenario::WaysAt(std::int64_t t) const {
  for (auto change = changes.rbegin(); change != changes.rend(); ++change) {
    if (change->first <= t) return *change->second;
  }
  return *ways;
}

std::set<int> Scenario::ClosedRoads() const {
  std::set<int> all;
  for (const Closed& one : closed) all.insert(one.roads.begin(), one.roads.end());
  return all;
}

void Scenario::TakeWays() {
  const std::set<int> shut = ClosedRoads();
  std::shared_ptr<const Ways> ground = DefaultWays();
  if (roads != nullptr) ground = shut.empty() ? roads : roads->Without(shut);
  if (!margin_m) {
    ways = std::move(ground);
    return;
  }
  std::vector<Rings> around;
  for (const Closed& one : closed) {
    if (!one.zone.empty()) around.push_back(one.zone);
  }
  ways = FlyAround(std::move(around), *margin_m, width_m, height_m, std::move(ground));
  const Nearest charging(charges, *ways);
  for (Task& task : tasks) task.to_charge_m = charging.WayFrom(task.at);
}

std::int32_t Scenario::DecisionAt(std::int64_t tick) const {
  const std::int64_t t = TimeOf(tick);
  if (t >= limit_us || (t % interval_us != 0 && !extra_ticks.contains(tick))) return -1;
  std::int64_t before = (t + interval_us - 1) / interval_us;
  for (const std::int64_t extra : extra_ticks) {
    if (extra < tick && TimeOf(extra) % interval_us != 0) ++before;
  }
  return static_cast<std::int32_t>(before);
}

std::int64_t Scenario::TimeOfDecision(std::int32_t decision) const {
  for (std::int64_t tick = 0; tick < last_tick(); ++tick) {
    if (DecisionAt(tick) == decision) return TimeOf(tick);
  }
  return limit_us;
}

bool NamesRoads(const std::string& text) { return json::parse(text).contains("roads"); }

Scenario ParseScenario(const std::string& text, const std::string& roads) {
  const json top = json::parse(text);
  Scenario s;
  s.seed = top.at("seed").get<std::uint64_t>();
  s.interval_us = Minutes(top.at("interval_min"));
  s.limit_us = Minutes(top.at("limit_min"));
  s.width_m = top.at("area_km").at(0).get<double>() * kKm;
  s.height_m = top.at("area_km").at(1).get<double>() * kKm;
  const json rules = top.value("rules", json::object());
  s.tick_us = rules.contains("tick_s") ? Microseconds(rules.at("tick_s"), 1e6) : 30'000'000;
  s.patience_us = MinutesOr(rules, "patience_min", 600'000'000);
  s.strict = rules.value("availability", "strict") == "strict";
  s.start_on_meeting = rules.value("start_on_meeting", false);
  s.emergencies_at_once = rules.value("emergencies_at_once", false);
  const json disturbances = top.value("disturbances", json::object());
  s.wind = IntervalOf(disturbances, "wind", 1);
  s.communication_m = IntervalOf(disturbances, "communication_km", kKm);
  s.agent_failure = IntervalOf(disturbances, "agent_failure", 1);
  s.match_failure = IntervalOf(disturbances, "match_failure", 1);
  if (s.interval_us <= 0 || s.limit_us <= 0 || s.tick_us <= 0 || s.interval_us % s.tick_us != 0) {
    throw std::invalid_argument("interval, limit and tick do not fit");
  }
  for (const int kind : kClasses) s.agents[kind] = AgentsOf(top.at(kLists[kind]), kind);
  for (const json& item : top.at("charging_points")) {
    Scenario::Charge charge{PlaceOf(item), 1};
    if (item.contains("capacity")) {
      charge.capacity =
          item.at("capacity").is_null() ? kForever : item.at("capacity").get<std::int64_t>();
    }
    s.charges.push_back(charge);
  }
  if (top.contains("roads")) {
    s.ways = s.roads = WaysOf(top, roads, s.charges);
    for (const json& closure : top.at("roads").value("closures", json::array())) {
      s.closures.push_back({MinutesOr(closure, "from_min", 0)});
    }
  }
  if (top.contains("air")) TakeAir(top.at("air"), &s);
  const Nearest charging(s.charges, *s.ways);
  for (const json& item : top.at("tasks")) {
    const Place at = PlaceOf(item);
    s.tasks.push_back({at, item.at("cost_km").get<double>() * kKm, charging.WayFrom(at),
                       MinutesOr(item, "reported_min", 0), MinutesOr(item, "expires_min", kForever),
                       item.value("priority", 1)});
  }
  if (top.contains("room")) {
    const json& room = top.at("room");
    s.room_tasks = room.value("tasks", 0);
    Scenario::Task vacant;
    vacant.reported_us = kForever;
    s.tasks.resize(s.tasks.size() + static_cast<std::size_t>(s.room_tasks), vacant);
    for (const int kind : kClasses) {
      s.room_agents[kind] = room.value(kLists[kind], 0);
      Scenario::Agent never_online;
      never_online.speed_m_s = 1;
      never_online.range_full_m = kind == kUav ? 1 : 0;
      never_online.charge_rate_m_s = kind == kVehicle ? 1 : 0;
      auto& agents = s.agents[kind];
      agents.resize(agents.size() + static_cast<std::size_t>(s.room_agents[kind]), never_online);
    }
  }
  return s;
}

namespace {

int ClassNamed(const std::string& name) {
  return name == "uav" ? kUav : name == "worker" ? kWorker : kVehicle;
}

void ReadDirective(const json& top, const std::string& text, AuditOrder* order) {
  Scenario::Directive& directive = order->directive;
  directive.what = order->what;
  directive.task = top.value("task", -1);
  directive.charge = top.value("charge", -1);
  order->closure = top.value("directive", "");
  const auto name = [&](const std::string& agent) {
    const std::size_t colon = agent.find(':');
    directive.agents[ClassNamed(agent.substr(0, colon))] = std::stoi(agent.substr(colon + 1));
  };
  if (top.contains("agent")) name(top.at("agent").get<std::string>());
  if (top.contains("agents")) {
    for (const json& agent : top.at("agents")) name(agent.get<std::string>());
  }
  if (order->what == "go_to") directive.place = PlaceOf(top);
  if (top.contains("class")) {
    directive.of_class = ClassNamed(top.at("class").get<std::string>());
    directive.area = ReadZone(text);
  }
}

}  // namespace

AuditOrder ParseAuditOrder(const std::string& text, std::int64_t now_us, const Scenario& scenario) {
  const json top = json::parse(text);
  AuditOrder order;
  order.what = top.at("order").get<std::string>();
  if (top.contains("signed")) order.by = top.at("signed").at("by").get<std::string>();
  if (order.is_withdrawal()) order.closure = top.at("withdraws").get<std::string>();
  const auto time = [&](const json& item, const char* at, const char* in) {
    return item.contains(in) ? now_us + Minutes(item.at(in)) : MinutesOr(item, at, kForever);
  };
  if (order.is_add()) {
    const json& item = top.at("task");
    Scenario::Task& task = order.new_task;
    task.at = PlaceOf(item);
    task.cost_m = item.value("cost_km", 3.0) * kKm;
    task.to_charge_m = Nearest(scenario.charges, *scenario.ways).WayFrom(task.at);
    task.reported_us = std::max(MinutesOr(item, "reported_min", 0), now_us);
    task.expires_us = time(item, "expires_min", "expires_in_min");
    task.priority = item.value("priority", 1);
  }
  if (order.what == "task_change" &&
      (top.contains("expires_min") || top.contains("expires_in_min"))) {
    order.expires_us = time(top, "expires_min", "expires_in_min");
  }
  if (order.what == "task_change" && top.contains("priority")) {
    order.priority = top.at("priority").get<int>();
  }
  if (order.is_roads()) {
    if (scenario.roads == nullptr) throw std::invalid_argument("there are no roads");
    order.closure = top.value("closure", "");
    if (order.closure.empty()) order.roads = scenario.roads->RoadsIn(text);
    order.since_us = std::min(now_us, MinutesOr(top, "since_min", now_us));
    order.until_us = time(top, "until_min", "until_in_min");
  }
  if (order.is_zone()) {
    if (!scenario.margin_m) throw std::invalid_argument("the scenario has no key air");
    order.closure = top.value("zone", "");
    if (order.closure.empty()) order.zone = ReadZone(text);
    order.since_us = now_us;
    order.until_us = time(top, "until_min", "until_in_min");
  }
  if (order.is_directive()) ReadDirective(top, text, &order);
  if (order.is_join()) {
    const json& item = top.at("agent");
    const std::string of = top.at("class").get<std::string>();
    order.new_agent = AgentOf(item, of == "uav" ? kUav : of == "worker" ? kWorker : kVehicle);
    order.new_agent.online_from_us = std::max(MinutesOr(item, "online_from_min", 0), now_us);
    order.new_agent.online_until_us = MinutesOr(item, "online_until_min", scenario.limit_us);
  }
  return order;
}

std::string Sha256Of(const std::string& bytes) {
  gchar* hex = g_compute_checksum_for_data(
      G_CHECKSUM_SHA256, reinterpret_cast<const guchar*>(bytes.data()), bytes.size());
  std::string text = hex;
  g_free(hex);
  return text;
}

}  // namespace muster::tools::audit
