#include "tools/audit/audit_scenario.h"

#include <glib.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

namespace muster::tools::audit {
namespace {

using nlohmann::json;

constexpr double kKm = 1000;
constexpr double kKmPerMin = 1000.0 / 60;

std::int64_t Microseconds(const json& value, double unit_us) {
  return std::llround(value.get<double>() * unit_us);
}
std::int64_t Minutes(const json& value) { return Microseconds(value, 60e6); }

Place PlaceOf(const json& item) {
  return {item.at("x_km").get<double>() * kKm, item.at("y_km").get<double>() * kKm};
}

Interval IntervalOf(const json& disturbances, const char* key, double unit) {
  if (!disturbances.contains(key)) return {};
  const json& ends = disturbances.at(key);
  return {ends.at(0).get<double>() * unit, ends.at(1).get<double>() * unit};
}

std::vector<Scenario::Agent> AgentsOf(const json& list, Class kind) {
  std::vector<Scenario::Agent> agents;
  for (const json& item : list) {
    Scenario::Agent agent;
    agent.at = PlaceOf(item);
    agent.speed_m_s = item.at("speed_km_per_min").get<double>() * kKmPerMin;
    if (kind == kUav) {
      agent.range_full_m = item.at("full_range_km").get<double>() * kKm;
      agent.range_m = item.at("range_km").get<double>() * kKm;
    }
    if (kind == kVehicle) {
      agent.charge_rate_m_s = item.at("charge_km_per_min").get<double>() * kKmPerMin;
    }
    agent.online_from_us = Minutes(item.at("online_from_min"));
    agent.online_until_us = Minutes(item.at("online_until_min"));
    agents.push_back(agent);
  }
  return agents;
}

/// Ways to the nearest of some places, in time that hardly grows with their number: only those less
/// far to the east or west than the nearest so far are looked at.
class Nearest {
 public:
  explicit Nearest(const std::vector<Scenario::Charge>& charges) {
    for (const Scenario::Charge& charge : charges) places_.push_back(charge.at);
    std::sort(places_.begin(), places_.end(),
              [](Place a, Place b) { return std::pair(a.x_m, a.y_m) < std::pair(b.x_m, b.y_m); });
  }

  /// Metres; infinity where there is none.
  double WayFrom(Place at) const {
    double nearest = std::numeric_limits<double>::infinity();
    const auto middle =
        std::lower_bound(places_.begin(), places_.end(), at.x_m,
                         [](const Place& place, double x_m) { return place.x_m < x_m; });
    for (auto east = middle; east != places_.end() && east->x_m - at.x_m <= nearest; ++east) {
      nearest = std::min(nearest, Way(at, *east));
    }
    for (auto west = middle; west != places_.begin();) {
      --west;
      if (at.x_m - west->x_m > nearest) break;
      nearest = std::min(nearest, Way(at, *west));
    }
    return nearest;
  }

 private:
  std::vector<Place> places_;  ///< from west to east
};

}  // namespace

double Way(Place a, Place b) { return std::hypot(b.x_m - a.x_m, b.y_m - a.y_m); }

std::int64_t Scenario::TimeOf(std::int64_t tick) const {
  return tick >= last_tick() ? limit_us : tick * tick_us;
}

std::int32_t Scenario::DecisionAt(std::int64_t tick) const {
  const std::int64_t t = TimeOf(tick);
  return t < limit_us && t % interval_us == 0 ? static_cast<std::int32_t>(t / interval_us) : -1;
}

Scenario ParseScenario(const std::string& text) {
  const json top = json::parse(text);
  Scenario s;
  s.seed = top.at("seed").get<std::uint64_t>();
  s.interval_us = Minutes(top.at("interval_min"));
  s.limit_us = Minutes(top.at("limit_min"));
  s.width_m = top.at("area_km").at(0).get<double>() * kKm;
  s.height_m = top.at("area_km").at(1).get<double>() * kKm;
  const json rules = top.value("rules", json::object());
  s.tick_us = rules.contains("tick_s") ? Microseconds(rules.at("tick_s"), 1e6) : 30'000'000;
  s.strict = rules.value("availability", "strict") == "strict";
  s.start_on_meeting = rules.value("start_on_meeting", false);
  const json disturbances = top.value("disturbances", json::object());
  s.wind = IntervalOf(disturbances, "wind", 1);
  s.communication_m = IntervalOf(disturbances, "communication_km", kKm);
  s.agent_failure = IntervalOf(disturbances, "agent_failure", 1);
  s.match_failure = IntervalOf(disturbances, "match_failure", 1);
  if (s.interval_us <= 0 || s.limit_us <= 0 || s.tick_us <= 0 || s.interval_us % s.tick_us != 0) {
    throw std::invalid_argument("interval, limit and tick do not fit");
  }
  s.agents[kUav] = AgentsOf(top.at("uavs"), kUav);
  s.agents[kWorker] = AgentsOf(top.at("workers"), kWorker);
  s.agents[kVehicle] = AgentsOf(top.at("vehicles"), kVehicle);
  for (const json& item : top.at("charging_points")) {
    Scenario::Charge charge{PlaceOf(item), 1};
    if (item.contains("capacity")) {
      charge.capacity =
          item.at("capacity").is_null() ? kForever : item.at("capacity").get<std::int64_t>();
    }
    s.charges.push_back(charge);
  }
  const Nearest charging(s.charges);
  for (const json& item : top.at("tasks")) {
    const Place at = PlaceOf(item);
    Scenario::Task task{at, item.at("cost_km").get<double>() * kKm, charging.WayFrom(at)};
    if (item.contains("reported_min")) task.reported_us = Minutes(item.at("reported_min"));
    if (item.contains("expires_min")) task.expires_us = Minutes(item.at("expires_min"));
    s.tasks.push_back(task);
  }
  return s;
}

std::string Sha256Of(const std::string& bytes) {
  gchar* hex = g_compute_checksum_for_data(
      G_CHECKSUM_SHA256, reinterpret_cast<const guchar*>(bytes.data()), bytes.size());
  const std::string text = hex;
  g_free(hex);
  return text;
}

}  // namespace muster::tools::audit
