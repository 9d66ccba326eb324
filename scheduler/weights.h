#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "base/ids.h"
#include "scheduler/situation.h"

namespace muster::scheduler {

/// Weights of the conflict graph's nodes: Eq. 4-1 to 4-19 of the paper, as
/// docs/reference/scheduling.md reads them. All times in these equations are counts of decision
/// intervals (of minutes with Rules::ceil_to_minutes), at least 1.

template <class T>
using Table = Eigen::Array<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Which foundational weights the pairs get: 100 and 10 (section 4.1.2), or the uniform ones of
/// section 5.3.3.
enum class Foundation { kHierarchical, kUniform };

/// ln(1 + e^x), finite for every finite x. Source: Eq. 4-10.
double Softplus(double x);

/// The paper's ceil(x, Interval) on travel times: max(1, ceil_div(round_us(way / speed), unit_us))
/// for each way in metres. Exact below 2^52 us; farther ways count as 2^52 us.
/// Source: Eq. 4-5 to 4-19; staying counts 1.
Eigen::ArrayXd IntervalCounts(const Eigen::ArrayXd& way_m, double speed_m_s, TimeUs unit_us);

/// E_tL = (1 - e^-s) / (1 - e^-1), at least 1e-6, for the share s = range / full range in [0, 1]:
/// how likely a UAV takes a task. Source: Eq. 4-1 (4-2 and 4-3: increasing and concave).
double TaskLikelihood(double range_share);

/// E_chL = TaskLikelihood(1 - s): how much a UAV needs charging. Source: Eq. 4-4.
double ChargeLikelihood(double range_share);

/// Du_tL (Du_chL): expected cost, in intervals, for each site to be matched by a UAV.
/// intervals [n_uavs x n_sites]; likelihood [n_uavs], positive; feasible [n_uavs x n_sites].
/// Returns [n_sites]: the mean of intervals / likelihood over the feasible UAVs, `if_none` where
/// there is none. With mean_over_all the sum is divided by n_uavs as printed. No UAVs at all: 0.
/// Source: Eq. 4-5, 4-7.
Eigen::ArrayXd UavMatchCost(const Table<std::int32_t>& intervals, const Eigen::ArrayXd& likelihood,
                            const Table<bool>& feasible, double if_none, bool mean_over_all);

/// Dw_tL (Dv_chL): expected cost, in intervals, for each site to be matched by a worker (vehicle).
/// intervals [n_partners x n_sites]; returns [n_sites]: the mean; no partners: 0.
/// Source: Eq. 4-6, 4-8.
Eigen::ArrayXd PartnerMatchCost(const Table<std::int32_t>& intervals);

/// Probabilities with which an agent chooses among sites that are `intervals` [n_sites] away:
/// softmax(-intervals). The counts are whole numbers >= 1. Source: Eq. 4-9, 4-11, 4-13, 4-16.
Eigen::ArrayXd ChoiceProbabilities(const Eigen::ArrayXd& intervals);

/// Expected benefit per interval of a move that takes `intervals` and changes the expected cost of
/// being matched: Softplus((before - after) / before) / intervals, where 0 / 0 counts 0.
/// Source: Eq. 4-10, 4-12, 4-14, 4-17.
double MoveBenefit(double before, double after, std::int32_t intervals);

/// icmUi: a UAV's two benefits, weighted by its share of range after the action; one without range
/// counts as empty. Source: Eq. 4-15.
double UavBenefit(double range_after_m, double range_full_m, double task_benefit,
                  double charge_benefit);

/// Numerator of the pair's own term for sensing: Softplus(100); uniform: Softplus(1).
/// Source: Eq. 4-18; section 5.3.3.
double SenseFoundation(Foundation foundation);

/// The same for charging a UAV whose share of range is `range_share` now: Softplus(10 + e^(1 - s));
/// uniform: Softplus(e^(1 - s) / e). Source: Eq. 4-19; section 5.3.3.
double ChargeFoundation(Foundation foundation, double range_share);

/// Weight of a pair: foundation / max(intervals) + the partners' benefits. Source: Eq. 4-18, 4-19.
double PairWeight(double foundation, std::int32_t uav_intervals, std::int32_t partner_intervals,
                  double uav_benefit, double partner_benefit);

/// One place and speed for which an expected cost is asked.
struct Probe {
  Point at;
  double speed_m_s = 0;
};

/// sum_x p_x * cost_x for each probe, where p are the ChoiceProbabilities among `sites` from there
/// by those ways at that speed, and cost [n_sites]. Each distinct probe is computed once:
/// O(distinct x n_sites). No sites: 0. Source: the sums of Eq. 4-10, 4-12, 4-14, 4-17.
std::vector<double> ExpectedCosts(const std::vector<Probe>& probes, const std::vector<Point>& sites,
                                  const Eigen::ArrayXd& cost, TimeUs unit_us, const WaysOf& ways);

/// Ways of agents to sites, all [n_agents x n_sites].
struct Legs {
  Table<double> way_m;
  Table<TimeUs> travel_us;        ///< kNever where it does not fit
  Table<std::int32_t> intervals;  ///< >= 1
};

/// All terms of all weights of one situation, so that no pair needs to be enumerated: the weight of
/// UiTxWj is sense_foundation / max(intervals of both) + worker_to_task + uav_senses, that of
/// UiCyVk charge_foundation[u] / max(intervals of both) + vehicle_to_charge + uav_charges.
///
/// Rows count the idle agents, columns the open tasks x or all charging points y. Benefits of a UAV
/// are meaningful where senseable (chargeable) says so.
struct Weights {
  /// Idle, online agents: positions in Situation::uavs, workers, vehicles, ascending.
  std::vector<std::int32_t> uavs, workers, vehicles;
  std::vector<TaskId> tasks;  ///< open tasks, ascending

  Legs uav_task, worker_task, uav_charge, vehicle_charge;
  Eigen::ArrayXd range_m;  ///< [n_uavs] now
  Table<bool> senseable;   ///< [n_uavs x n_tasks] constraint (6)
  Table<bool> chargeable;  ///< [n_uavs x n_charging_points] constraint (5)

  double stay = 0;                   ///< weight of Ui, Wj, Vk: Softplus(0)
  Table<double> uav_to_task;         ///< weight of UiTx
  Table<double> uav_senses;          ///< icmUi of UiTxWj: after the way and the sensing
  Table<double> worker_to_task;      ///< weight of WjTx, icmWj of UiTxWj
  Table<double> uav_to_charge;       ///< weight of UiCy
  Table<double> uav_charges;         ///< icmUi of UiCyVk: full afterwards
  Table<double> vehicle_to_charge;   ///< weight of VkCy, icmVk of UiCyVk
  double sense_foundation = 0;       ///< numerator of UiTxWj's own term
  Eigen::ArrayXd charge_foundation;  ///< [n_uavs] numerator of UiCyVk's own term

  int n_uavs() const { return static_cast<int>(uavs.size()); }
  int n_workers() const { return static_cast<int>(workers.size()); }
  int n_vehicles() const { return static_cast<int>(vehicles.size()); }
  int n_tasks() const { return static_cast<int>(tasks.size()); }
  int n_charging_points() const { return static_cast<int>(chargeable.cols()); }

  /// Weight of UiTxWj (row u, column x, row w).
  double Sense(int u, int x, int w) const {
    return PairWeight(sense_foundation, uav_task.intervals(u, x), worker_task.intervals(w, x),
                      uav_senses(u, x), worker_to_task(w, x));
  }
  /// Weight of UiCyVk (row u, column y, row v).
  double Charge(int u, int y, int v) const {
    return PairWeight(charge_foundation(u), uav_charge.intervals(u, y),
                      vehicle_charge.intervals(v, y), uav_charges(u, y), vehicle_to_charge(v, y));
  }
};

/// O((n_tasks + n_charging_points)^2 per distinct speed + n_agents * (n_tasks +
/// n_charging_points)).
Weights ComputeWeights(const Situation& situation,
                       Foundation foundation = Foundation::kHierarchical);

}  // namespace muster::scheduler
