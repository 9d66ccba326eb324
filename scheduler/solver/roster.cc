#include "scheduler/solver/roster.h"

#include <algorithm>

namespace muster::scheduler {
namespace {

Crew CrewOf(const Situation& situation, AgentKind kind, const Neighbourhoods* by_place) {
  Crew crew;
  crew.ways = {situation.site->ways.get(), kind};
  const auto at = [&](const AgentState* agent) { return PositionAt(*agent, situation.now_us); };
  for (const AgentState& agent : situation.agents(kind)) {
    if (agent.idle(situation.now_us)) crew.agents.push_back(&agent);
  }
  if (by_place != nullptr) by_place->Sort(&crew.agents, at);
  std::vector<double>& speeds = crew.speeds;
  for (const AgentState* agent : crew.agents) {
    crew.at.push_back(at(agent));
    speeds.push_back(agent->speed_m_s);
  }
  std::sort(speeds.begin(), speeds.end());
  speeds.erase(std::unique(speeds.begin(), speeds.end()), speeds.end());
  for (const AgentState* agent : crew.agents) {
    crew.speed_of.push_back(static_cast<std::int32_t>(
        std::lower_bound(speeds.begin(), speeds.end(), agent->speed_m_s) - speeds.begin()));
  }
  for (const double speed : speeds) crew.levels.emplace_back(speed, situation.site->rules);
  return crew;
}

}  // namespace

Roster::Roster(const Situation& situation) : neighbourhoods(*situation.site) {
  const Site& site = *situation.site;
  const Neighbourhoods* by_place = ByNeighbourhood(situation) ? &neighbourhoods : nullptr;
  uavs = CrewOf(situation, AgentKind::kUav, by_place);
  workers = CrewOf(situation, AgentKind::kWorker, by_place);
  vehicles = CrewOf(situation, AgentKind::kVehicle, by_place);
  for (const AgentState* uav : uavs.agents) range_m.push_back(situation.range_m(*uav));
  for (std::size_t x = 0; x < site.tasks.size(); ++x) {
    if (situation.task_status[x] == TaskStatus::kOpen) tasks.emplace_back(x);
  }
  for (std::size_t y = 0; y < site.charging_points.size(); ++y) {
    charge_at.push_back(site.charging_points[y].at);
    if (situation.free_places(ChargeId(y)) > 0) charges.emplace_back(y);
  }
  const auto task_place = [&](TaskId x) { return site.tasks[x.index()].at; };
  if (by_place != nullptr) {
    by_place->Sort(&tasks, task_place);
    by_place->Sort(&charges, [&](ChargeId y) { return charge_at[y.index()]; });
  }
  for (const TaskId x : tasks) task_at.push_back(task_place(x));
  site_of_charge.assign(charge_at.size(), -1);
  for (std::size_t k = 0; k < charges.size(); ++k) {
    site_of_charge[charges[k].index()] = static_cast<std::int32_t>(tasks.size() + k);
  }
}

}  // namespace muster::scheduler
