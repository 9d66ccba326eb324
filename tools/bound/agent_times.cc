#include "tools/bound/agent_times.h"

#include <algorithm>

#include "base/index.h"
#include "model/feasibility.h"

namespace muster::tools {
namespace {

/// To the end of an activity that takes so long after that way; never: no way leads there.
TimeUs TakesUs(double way_m, double speed_m_s, TimeUs activity_us) {
  const TimeUs travel_us = TravelUs(way_m, speed_m_s);
  if (travel_us == kNever || activity_us == kNever) return kNever;
  return std::max<TimeUs>(0, travel_us - kRoundingUs) + activity_us;
}

std::vector<TimeUs> TakeUs(std::span<const double> way_m, double speed_m_s,
                           std::span<const TimeUs> activity_us) {
  std::vector<TimeUs> us;
  for (std::size_t i = 0; i < activity_us.size(); ++i) {
    us.push_back(TakesUs(way_m[i], speed_m_s, activity_us[i]));
  }
  return us;
}

}  // namespace

AgentTimes::AgentTimes(const Scenario& scenario)
    : scenario_(scenario),
      interval_us_(scenario.rules.interval_us),
      decisions_(
          static_cast<std::int32_t>((scenario.rules.limit_us + interval_us_ - 1) / interval_us_) +
          1) {
  for (const Task& task : std::span(scenario.tasks).first(scenario.n_tasks())) {
    tasks_.push_back(task.at);
  }
  for (const ChargingPoint& point : scenario.charging_points) charging_.push_back(point.at);
  places_ = tasks_;
  places_.insert(places_.end(), charging_.begin(), charging_.end());
  double fastest_m_s = 0;
  for (const AgentSpec& uav : scenario.uavs) fastest_m_s = std::max(fastest_m_s, uav.speed_m_s);
  for (const AgentSpec& uav : scenario.uavs) AddUav(uav);
  const std::vector<TimeUs> sensing_us = SensingTimes(fastest_m_s);
  for (const AgentSpec& worker : scenario.workers) {
    AddPartner(AgentKind::kWorker, worker, sensing_us);
  }
  const std::vector<TimeUs> charging_us(charging_.size(), 0);
  for (const AgentSpec& vehicle : scenario.vehicles) {
    AddPartner(AgentKind::kVehicle, vehicle, charging_us);
  }
}

AgentReach AgentTimes::ReachOf(const AgentSpec& agent) const {
  const Rules& rules = scenario_.rules;
  AgentReach times;
  times.first = static_cast<std::int32_t>((agent.online_from_us + interval_us_ - 1) / interval_us_);
  const TimeUs end_us = std::min(agent.online_until_us, rules.limit_us);
  times.last = static_cast<std::int32_t>((end_us + interval_us_ - 1) / interval_us_) - 1;
  times.latest_us = rules.availability == Availability::kStrict ? end_us : rules.limit_us;
  return times;
}

std::vector<TimeUs> AgentTimes::SensingTimes(double uav_speed_m_s) const {
  std::vector<TimeUs> times;
  for (std::size_t x = 0; x < tasks_.size(); ++x) {
    times.push_back(SensingUs(scenario_.tasks[x].cost_m, uav_speed_m_s));
  }
  return times;
}

/// `way_m`: [places, sites]; `activity_us`: [sites] how long the activity takes.
Timetable AgentTimes::TableOf(std::span<const double> way_m, std::span<const TimeUs> activity_us,
                              double speed_m_s) const {
  Timetable table;
  table.interval_us = interval_us_;
  table.decisions = decisions_;
  const std::size_t n = activity_us.size();
  for (std::size_t i = 0; i < way_m.size(); ++i) {
    const TimeUs us = TakesUs(way_m[i], speed_m_s, activity_us[i % n]);
    table.between_us.push_back(us);
    table.between.push_back(us > scenario_.rules.limit_us ? decisions_ : table.DecisionAfter(us));
  }
  table.from.assign(n, 1);
  table.until.assign(n, decisions_ - 1);
  return table;
}

/// A task is unknown before it is reported, and sensing has to begin before it expires.
void AgentTimes::LimitToTaskTimes(std::span<const TimeUs> sensing_us, Timetable* table) const {
  const TimeUs limit_us = scenario_.rules.limit_us;
  for (std::size_t x = 0; x < tasks_.size(); ++x) {
    const Task& task = scenario_.tasks[x];
    if (task.reported_us > limit_us || sensing_us[x] > limit_us) {
      table->until[x] = 0;
      continue;
    }
    const TimeUs known_us = table->DecisionAfter(task.reported_us) * interval_us_;
    table->from[x] = std::max(1, table->DecisionAfter(known_us + sensing_us[x]));
    if (task.expires_us > limit_us) continue;
    table->until[x] =
        std::min(table->until[x], table->DecisionAfter(task.expires_us + sensing_us[x]));
  }
}

std::vector<double> AgentTimes::Ways(AgentKind kind, std::span<const Point> from,
                                     std::span<const Point> to) const {
  std::vector<double> way_m(from.size() * to.size());
  scenario_.ways->Lengths(kind, from, to, way_m);
  return way_m;
}

void AgentTimes::AddUav(const AgentSpec& uav) {
  const std::vector<TimeUs> sensing_us = SensingTimes(uav.speed_m_s);
  const auto [found, is_new] = uav_tables_.try_emplace(uav.speed_m_s);
  UavTable& table = found->second;
  if (is_new) {
    table.way_m = Ways(AgentKind::kUav, places_, places_);
    table.tasks = TableOf(Ways(AgentKind::kUav, places_, tasks_), sensing_us, uav.speed_m_s);
    LimitToTaskTimes(sensing_us, &table.tasks);
    for (std::size_t x = 0; x < tasks_.size(); ++x) {
      table.cost_m.push_back(scenario_.tasks[x].cost_m);
      table.to_charge_m.push_back(
          NearestChargeM(*scenario_.ways, tasks_[x], scenario_.charging_points));
    }
    for (const AgentSpec& vehicle : scenario_.vehicles) {
      table.most_charge_m_s = std::max(table.most_charge_m_s, vehicle.charge_rate_m_s);
    }
    table.charging_points = charging_.size();
  }
  UavTimes times;
  times.start_m = Ways(AgentKind::kUav, std::span(&uav.at, 1), places_);
  times.tasks = ReachOf(uav);
  times.tasks.from_start = TakeUs(times.start_m, uav.speed_m_s, sensing_us);
  times.speed_m_s = uav.speed_m_s;
  times.range_m = uav.range_m;
  times.range_full_m = uav.range_full_m;
  uavs_.push_back({&table, std::move(times)});
}

void AgentTimes::AddPartner(AgentKind kind, const AgentSpec& agent,
                            std::span<const TimeUs> activity_us) {
  const bool is_worker = kind == AgentKind::kWorker;
  const std::vector<Point>& sites = is_worker ? tasks_ : charging_;
  auto& tables = is_worker ? worker_tables_ : vehicle_tables_;
  const auto [found, is_new] = tables.try_emplace(agent.speed_m_s);
  if (is_new) {
    found->second = TableOf(Ways(kind, sites, sites), activity_us, agent.speed_m_s);
    if (is_worker) LimitToTaskTimes(activity_us, &found->second);
    found->second.again = !is_worker;
  }
  AgentReach times = ReachOf(agent);
  times.from_start =
      TakeUs(Ways(kind, std::span(&agent.at, 1), sites), agent.speed_m_s, activity_us);
  (is_worker ? workers_ : vehicles_).push_back({&found->second, std::move(times)});
}

}  // namespace muster::tools
