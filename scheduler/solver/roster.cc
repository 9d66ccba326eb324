#include "scheduler/solver/roster.h"

#include <algorithm>
#include <utility>

namespace muster::scheduler {
namespace {

/// With so many agents and tasks, neighbours get neighbouring numbers.
constexpr std::size_t kNeighboursFirst = 4096;

/// Number of a cell along the Z-order curve.
std::uint32_t ZOrder(double x, double y) {
  const auto spread = [](double v) {
    auto z = static_cast<std::uint32_t>(std::clamp(v, 0.0, 65535.0));
    z = (z | z << 8) & 0x00FF00FFu;
    z = (z | z << 4) & 0x0F0F0F0Fu;
    z = (z | z << 2) & 0x33333333u;
    return (z | z << 1) & 0x55555555u;
  };
  return spread(x) | spread(y) << 1;
}

template <class Element, class At>
void SortByNeighbourhood(const Roster& roster, const At& at, std::vector<Element>* elements) {
  std::vector<std::pair<std::uint32_t, Element>> keyed;
  for (const Element& element : *elements) {
    keyed.emplace_back(roster.Neighbourhood(at(element)), element);
  }
  std::stable_sort(keyed.begin(), keyed.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < keyed.size(); ++i) (*elements)[i] = keyed[i].second;
}

Crew CrewOf(const Situation& situation, AgentKind kind, const Roster& roster, bool by_place) {
  Crew crew;
  crew.ways = {situation.site->ways.get(), kind};
  const auto at = [&](const AgentState* agent) { return PositionAt(*agent, situation.now_us); };
  for (const AgentState& agent : situation.agents(kind)) {
    if (agent.idle(situation.now_us)) crew.agents.push_back(&agent);
  }
  if (by_place) SortByNeighbourhood(roster, at, &crew.agents);
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

Roster::Roster(const Situation& situation)
    : cell_m_(std::max(std::max(situation.site->width_m, situation.site->height_m) / 65535, 1e-3)) {
  const Site& site = *situation.site;
  const bool by_place = situation.uavs.size() + situation.workers.size() +
                            situation.vehicles.size() + site.tasks.size() >
                        kNeighboursFirst;
  uavs = CrewOf(situation, AgentKind::kUav, *this, by_place);
  workers = CrewOf(situation, AgentKind::kWorker, *this, by_place);
  vehicles = CrewOf(situation, AgentKind::kVehicle, *this, by_place);
  for (const AgentState* uav : uavs.agents) range_m.push_back(situation.range_m(*uav));
  for (std::size_t x = 0; x < site.tasks.size(); ++x) {
    if (situation.task_status[x] == TaskStatus::kOpen) tasks.emplace_back(x);
  }
  for (std::size_t y = 0; y < site.charging_points.size(); ++y) {
    charge_at.push_back(site.charging_points[y].at);
    if (situation.free_places(ChargeId(y)) > 0) charges.emplace_back(y);
  }
  const auto task_place = [&](TaskId x) { return site.tasks[x.index()].at; };
  if (by_place) {
    SortByNeighbourhood(*this, task_place, &tasks);
    SortByNeighbourhood(
        *this, [&](ChargeId y) { return charge_at[y.index()]; }, &charges);
  }
  for (const TaskId x : tasks) task_at.push_back(task_place(x));
  site_of_charge.assign(charge_at.size(), -1);
  for (std::size_t k = 0; k < charges.size(); ++k) {
    site_of_charge[charges[k].index()] = static_cast<std::int32_t>(tasks.size() + k);
  }
}

std::uint32_t Roster::Neighbourhood(Point place) const {
  return ZOrder(place.x_m / cell_m_, place.y_m / cell_m_);
}

}  // namespace muster::scheduler
