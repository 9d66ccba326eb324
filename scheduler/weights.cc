#include "scheduler/weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "base/check.h"
#include "model/feasibility.h"

namespace muster::scheduler {
namespace {

constexpr double kLeastLikelihood = 1e-6;
constexpr double kLongest_us = 0x1.0p52;

/// e^-k for k = 0, 1, ...; beyond the table e^-k is below the smallest double.
double ExpOfMinus(double k) {
  static const auto table = [] {
    std::array<double, 746> values;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::exp(-static_cast<double>(i));
    return values;
  }();
  return k < static_cast<double>(table.size()) ? table[static_cast<std::size_t>(k)] : 0.0;
}

/// The unit in which Eq. 4-5 to 4-19 count time.
TimeUs CountUnit(const Rules& rules) {
  return rules.ceil_to_minutes ? kMinuteUs : rules.interval_us;
}

std::vector<std::int32_t> IdlePositions(const std::vector<AgentState>& agents, TimeUs now) {
  std::vector<std::int32_t> positions;
  for (std::size_t i = 0; i < agents.size(); ++i) {
    if (agents[i].idle(now)) positions.push_back(static_cast<std::int32_t>(i));
  }
  return positions;
}

std::vector<const AgentState*> Select(const std::vector<AgentState>& agents,
                                      const std::vector<std::int32_t>& positions) {
  std::vector<const AgentState*> selected;
  for (const std::int32_t i : positions) {
    selected.push_back(&agents[static_cast<std::size_t>(i)]);
  }
  return selected;
}

using Agents = std::vector<const AgentState*>;

/// Places with the ways to them, which are found all at once where they are straight.
struct SiteArray {
  explicit SiteArray(const std::vector<Point>& places)
      : points(places), x(static_cast<Eigen::Index>(points.size())), y(x.size()) {
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      x(i) = points[static_cast<std::size_t>(i)].x_m;
      y(i) = points[static_cast<std::size_t>(i)].y_m;
    }
  }
  /// Metres from p to each place.
  Eigen::ArrayXd WaysFrom(Point p, const WaysOf& ways) const {
    // The same operations as Distance(): equal to the last bit.
    if (ways.straight()) return ((x - p.x_m).square() + (y - p.y_m).square()).sqrt();
    Eigen::ArrayXd way_m(x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      way_m(i) = ways.Length(p, points[static_cast<std::size_t>(i)]);
    }
    return way_m;
  }
  const std::vector<Point>& points;
  Eigen::ArrayXd x, y;
};

Legs LegsOf(const Agents& agents, const std::vector<Point>& sites, TimeUs unit_us) {
  const SiteArray array(sites);
  const auto rows = static_cast<Eigen::Index>(agents.size());
  const auto columns = static_cast<Eigen::Index>(sites.size());
  Legs legs{Table<double>(rows, columns), Table<TimeUs>(rows, columns),
            Table<std::int32_t>(rows, columns)};
  for (Eigen::Index a = 0; a < rows; ++a) {
    const AgentState& agent = *agents[static_cast<std::size_t>(a)];
    const Eigen::ArrayXd way = array.WaysFrom(agent.to, agent.own_ways());
    const Eigen::ArrayXd counts = IntervalCounts(way, agent.speed_m_s, unit_us);
    legs.way_m.row(a) = way.transpose();
    legs.intervals.row(a) =
        counts.min(static_cast<double>(std::numeric_limits<std::int32_t>::max()))
            .cast<std::int32_t>()
            .transpose();
    for (Eigen::Index s = 0; s < columns; ++s) {
      legs.travel_us(a, s) = TravelUs(way(s), agent.speed_m_s);
    }
  }
  return legs;
}

/// Expected costs at the agents' own places and, for each agent's speed, at places to go to.
struct CostsAt {
  std::vector<double> here;  ///< [n_agents]
  Table<double> there;       ///< [n_agents x n_places]
};

CostsAt ExpectedCostsOf(const Agents& agents, const std::vector<Point>& places,
                        const std::vector<Point>& sites, const Eigen::ArrayXd& cost,
                        TimeUs unit_us) {
  std::vector<double> speeds;
  for (const AgentState* agent : agents) speeds.push_back(agent->speed_m_s);
  std::sort(speeds.begin(), speeds.end());
  speeds.erase(std::unique(speeds.begin(), speeds.end()), speeds.end());

  std::vector<Probe> probes;
  probes.reserve(agents.size() + speeds.size() * places.size());
  for (const AgentState* agent : agents) probes.push_back({agent->to, agent->speed_m_s});
  for (const double speed : speeds) {
    for (const Point place : places) probes.push_back({place, speed});
  }
  const WaysOf ways = agents.empty() ? WaysOf{} : agents.front()->own_ways();
  const std::vector<double> costs = ExpectedCosts(probes, sites, cost, unit_us, ways);

  CostsAt result;
  result.here.assign(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(agents.size()));
  result.there.resize(static_cast<Eigen::Index>(agents.size()),
                      static_cast<Eigen::Index>(places.size()));
  for (std::size_t a = 0; a < agents.size(); ++a) {
    const auto speed = static_cast<std::size_t>(
        std::lower_bound(speeds.begin(), speeds.end(), agents[a]->speed_m_s) - speeds.begin());
    const double* row = costs.data() + agents.size() + speed * places.size();
    std::copy(row, row + places.size(), result.there.row(static_cast<Eigen::Index>(a)).data());
  }
  return result;
}

/// MoveBenefit for every agent and place.
Table<double> Benefits(const CostsAt& costs, const Table<std::int32_t>& intervals,
                       Eigen::Index first_place) {
  Table<double> benefits(intervals.rows(), intervals.cols());
  for (Eigen::Index a = 0; a < intervals.rows(); ++a) {
    for (Eigen::Index s = 0; s < intervals.cols(); ++s) {
      benefits(a, s) = MoveBenefit(costs.here[static_cast<std::size_t>(a)],
                                   costs.there(a, first_place + s), intervals(a, s));
    }
  }
  return benefits;
}

}  // namespace

double Softplus(double x) { return std::max(x, 0.0) + std::log1p(std::exp(-std::abs(x))); }

Eigen::ArrayXd IntervalCounts(const Eigen::ArrayXd& way_m, double speed_m_s, TimeUs unit_us) {
  // floor(x + 0.5) is llround(x) for 0 <= x < 2^52 but for the largest double below 0.5, which
  // counts 1 either way. A quotient of whole numbers below 2^52 is never rounded to or across the
  // whole number below it, so its ceil is exact.
  const Eigen::ArrayXd us = ((way_m / speed_m_s) * 1e6).unaryExpr([](double x) {
    return std::floor(std::min(x, kLongest_us) + 0.5);
  });
  return (us / static_cast<double>(unit_us)).ceil().max(1.0);
}

double TaskLikelihood(double range_share) {
  return std::max(kLeastLikelihood, (1 - std::exp(-range_share)) / (1 - std::exp(-1.0)));
}

double ChargeLikelihood(double range_share) { return TaskLikelihood(1.0 - range_share); }

Eigen::ArrayXd UavMatchCost(const Table<std::int32_t>& intervals, const Eigen::ArrayXd& likelihood,
                            const Table<bool>& feasible, double if_none, bool mean_over_all) {
  MUSTER_CHECK(intervals.rows() == likelihood.size() && intervals.rows() == feasible.rows() &&
               intervals.cols() == feasible.cols());
  Eigen::ArrayXd cost = Eigen::ArrayXd::Zero(intervals.cols());
  if (intervals.rows() == 0) return cost;
  Eigen::ArrayXd count = Eigen::ArrayXd::Zero(intervals.cols());
  for (Eigen::Index u = 0; u < intervals.rows(); ++u) {
    const Eigen::ArrayXd mask = feasible.row(u).cast<double>().transpose();
    cost += mask * intervals.row(u).cast<double>().transpose() / likelihood(u);
    count += mask;
  }
  if (mean_over_all) return cost / static_cast<double>(intervals.rows());
  return (count > 0).select(cost / count.max(1.0), if_none);
}

Eigen::ArrayXd PartnerMatchCost(const Table<std::int32_t>& intervals) {
  if (intervals.rows() == 0) return Eigen::ArrayXd::Zero(intervals.cols());
  return intervals.cast<double>().colwise().mean().transpose();
}

Eigen::ArrayXd ChoiceProbabilities(const Eigen::ArrayXd& intervals) {
  if (intervals.size() == 0) return intervals;
  const double nearest = intervals.minCoeff();
  const Eigen::ArrayXd e = (intervals - nearest).unaryExpr(&ExpOfMinus);
  return e / e.sum();
}

double MoveBenefit(double before, double after, std::int32_t intervals) {
  const double gain = before == 0 && after == 0 ? 0.0 : (before - after) / before;
  return Softplus(gain) / intervals;
}

double UavBenefit(double range_after_m, double range_full_m, double task_benefit,
                  double charge_benefit) {
  if (range_full_m <= 0) return charge_benefit;
  return range_after_m / range_full_m * task_benefit +
         (range_full_m - range_after_m) / range_full_m * charge_benefit;
}

double SenseFoundation(Foundation foundation) {
  return Softplus(foundation == Foundation::kHierarchical ? 100.0 : 1.0);
}

double ChargeFoundation(Foundation foundation, double range_share) {
  return foundation == Foundation::kHierarchical ? Softplus(10.0 + std::exp(1.0 - range_share))
                                                 : Softplus(std::exp(-range_share));
}

double PairWeight(double foundation, std::int32_t uav_intervals, std::int32_t partner_intervals,
                  double uav_benefit, double partner_benefit) {
  return foundation / std::max(uav_intervals, partner_intervals) + partner_benefit + uav_benefit;
}

std::vector<double> ExpectedCosts(const std::vector<Probe>& probes, const std::vector<Point>& sites,
                                  const Eigen::ArrayXd& cost, TimeUs unit_us, const WaysOf& ways) {
  std::vector<double> costs(probes.size(), 0.0);
  if (sites.empty()) return costs;
  const auto key = [&probes](std::size_t i) {
    return std::tuple(probes[i].speed_m_s, probes[i].at.x_m, probes[i].at.y_m);
  };
  std::vector<std::size_t> order(probes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&key](std::size_t a, std::size_t b) { return key(a) < key(b); });
  const SiteArray array(sites);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t i = order[k];
    if (k > 0 && key(order[k - 1]) == key(i)) {
      costs[i] = costs[order[k - 1]];
      continue;
    }
    const Eigen::ArrayXd counts =
        IntervalCounts(array.WaysFrom(probes[i].at, ways), probes[i].speed_m_s, unit_us);
    costs[i] = (ChoiceProbabilities(counts) * cost).sum();
  }
  return costs;
}

namespace {

/// Of the idle UAVs, [n_uavs].
struct UavRanges {
  Eigen::ArrayXd full_m, task_likelihood, charge_likelihood;
};

/// Nobody gets to a task that is gone by then: such a way takes for ever.
void KeepToExpiry(const Situation& situation, const std::vector<TaskId>& tasks, Legs* legs) {
  for (std::size_t x = 0; x < tasks.size(); ++x) {
    const Task& task = situation.site->tasks[tasks[x].index()];
    if (task.expires_us == kNever) continue;
    for (TimeUs& travel_us : legs->travel_us.col(static_cast<Eigen::Index>(x))) {
      if (!CanBegin(task, situation.now_us, travel_us)) travel_us = kNever;
    }
  }
}

/// What the UAVs' ranges allow and make likely (Eq. 4-1, 4-4, 4-19); fills range_m,
/// charge_foundation, senseable and chargeable of `w`, whose ways are known.
UavRanges LookAtRanges(const Situation& situation, const Agents& uavs, Foundation foundation,
                       Weights* w) {
  const Site& site = *situation.site;
  const auto n_uavs = static_cast<Eigen::Index>(uavs.size());
  const Eigen::Index n_tasks = w->uav_task.way_m.cols(), n_charges = w->uav_charge.way_m.cols();
  w->range_m.resize(n_uavs);
  w->charge_foundation.resize(n_uavs);
  w->senseable.resize(n_uavs, n_tasks);
  w->chargeable.resize(n_uavs, n_charges);
  UavRanges ranges{Eigen::ArrayXd(n_uavs), Eigen::ArrayXd(n_uavs), Eigen::ArrayXd(n_uavs)};
  for (Eigen::Index u = 0; u < n_uavs; ++u) {
    const AgentState& uav = *uavs[static_cast<std::size_t>(u)];
    w->range_m(u) = situation.range_m(uav);
    ranges.full_m(u) = uav.range_full_m;
    const double share = w->range_m(u) / ranges.full_m(u);
    ranges.task_likelihood(u) = TaskLikelihood(share);
    ranges.charge_likelihood(u) = ChargeLikelihood(share);
    w->charge_foundation(u) = ChargeFoundation(foundation, share);
    for (Eigen::Index x = 0; x < n_tasks; ++x) {
      const std::size_t task = w->tasks[static_cast<std::size_t>(x)].index();
      w->senseable(u, x) = CanSense(w->range_m(u), w->uav_task.way_m(u, x), site.tasks[task].cost_m,
                                    site.task_to_charge_m[task]);
    }
    for (Eigen::Index y = 0; y < n_charges; ++y) {
      w->chargeable(u, y) = CanReachCharge(w->range_m(u), w->uav_charge.way_m(u, y));
    }
  }
  return ranges;
}

/// Benefits of what UAVs can do, from their expected costs at the tasks and then the charging
/// points; fills uav_to_task, uav_senses, uav_to_charge and uav_charges of `w`.
void WeighUavs(const Site& site, const Eigen::ArrayXd& full_m, const CostsAt& as_to_tasks,
               const CostsAt& as_to_charging, Weights* w) {
  const Eigen::Index n_uavs = full_m.size();
  const Eigen::Index n_tasks = w->uav_task.way_m.cols(), n_charges = w->uav_charge.way_m.cols();
  const Table<double> task_part_at_task = Benefits(as_to_tasks, w->uav_task.intervals, 0);
  const Table<double> charge_part_at_task = Benefits(as_to_charging, w->uav_task.intervals, 0);
  const Table<double> task_part_at_charge = Benefits(as_to_tasks, w->uav_charge.intervals, n_tasks);
  const Table<double> charge_part_at_charge =
      Benefits(as_to_charging, w->uav_charge.intervals, n_tasks);
  w->uav_to_task.resize(n_uavs, n_tasks);
  w->uav_senses.resize(n_uavs, n_tasks);
  w->uav_to_charge.resize(n_uavs, n_charges);
  w->uav_charges.resize(n_uavs, n_charges);
  for (Eigen::Index u = 0; u < n_uavs; ++u) {
    for (Eigen::Index x = 0; x < n_tasks; ++x) {
      const double cost_m = site.tasks[w->tasks[static_cast<std::size_t>(x)].index()].cost_m;
      const double on_arrival_m = w->range_m(u) - w->uav_task.way_m(u, x);
      const double task_part = task_part_at_task(u, x), charge_part = charge_part_at_task(u, x);
      w->uav_to_task(u, x) = UavBenefit(on_arrival_m, full_m(u), task_part, charge_part);
      w->uav_senses(u, x) = UavBenefit(on_arrival_m - cost_m, full_m(u), task_part, charge_part);
    }
    for (Eigen::Index y = 0; y < n_charges; ++y) {
      const double on_arrival_m = w->range_m(u) - w->uav_charge.way_m(u, y);
      const double task_part = task_part_at_charge(u, y), charge_part = charge_part_at_charge(u, y);
      w->uav_to_charge(u, y) = UavBenefit(on_arrival_m, full_m(u), task_part, charge_part);
      w->uav_charges(u, y) = UavBenefit(full_m(u), full_m(u), task_part, charge_part);
    }
  }
}

}  // namespace

Weights ComputeWeights(const Situation& situation, Foundation foundation) {
  const Site& site = *situation.site;
  const Rules& rules = site.rules;
  const TimeUs unit_us = CountUnit(rules);
  Weights w;
  w.uavs = IdlePositions(situation.uavs, situation.now_us);
  w.workers = IdlePositions(situation.workers, situation.now_us);
  w.vehicles = IdlePositions(situation.vehicles, situation.now_us);
  const Agents uavs = Select(situation.uavs, w.uavs);
  const Agents workers = Select(situation.workers, w.workers);
  const Agents vehicles = Select(situation.vehicles, w.vehicles);

  std::vector<Point> task_points, charge_points;
  for (std::size_t x = 0; x < site.tasks.size(); ++x) {
    if (situation.task_status[x] != TaskStatus::kOpen) continue;
    w.tasks.emplace_back(x);
    task_points.push_back(site.tasks[x].at);
  }
  for (const ChargingPoint& point : site.charging_points) charge_points.push_back(point.at);

  w.uav_task = LegsOf(uavs, task_points, unit_us);
  w.worker_task = LegsOf(workers, task_points, unit_us);
  KeepToExpiry(situation, w.tasks, &w.uav_task);
  KeepToExpiry(situation, w.tasks, &w.worker_task);
  w.uav_charge = LegsOf(uavs, charge_points, unit_us);
  w.vehicle_charge = LegsOf(vehicles, charge_points, unit_us);

  const UavRanges ranges = LookAtRanges(situation, uavs, foundation, &w);
  const double if_none = static_cast<double>(rules.limit_us) / static_cast<double>(unit_us);
  const Eigen::ArrayXd task_by_uav = UavMatchCost(w.uav_task.intervals, ranges.task_likelihood,
                                                  w.senseable, if_none, rules.mean_over_all);
  const Eigen::ArrayXd charge_by_uav = UavMatchCost(
      w.uav_charge.intervals, ranges.charge_likelihood, w.chargeable, if_none, rules.mean_over_all);
  const Eigen::ArrayXd task_by_worker = PartnerMatchCost(w.worker_task.intervals);
  const Eigen::ArrayXd charge_by_vehicle = PartnerMatchCost(w.vehicle_charge.intervals);

  w.worker_to_task =
      Benefits(ExpectedCostsOf(workers, task_points, task_points, task_by_uav, unit_us),
               w.worker_task.intervals, 0);
  w.vehicle_to_charge =
      Benefits(ExpectedCostsOf(vehicles, charge_points, charge_points, charge_by_uav, unit_us),
               w.vehicle_charge.intervals, 0);

  // A UAV may go to a task or to a charging point; both moves change both of its expected costs.
  std::vector<Point> places = task_points;
  places.insert(places.end(), charge_points.begin(), charge_points.end());
  const CostsAt as_to_tasks = ExpectedCostsOf(uavs, places, task_points, task_by_worker, unit_us);
  const CostsAt as_to_charging =
      ExpectedCostsOf(uavs, places, charge_points, charge_by_vehicle, unit_us);
  w.stay = Softplus(0);
  w.sense_foundation = SenseFoundation(foundation);
  WeighUavs(site, ranges.full_m, as_to_tasks, as_to_charging, &w);
  return w;
}

}  // namespace muster::scheduler
