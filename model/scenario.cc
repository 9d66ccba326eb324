#include "model/scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <utility>

#include "base/check.h"
#include "model/air_ways.h"

namespace muster {
namespace {

/// What the ways of a scenario with roads depend on.
using RoadsKey = std::pair<std::string, std::vector<double>>;

/// Missions in one process share the ways of equal scenarios, and so what was found on them.
std::shared_ptr<const RoadWays> SharedWays(RoadsKey key, const std::function<RoadWays*()>& make) {
  static std::mutex mutex;
  static std::map<RoadsKey, std::weak_ptr<const RoadWays>> known;
  const std::lock_guard lock(mutex);
  std::erase_if(known, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<const RoadWays>& entry = known[std::move(key)];
  std::shared_ptr<const RoadWays> ways = entry.lock();
  if (ways == nullptr) {
    ways.reset(make());
    entry = ways;
  }
  return ways;
}

/// The ways with what is closed.
std::shared_ptr<const Ways> PresentWays(const Scenario& scenario) {
  std::vector<std::int32_t> closed;
  std::vector<Zone> zones;
  for (const Closure& closure : scenario.closures) {
    closed.insert(closed.end(), closure.roads.begin(), closure.roads.end());
    if (closure.zone) zones.push_back(*closure.zone);
  }
  std::sort(closed.begin(), closed.end());
  closed.erase(std::unique(closed.begin(), closed.end()), closed.end());
  std::shared_ptr<const Ways> ground = DefaultWays();
  if (scenario.roads) ground = scenario.roads->ways->Without(closed);
  if (scenario.air == nullptr) return ground;
  return scenario.air->ways->Around(std::move(ground), std::move(zones));
}

}  // namespace

bool Task::IsPlain() const {
  return reported_us == 0 && due_us == kNever && expires_us == kNever && revisit_us == kNever &&
         priority == Priority::kNormal && name.empty() && external_id.empty() && source.empty() &&
         note.empty();
}

std::int32_t Rules::DecisionAt(std::int64_t tick) const {
  const auto extra = std::lower_bound(extra_decisions.begin(), extra_decisions.end(), tick);
  const auto n_extra = static_cast<std::int32_t>(extra - extra_decisions.begin());
  if (AlwaysDecides(tick)) return static_cast<std::int32_t>(TimeOf(tick) / interval_us) + n_extra;
  if (extra == extra_decisions.end() || *extra != tick) return -1;
  return static_cast<std::int32_t>(TimeOf(tick) / interval_us) + 1 + n_extra;
}

bool Rules::MayDecide(std::int64_t tick, std::int32_t decision) const {
  if (TimeOf(tick) >= limit_us) return decision < 0;
  if (decision < 0) return !AlwaysDecides(tick);
  return decision >= (TimeOf(tick) + interval_us - 1) / interval_us && decision <= tick;
}

std::int32_t Rules::LastDecisionBefore(TimeUs t) const {
  const TimeUs end_us = std::min(t, limit_us);
  if (end_us <= 0) return -1;
  const auto n_extra = std::count_if(extra_decisions.begin(), extra_decisions.end(),
                                     [&](std::int64_t tick) { return TimeOf(tick) < end_us; });
  return static_cast<std::int32_t>(Intervals(end_us, interval_us) + n_extra) - 1;
}

TimeUs Rules::TimeOfDecision(std::int32_t decision) const {
  std::int32_t n_extra = 0;
  for (const std::int64_t tick : extra_decisions) {
    const std::int32_t extra = DecisionAt(tick);
    if (extra == decision) return TimeOf(tick);
    if (extra > decision) break;
    ++n_extra;
  }
  return (decision - n_extra) * interval_us;
}

void Rules::DecideAt(std::int64_t tick) {
  if (TimeOf(tick) >= limit_us || DecisionAt(tick) >= 0) return;
  extra_decisions.insert(std::upper_bound(extra_decisions.begin(), extra_decisions.end(), tick),
                         tick);
}

double WorthOf(const Task& task, TimeUs start_us, const Rules& rules) {
  const double worth = rules.priority_worth[static_cast<std::size_t>(task.priority)];
  return start_us <= task.due_us ? worth : worth * rules.late_worth;
}

bool Scenario::IsOpen() const {
  const Rules usual;
  return room.any() || rules.priority_worth != usual.priority_worth ||
         rules.late_worth != usual.late_worth || rules.patience_us != usual.patience_us ||
         rules.emergencies_at_once ||
         std::any_of(std::begin(kAgentKinds), std::end(kAgentKinds),
                     [this](AgentKind kind) {
                       return std::any_of(agents(kind).begin(), agents(kind).end(),
                                          std::mem_fn(&AgentSpec::measured));
                     }) ||
         !std::all_of(tasks.begin(), tasks.end(), [](const Task& task) { return task.IsPlain(); });
}

void UseRoads(ScenarioRoads roads, const std::string& file, Scenario* scenario) {
  std::vector<Point> sites;
  for (std::size_t i = 0; i < scenario->n_tasks(); ++i) sites.push_back(scenario->tasks[i].at);
  for (const ChargingPoint& point : scenario->charging_points) sites.push_back(point.at);
  RoadsKey key{roads.text, {}};
  for (const OpenGround& ground : {roads.open_ground.workers, roads.open_ground.vehicles}) {
    key.second.insert(key.second.end(), {static_cast<double>(ground.percent), ground.reach_m});
  }
  for (const Point& site : sites) key.second.insert(key.second.end(), {site.x_m, site.y_m});
  std::shared_ptr<const RoadWays> ways = SharedWays(std::move(key), [&] {
    return new RoadWays(std::make_shared<const Roads>(ParseRoads(roads.text, file)),
                        roads.open_ground, std::move(sites));
  });
  roads.network = ways->roads();
  for (const PlannedClosure& closure : roads.closures) {
    if (!RoadsIn(*roads.network, closure.area).empty()) continue;
    throw InputError(fmt::format("{}: the closure of {{{}}} meets none of its roads", file,
                                 RoadAreaToJson(closure.area)));
  }
  roads.ways = ways;
  scenario->ways = std::move(ways);
  scenario->roads = std::make_shared<const ScenarioRoads>(std::move(roads));
}

void UseAir(ScenarioAir air, Scenario* scenario) {
  air.ways = std::make_shared<const AirWaysStore>(
      air.margin_m, AirWays::Extent{scenario->width_m, scenario->height_m});
  scenario->air = std::make_shared<const ScenarioAir>(std::move(air));
  scenario->ways = PresentWays(*scenario);
}

const Ways& Scenario::WaysAt(TimeUs t) const {
  for (auto change = changed_ways.rbegin(); change != changed_ways.rend(); ++change) {
    if (change->at_us <= t) return *change->ways;
  }
  return *ways;
}

void ChangeWays(TimeUs t, Scenario* scenario) {
  auto& changes = scenario->changed_ways;
  if (changes.empty()) changes.push_back({std::numeric_limits<TimeUs>::min(), scenario->ways, {}});
  scenario->ways = PresentWays(*scenario);
  if (changes.back().at_us == t) changes.pop_back();
  changes.push_back({t, scenario->ways, scenario->closures});
}

void AddRoom(const Room& room, Scenario* scenario) {
  Task vacant;
  vacant.reported_us = kNever;
  scenario->tasks.insert(scenario->tasks.end(), room.tasks, vacant);
  // What is never online, and possible otherwise.
  AgentSpec uav, worker, vehicle;
  uav.speed_m_s = worker.speed_m_s = vehicle.speed_m_s = 1;
  uav.range_full_m = 1;
  vehicle.charge_rate_m_s = 1;
  scenario->uavs.insert(scenario->uavs.end(), room.agents.uavs, uav);
  scenario->workers.insert(scenario->workers.end(), room.agents.workers, worker);
  scenario->vehicles.insert(scenario->vehicles.end(), room.agents.vehicles, vehicle);
  scenario->had_room = scenario->had_room || room.any();
  scenario->room.tasks += room.tasks;
  for (const AgentKind kind : kAgentKinds) scenario->room.agents[kind] += room.agents[kind];
}

}  // namespace muster
