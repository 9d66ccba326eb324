#include "scheduler/policies/baselines/greedy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/index.h"
#include "model/feasibility.h"
#include "model/generator.h"
#include "model/place_index.h"
#include "scheduler/policies/baselines/distance_sums.h"

namespace muster::scheduler {
namespace {

constexpr int kLanes = 4;                  ///< cells whose costs are summed together
constexpr std::size_t kManyTargets = 500;  ///< from which on bounds of a sum take less time than it

/// The cells of an area and what they cost one agent class: the sum or least of the ways from a
/// cell's centre to the targets. In a large area only cells that an agent can reach are looked at.
class Cells {
 public:
  Cells(const Site& site, AgentKind kind, const std::vector<Point>& targets, GreedyPolicy::Aim aim)
      : site_(site),
        ways_{site.ways.get(), kind},
        targets_(targets),
        index_(targets, ways_),
        aim_(aim),
        sums_(targets, kCellM) {}

  struct Cell {
    int column, row;
    Point centre;
  };
  /// Calls visit(cell) for each cell whose centre may be within `radius_m` of `middle`, row by row.
  template <class Visit>
  void Around(Point middle, double radius_m, Visit&& visit) const {
    const Range rows = RangeOf(middle.y_m, radius_m, rows_);
    const Range columns = RangeOf(middle.x_m, radius_m, columns_);
    for (int row = rows.first; row <= rows.last; ++row) {
      for (int column = columns.first; column <= columns.last; ++column) {
        visit(Cell{column, row, Centre(column, row)});
      }
    }
  }

  double CostOf(const Cell& cell) {
    const auto known = costs_.find(NumberOf(cell));
    if (known != costs_.end()) return known->second;
    if (IsStraightSum()) {
      // Others will be asked for the cells beside it.
      std::vector<Cell> beside;
      const int first = cell.column / kLanes * kLanes;
      for (int column = first; column < std::min(first + kLanes, columns_); ++column) {
        beside.push_back({column, cell.row, Centre(column, cell.row)});
      }
      AddSums(beside);
      return costs_.at(NumberOf(cell));
    }
    return costs_[NumberOf(cell)] = Cost(cell.centre);
  }
  /// CostOf will be asked for these.
  void Prepare(std::vector<Cell> cells) {
    if (!IsStraightSum()) return;
    std::erase_if(cells, [&](const Cell& cell) { return costs_.contains(NumberOf(cell)); });
    for (std::size_t i = 0; i < cells.size(); i += kLanes) {
      AddSums(std::span(cells).subspan(i, std::min<std::size_t>(kLanes, cells.size() - i)));
    }
  }

  bool straight() const { return ways_.straight(); }
  /// What the cost lies between, where that takes less time; else the cost, twice.
  DistanceSums::Bounds BoundsOf(const Cell& cell) {
    // Cells that the area's edge cuts have their centre elsewhere.
    const bool is_whole = cell.centre.x_m == (cell.column + 0.5) * kCellM &&
                          cell.centre.y_m == (cell.row + 0.5) * kCellM;
    if (IsStraightSum() && targets_.size() >= kManyTargets && is_whole) {
      return sums_.BoundsOf(cell.column, cell.row);
    }
    const double cost = CostOf(cell);
    return {cost, cost};
  }

 private:
  struct Range {
    int first, last;
  };
  bool IsStraightSum() const { return aim_ == GreedyPolicy::Aim::kSum && ways_.straight(); }
  std::int64_t NumberOf(const Cell& cell) const {
    return std::int64_t{cell.row} * columns_ + cell.column;
  }
  static int Count(double length_m) { return static_cast<int>(std::ceil(length_m / kCellM)); }
  static Range RangeOf(double middle_m, double radius_m, int count) {
    const auto cell = [count](double at_m) {
      return static_cast<int>(std::clamp(std::floor(at_m / kCellM), 0.0, count - 1.0));
    };
    return {cell(middle_m - radius_m), cell(middle_m + radius_m)};
  }

  /// The sums of up to kLanes cells: several square roots at a time. Each is the sum that Cost
  /// gives.
  void AddSums(std::span<const Cell> cells) {
    std::array<double, kLanes> x{}, y{}, sum{};
    for (std::size_t lane = 0; lane < cells.size(); ++lane) {
      x[lane] = cells[lane].centre.x_m;
      y[lane] = cells[lane].centre.y_m;
    }
    for (const Point target : targets_) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const double dx = x[lane] - target.x_m, dy = y[lane] - target.y_m;
        sum[lane] += std::sqrt(dx * dx + dy * dy);
      }
    }
    for (std::size_t lane = 0; lane < cells.size(); ++lane) {
      costs_[NumberOf(cells[lane])] = sum[lane];
    }
  }
  Point Centre(int column, int row) const {
    return CellCentre(column, row, site_.width_m, site_.height_m);
  }

  double Cost(Point centre) const {
    if (aim_ == GreedyPolicy::Aim::kNearest) return index_.NearestFrom(centre);
    double sum = 0;
    for (const Point target : targets_) sum += ways_.Length(centre, target);
    return sum;
  }

  const Site& site_;
  WaysOf ways_;
  const std::vector<Point>& targets_;
  PlaceIndex index_;
  GreedyPolicy::Aim aim_;
  int columns_ = Count(site_.width_m), rows_ = Count(site_.height_m);
  std::unordered_map<std::int64_t, double> costs_;
  DistanceSums sums_;
};

class Stage {
 public:
  explicit Stage(const Situation& situation) : situation_(situation) {}

  /// The cheapest cell that the agent can reach within the interval; none when there is none.
  std::optional<Point> Choose(const AgentState& agent, Cells* cells) {
    const Rules& rules = situation_.site->rules;
    const TimeUs most_us = std::min(rules.interval_us, LatestEnd(agent, rules) - situation_.now_us);
    const double range = agent.kind == AgentKind::kUav ? situation_.range_m(agent)
                                                       : std::numeric_limits<double>::infinity();
    constexpr double kRounding_m = 1;
    const double reach = std::min(range, agent.speed_m_s * ToSeconds(most_us)) + kRounding_m;
    // The cells that may be the cheapest; only where there are several their costs are compared.
    close_.clear();
    double most = std::numeric_limits<double>::infinity();
    cells->Around(agent.to, reach, [&](const Cells::Cell& cell) {
      const double way = agent.WayM(agent.to, cell.centre);
      if (way > range || TravelUs(way, agent.speed_m_s) > most_us) return;
      ++candidates_;
      const DistanceSums::Bounds cost = cells->BoundsOf(cell);
      if (cost.least > most) return;
      most = std::min(most, cost.most);
      close_.push_back({cell, cost.least});
    });
    std::erase_if(close_, [&](const Close& cell) { return cell.least > most; });
    if (close_.empty()) return {};
    if (close_.size() == 1) return close_.front().cell.centre;
    std::vector<Cells::Cell> asked;
    for (const Close& close : close_) asked.push_back(close.cell);
    cells->Prepare(std::move(asked));
    std::size_t best = 0;
    for (std::size_t i = 1; i < close_.size(); ++i) {
      if (cells->CostOf(close_[i].cell) < cells->CostOf(close_[best].cell)) best = i;
    }
    return close_[best].cell.centre;
  }

  std::int64_t candidates() const { return candidates_; }

 private:
  struct Close {
    Cells::Cell cell;
    double least;
  };

  const Situation& situation_;
  std::int64_t candidates_ = 0;
  std::vector<Close> close_;
};

/// The move to `target`; staying when there is none or the agent is there already.
Action MoveOf(const Site& site, const AgentState& agent, std::optional<Point> target) {
  Action action = MakeStay(site, agent);
  if (target && *target != agent.to) {
    action.kind = ActionKind::kGoTo;
    action.to = *target;
  }
  return action;
}

}  // namespace

Decision GreedyPolicy::Decide(const Situation& situation) {
  const Site& site = *situation.site;
  std::vector<Point> open;
  for (std::size_t task = 0; task < site.tasks.size(); ++task) {
    if (situation.task_status[task] == TaskStatus::kOpen) open.push_back(site.tasks[task].at);
  }
  Stage stage(situation);
  std::vector<Action> actions;
  const auto decide = [&](AgentKind kind, bool any, Cells* cells, std::vector<Point>* bound_for) {
    for (const AgentState& agent : situation.agents(kind)) {
      std::optional<Point> target;
      if (agent.idle(situation.now_us)) {
        if (any) target = stage.Choose(agent, cells);
        actions.push_back(MoveOf(site, agent, target));
      }
      if (bound_for != nullptr && !agent.failed) bound_for->push_back(target.value_or(agent.to));
    }
  };
  std::vector<Point> bound_for;
  Cells of_uavs(site, AgentKind::kUav, open, aim_);
  decide(AgentKind::kUav, !open.empty(), &of_uavs, &bound_for);
  if (of_uavs.straight() && WaysOf{site.ways.get(), AgentKind::kWorker}.straight()) {
    decide(AgentKind::kWorker, !open.empty(), &of_uavs, nullptr);
  } else {
    Cells of_workers(site, AgentKind::kWorker, open, aim_);
    decide(AgentKind::kWorker, !open.empty(), &of_workers, nullptr);
  }
  Cells of_vehicles(site, AgentKind::kVehicle, bound_for, aim_);
  decide(AgentKind::kVehicle, !bound_for.empty(), &of_vehicles, nullptr);
  return MakeDecision(std::move(actions), stage.candidates());
}

}  // namespace muster::scheduler
