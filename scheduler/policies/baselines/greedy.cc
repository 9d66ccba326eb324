#include "scheduler/policies/baselines/greedy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "model/feasibility.h"
#include "model/generator.h"

namespace muster::scheduler {
namespace {

std::vector<Point> CellCentres(const Site& site) {
  const int columns = static_cast<int>(std::ceil(site.width_m / 1000));
  const int rows = static_cast<int>(std::ceil(site.height_m / 1000));
  std::vector<Point> cells;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      cells.push_back(CellCentre(column, row, site.width_m, site.height_m));
    }
  }
  return cells;
}

/// [n_cells] sum or least of the distances from each cell to the targets.
std::vector<double> CostOf(const std::vector<Point>& cells, const std::vector<Point>& targets,
                           GreedyPolicy::Aim aim) {
  std::vector<double> cost;
  cost.reserve(cells.size());
  for (const Point cell : cells) {
    double sum = 0;
    double least = std::numeric_limits<double>::infinity();
    for (const Point target : targets) {
      const double distance = Distance(cell, target);
      sum += distance;
      least = std::min(least, distance);
    }
    cost.push_back(aim == GreedyPolicy::Aim::kSum ? sum : least);
  }
  return cost;
}

class Stage {
 public:
  Stage(const Situation& situation, const std::vector<Point>& cells)
      : situation_(situation), cells_(cells) {}

  /// The cheapest cell that the agent can reach within the interval; none when there is none.
  std::optional<Point> Choose(const AgentState& agent, const std::vector<double>& cost) {
    const Rules& rules = situation_.site->rules;
    const TimeUs latest = LatestEnd(agent, rules);
    const double range = agent.kind == AgentKind::kUav ? situation_.range_m(agent)
                                                       : std::numeric_limits<double>::infinity();
    std::optional<std::size_t> best;
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
      const double way = Distance(agent.to, cells_[cell]);
      if (way > range) continue;
      const TimeUs travel = TravelUs(way, agent.speed_m_s);
      if (travel > rules.interval_us || situation_.now_us + travel > latest) continue;
      ++candidates_;
      if (!best || cost[cell] < cost[*best]) best = cell;
    }
    if (!best) return std::nullopt;
    return cells_[*best];
  }

  std::int64_t candidates() const { return candidates_; }

 private:
  const Situation& situation_;
  const std::vector<Point>& cells_;
  std::int64_t candidates_ = 0;
};

/// The move to `target`; staying when there is none or the agent is there already.
Action MoveOf(const AgentState& agent, std::optional<Point> target) {
  Action action;
  action.to = target.value_or(agent.to);
  const bool stays = action.to == agent.to;
  action.kind = stays ? static_cast<ActionKind>(agent.kind) : ActionKind::kGoTo;
  if (agent.kind == AgentKind::kUav) action.uav = UavId(agent.id);
  if (agent.kind == AgentKind::kWorker) action.worker = WorkerId(agent.id);
  if (agent.kind == AgentKind::kVehicle) action.vehicle = VehicleId(agent.id);
  return action;
}
static_assert(static_cast<int>(AgentKind::kUav) == static_cast<int>(ActionKind::kUavStays) &&
              static_cast<int>(AgentKind::kWorker) == static_cast<int>(ActionKind::kWorkerStays) &&
              static_cast<int>(AgentKind::kVehicle) == static_cast<int>(ActionKind::kVehicleStays));

}  // namespace

Decision GreedyPolicy::Decide(const Situation& situation) {
  const Site& site = *situation.site;
  const std::vector<Point> cells = CellCentres(site);
  std::vector<Point> open;
  for (std::size_t task = 0; task < site.tasks.size(); ++task) {
    if (situation.task_status[task] == TaskStatus::kOpen) open.push_back(site.tasks[task].at);
  }
  Stage stage(situation, cells);
  std::vector<Action> actions;
  const auto decide = [&](const std::vector<AgentState>& agents, const std::vector<Point>& targets,
                          std::vector<Point>* bound_for) {
    const std::vector<double> cost = CostOf(cells, targets, aim_);
    for (const AgentState& agent : agents) {
      std::optional<Point> target;
      if (agent.idle(situation.now_us)) {
        if (!targets.empty()) target = stage.Choose(agent, cost);
        actions.push_back(MoveOf(agent, target));
      }
      if (bound_for != nullptr && !agent.failed) bound_for->push_back(target.value_or(agent.to));
    }
  };
  std::vector<Point> bound_for;
  decide(situation.uavs, open, &bound_for);
  decide(situation.workers, open, nullptr);
  decide(situation.vehicles, bound_for, nullptr);
  return MakeDecision(std::move(actions), stage.candidates());
}

}  // namespace muster::scheduler
