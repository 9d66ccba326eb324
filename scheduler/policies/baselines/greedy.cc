#include "scheduler/policies/baselines/greedy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/index.h"
#include "model/feasibility.h"
#include "model/generator.h"
#include "model/place_index.h"

namespace muster::scheduler {
namespace {

constexpr int kLanes = 8;  ///< cells beside each other whose costs are summed together

/// The cells of an area and what they cost one agent class: the sum or least of the ways from a
/// cell's centre to the targets. In a large area only cells that an agent can reach are looked at.
class Cells {
 public:
  Cells(const Site& site, AgentKind kind, const std::vector<Point>& targets, GreedyPolicy::Aim aim)
      : site_(site),
        ways_{site.ways.get(), kind},
        targets_(targets),
        index_(targets, ways_),
        aim_(aim) {}

  /// Calls visit(cell, centre) for each cell whose centre may be within `radius_m` of `middle`, row
  /// by row.
  template <class Visit>
  void Around(Point middle, double radius_m, Visit&& visit) const {
    const Range rows = RangeOf(middle.y_m, radius_m, rows_);
    const Range columns = RangeOf(middle.x_m, radius_m, columns_);
    for (int row = rows.first; row <= rows.last; ++row) {
      for (int column = columns.first; column <= columns.last; ++column) {
        visit(std::int64_t{row} * columns_ + column, Centre(column, row));
      }
    }
  }

  double CostOf(std::int64_t cell, Point centre) {
    const auto known = costs_.find(cell);
    if (known != costs_.end()) return known->second;
    if (aim_ == GreedyPolicy::Aim::kSum && ways_.straight()) {
      AddSums(cell);
      return costs_.at(cell);
    }
    return costs_[cell] = Cost(centre);
  }

 private:
  struct Range {
    int first, last;
  };
  static int Count(double length_m) { return static_cast<int>(std::ceil(length_m / kCellM)); }
  static Range RangeOf(double middle_m, double radius_m, int count) {
    const auto cell = [count](double at_m) {
      return static_cast<int>(std::clamp(std::floor(at_m / kCellM), 0.0, count - 1.0));
    };
    return {cell(middle_m - radius_m), cell(middle_m + radius_m)};
  }

  /// The sums of the cell and of those beside it, of which others will be asked for: several square
  /// roots at a time. Each is the sum that Cost gives.
  void AddSums(std::int64_t cell) {
    const auto row = static_cast<int>(cell / columns_);
    const int first = static_cast<int>(cell % columns_) / kLanes * kLanes;
    std::array<double, kLanes> x, sum{};
    for (int lane = 0; lane < kLanes; ++lane) x[At(lane)] = Centre(first + lane, row).x_m;
    const double y = Centre(first, row).y_m;
    for (const Point target : targets_) {
      const double dy = y - target.y_m;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const double dx = x[lane] - target.x_m;
        sum[lane] += std::sqrt(dx * dx + dy * dy);
      }
    }
    for (int lane = 0; lane < kLanes && first + lane < columns_; ++lane) {
      costs_[std::int64_t{row} * columns_ + first + lane] = sum[At(lane)];
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
    std::optional<Point> best;
    double least = 0;
    cells->Around(agent.to, reach, [&](std::int64_t cell, Point centre) {
      const double way = agent.WayM(agent.to, centre);
      if (way > range || TravelUs(way, agent.speed_m_s) > most_us) return;
      ++candidates_;
      const double cost = cells->CostOf(cell, centre);
      if (best && cost >= least) return;
      best = centre;
      least = cost;
    });
    return best;
  }

  std::int64_t candidates() const { return candidates_; }

 private:
  const Situation& situation_;
  std::int64_t candidates_ = 0;
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
  const auto decide = [&](AgentKind kind, const std::vector<Point>& targets,
                          std::vector<Point>* bound_for) {
    Cells cells(site, kind, targets, aim_);
    for (const AgentState& agent : situation.agents(kind)) {
      std::optional<Point> target;
      if (agent.idle(situation.now_us)) {
        if (!targets.empty()) target = stage.Choose(agent, &cells);
        actions.push_back(MoveOf(site, agent, target));
      }
      if (bound_for != nullptr && !agent.failed) bound_for->push_back(target.value_or(agent.to));
    }
  };
  std::vector<Point> bound_for;
  decide(AgentKind::kUav, open, &bound_for);
  decide(AgentKind::kWorker, open, nullptr);
  decide(AgentKind::kVehicle, bound_for, nullptr);
  return MakeDecision(std::move(actions), stage.candidates());
}

}  // namespace muster::scheduler
