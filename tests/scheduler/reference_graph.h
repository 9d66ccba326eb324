#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "model/action.h"
#include "model/feasibility.h"
#include "scheduler/situation.h"

namespace muster::scheduler::testing {

/// The conflict graph as the paper writes it: nodes one by one, weights by plain loops straight
/// from Eq. 4-1 to 4-19, edges in a matrix. Slow, and shares no code with scheduler/: what the fast
/// forms are compared with. Feasibility of pairs goes through Begin and PlanActivity, the rule
/// book.
class ReferenceGraph {
 public:
  explicit ReferenceGraph(const Situation& situation, bool uniform = false)
      : s_(situation), uniform_(uniform) {
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentState& agent : s_.agents(kind)) {
        if (agent.idle(s_.now_us)) idle_[kind].push_back(agent);
      }
    }
    for (std::size_t x = 0; x < s_.site->tasks.size(); ++x) {
      if (s_.task_status[x] == TaskStatus::kOpen) open_.push_back(x);
    }
    BuildNodes();
  }

  const std::vector<Action>& nodes() const { return nodes_; }

  /// Whether two nodes share an agent, a task, or a charging point with one free place.
  bool Conflict(const Action& a, const Action& b) const {
    return (a.uav.valid() && a.uav == b.uav) || (a.worker.valid() && a.worker == b.worker) ||
           (a.vehicle.valid() && a.vehicle == b.vehicle) || (a.task.valid() && a.task == b.task) ||
           (a.charge.valid() && a.charge == b.charge && s_.free_places(a.charge) <= 1);
  }

  /// Whether the nodes may be chosen together (charging points with more places need all of them).
  bool Independent(const std::vector<Action>& actions) const {
    for (std::size_t i = 0; i < actions.size(); ++i) {
      for (std::size_t j = i + 1; j < actions.size(); ++j) {
        if (Conflict(actions[i], actions[j])) return false;
      }
    }
    for (std::size_t y = 0; y < s_.site->charging_points.size(); ++y) {
      const auto used = std::count_if(actions.begin(), actions.end(),
                                      [y](const Action& a) { return a.charge == ChargeId(y); });
      if (used > s_.free_places(ChargeId(y))) return false;
    }
    return true;
  }

  /// The largest weight of an independent set, by branching on every node. Small instances only.
  double BestWeight() const {
    std::vector<Action> sorted = nodes_;
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const Action& a, const Action& b) { return a.weight > b.weight; });
    std::vector<Action> chosen;
    double best = 0;
    Branch(sorted, 0, 0, &chosen, &best);
    return best;
  }

 private:
  static double Soft(double x) { return x > 30 ? x + std::exp(-x) : std::log(1 + std::exp(x)); }
  const std::vector<AgentState>& idle(AgentKind kind) const { return idle_[kind]; }
  TimeUs unit() const {
    return s_.site->rules.ceil_to_minutes ? kMinuteUs : s_.site->rules.interval_us;
  }
  std::int64_t Count(const AgentState& agent, Point from, Point to) const {
    return Intervals(TravelUs(agent.WayM(from, to), agent.speed_m_s), unit());
  }
  static double Likelihood(double share) {
    return std::max(1e-6, (1 - std::exp(-share)) / (1 - std::exp(-1.0)));
  }
  double Share(const AgentState& uav) const { return s_.range_m(uav) / uav.range_full_m; }
  bool Senseable(const AgentState& uav, std::size_t x) const {
    const Task& task = s_.site->tasks[x];
    return CanSense(s_.range_m(uav), uav.WayM(uav.to, task.at), task.cost_m,
                    NearestChargeM(*s_.site->ways, task.at, s_.site->charging_points));
  }
  bool Reachable(const AgentState& uav, std::size_t y) const {
    return CanReachCharge(s_.range_m(uav), uav.WayM(uav.to, s_.site->charging_points[y].at));
  }

  double UavCost(Point at, bool charge, std::size_t site) const {
    double sum = 0;
    int n = 0;
    for (const AgentState& uav : idle(AgentKind::kUav)) {
      if (!(charge ? Reachable(uav, site) : Senseable(uav, site))) continue;
      ++n;
      sum += static_cast<double>(Count(uav, uav.to, at)) /
             Likelihood(charge ? 1 - Share(uav) : Share(uav));
    }
    if (idle(AgentKind::kUav).empty()) return 0;
    if (s_.site->rules.mean_over_all) {
      return sum / static_cast<double>(idle(AgentKind::kUav).size());
    }
    return n > 0 ? sum / n
                 : static_cast<double>(s_.site->rules.limit_us) / static_cast<double>(unit());
  }
  double PartnerCost(Point at, AgentKind kind) const {
    double sum = 0;
    for (const AgentState& agent : idle(kind)) {
      sum += static_cast<double>(Count(agent, agent.to, at));
    }
    return idle(kind).empty() ? 0 : sum / static_cast<double>(idle(kind).size());
  }

  /// The four sums: over tasks or charging points, of the costs by UAVs or by partners.
  double Expected(const AgentState& agent, Point from, bool charge, bool by_uav) const {
    double norm = 0, sum = 0;
    const std::size_t n = charge ? s_.site->charging_points.size() : open_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t site = charge ? i : open_[i];
      const Point at = charge ? s_.site->charging_points[site].at : s_.site->tasks[site].at;
      const double e = std::exp(-static_cast<double>(Count(agent, from, at)));
      norm += e;
      sum += e * (by_uav ? UavCost(at, charge, site)
                         : PartnerCost(at, charge ? AgentKind::kVehicle : AgentKind::kWorker));
    }
    return n == 0 ? 0 : sum / norm;
  }
  double Move(const AgentState& agent, Point to, bool charge, bool by_uav) const {
    const double before = Expected(agent, agent.to, charge, by_uav);
    const double after = Expected(agent, to, charge, by_uav);
    const double gain = before == 0 && after == 0 ? 0 : (before - after) / before;
    return Soft(gain) / static_cast<double>(Count(agent, agent.to, to));
  }
  double UavMove(const AgentState& uav, Point to, double range_after) const {
    const double share = range_after / uav.range_full_m;
    return share * Move(uav, to, false, false) + (1 - share) * Move(uav, to, true, false);
  }
  double PairTerm(double numerator, const AgentState& a, const AgentState& b, Point to) const {
    return numerator / static_cast<double>(std::max(Count(a, a.to, to), Count(b, b.to, to)));
  }

  bool Arrives(const AgentState& agent, Point to) const {
    return s_.now_us + TravelUs(agent.WayM(agent.to, to), agent.speed_m_s) <=
           LatestEnd(agent, s_.site->rules);
  }
  bool ArrivesAtTask(const AgentState& agent, std::size_t x) const {
    const Task& task = s_.site->tasks[x];
    return Arrives(agent, task.at) &&
           s_.now_us + TravelUs(agent.WayM(agent.to, task.at), agent.speed_m_s) < task.expires_us;
  }
  bool Ends(AgentState uav, AgentState partner, const Action& action) const {
    const TimeUs latest =
        std::min(LatestEnd(uav, s_.site->rules), LatestEnd(partner, s_.site->rules));
    Begin(&uav, action, s_.decision, s_.now_us, {}, 0);
    Begin(&partner, action, s_.decision, s_.now_us, {}, 0);
    const Activity activity = PlanActivity(uav, partner, s_.site->tasks);
    if (action.task.valid() &&
        activity.start_us >= s_.site->tasks[action.task.index()].expires_us) {
      return false;
    }
    return activity.end_us <= latest;
  }

  /// Whether the commander has forbidden one of its agents its task.
  bool Forbidden(const Action& action) const {
    return std::any_of(s_.site->forbidden.begin(), s_.site->forbidden.end(), [&](const auto& pair) {
      const std::int32_t agent =
          pair.kind == AgentKind::kUav ? action.uav.value : action.worker.value;
      return pair.task == action.task.value && pair.agent == agent;
    });
  }

  void Add(Action action, Point to, double weight) {
    if (Forbidden(action)) return;
    action.to = to;
    action.weight = weight;
    nodes_.push_back(action);
  }

  void BuildNodes() {
    const Site& site = *s_.site;
    const double e = std::exp(1.0);
    for (const AgentState& uav : idle(AgentKind::kUav)) {
      const double range = s_.range_m(uav);
      Action action;
      action.uav = UavId(uav.id);
      action.kind = ActionKind::kUavStays;
      Add(action, uav.to, Soft(0));
      for (const std::size_t x : open_) {
        const Point at = site.tasks[x].at;
        const double way = uav.WayM(uav.to, at);
        if (!Senseable(uav, x) || !ArrivesAtTask(uav, x)) continue;
        Action move = action;
        move.task = TaskId(x);
        move.kind = ActionKind::kUavToTask;
        Add(move, at, UavMove(uav, at, range - way));
        for (const AgentState& worker : idle(AgentKind::kWorker)) {
          Action pair = move;
          pair.kind = ActionKind::kSense;
          pair.worker = WorkerId(worker.id);
          pair.to = at;
          if (!Ends(uav, worker, pair)) continue;
          Add(pair, at,
              PairTerm(Soft(uniform_ ? 1 : 100), uav, worker, at) + Move(worker, at, false, true) +
                  UavMove(uav, at, range - way - site.tasks[x].cost_m));
        }
      }
      for (std::size_t y = 0; y < site.charging_points.size(); ++y) {
        const Point at = site.charging_points[y].at;
        if (s_.free_places(ChargeId(y)) == 0) continue;
        if (!Reachable(uav, y) || !Arrives(uav, at)) continue;
        Action move = action;
        move.charge = ChargeId(y);
        move.kind = ActionKind::kUavToCharge;
        Add(move, at, UavMove(uav, at, range - uav.WayM(uav.to, at)));
        for (const AgentState& vehicle : idle(AgentKind::kVehicle)) {
          Action pair = move;
          pair.kind = ActionKind::kCharge;
          pair.vehicle = VehicleId(vehicle.id);
          pair.to = at;
          if (!Ends(uav, vehicle, pair)) continue;
          const double bonus = std::exp(1 - Share(uav));
          Add(pair, at,
              PairTerm(Soft(uniform_ ? bonus / e : 10 + bonus), uav, vehicle, at) +
                  Move(vehicle, at, true, true) + UavMove(uav, at, uav.range_full_m));
        }
      }
    }
    for (const AgentState& worker : idle(AgentKind::kWorker)) {
      Action action;
      action.worker = WorkerId(worker.id);
      action.kind = ActionKind::kWorkerStays;
      Add(action, worker.to, Soft(0));
      action.kind = ActionKind::kWorkerToTask;
      for (const std::size_t x : open_) {
        if (!ArrivesAtTask(worker, x)) continue;
        action.task = TaskId(x);
        Add(action, site.tasks[x].at, Move(worker, site.tasks[x].at, false, true));
      }
    }
    for (const AgentState& vehicle : idle(AgentKind::kVehicle)) {
      Action action;
      action.vehicle = VehicleId(vehicle.id);
      action.kind = ActionKind::kVehicleStays;
      Add(action, vehicle.to, Soft(0));
      action.kind = ActionKind::kVehicleToCharge;
      for (std::size_t y = 0; y < site.charging_points.size(); ++y) {
        const Point at = site.charging_points[y].at;
        if (s_.free_places(ChargeId(y)) == 0 || !Arrives(vehicle, at)) continue;
        action.charge = ChargeId(y);
        Add(action, at, Move(vehicle, at, true, true));
      }
    }
  }

  void Branch(const std::vector<Action>& sorted, std::size_t next, double weight,
              std::vector<Action>* chosen, double* best) const {
    *best = std::max(*best, weight);
    if (next == sorted.size()) return;
    // Every further node takes at least one agent, and no node weighs more than the next one.
    std::size_t agents = 0, used = 0;
    for (const AgentKind kind : kAgentKinds) agents += idle_[kind].size();
    for (const Action& action : *chosen) used += IsPair(action.kind) ? 2 : 1;
    double bound = weight;
    std::size_t left = agents - used;
    for (std::size_t i = next; i < sorted.size() && left > 0; ++i, --left)
      bound += sorted[i].weight;
    if (bound <= *best) return;
    chosen->push_back(sorted[next]);
    if (Independent(*chosen)) Branch(sorted, next + 1, weight + sorted[next].weight, chosen, best);
    chosen->pop_back();
    Branch(sorted, next + 1, weight, chosen, best);
  }

  const Situation& s_;
  bool uniform_;
  PerKind<std::vector<AgentState>> idle_;
  std::vector<std::size_t> open_;
  std::vector<Action> nodes_;
};

}  // namespace muster::scheduler::testing
