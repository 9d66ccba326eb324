#include "tools/bound/upper_bound.h"

#include <algorithm>
#include <numbers>
#include <span>
#include <vector>

#include "model/feasibility.h"
#include "tools/bound/max_flow.h"

namespace muster::tools {
namespace {

/// Ways are rounded to microseconds, leg by leg: a way in a thousand legs may be this much shorter.
constexpr TimeUs kRoundingUs = 1000;
constexpr double kCellDiagonal_m = 1000 * std::numbers::sqrt2;

/// When a UAV or a worker can do tasks.
struct Window {
  std::int32_t first = 0;  ///< decision
  std::int32_t last = -1;  ///< decision; before `first`: none
  TimeUs latest_us = 0;    ///< its sensing has ended
  std::int32_t tasks = 0;  ///< at most
};

class Relaxation {
 public:
  explicit Relaxation(const Scenario& scenario)
      : scenario_(scenario), interval_us_(scenario.rules.interval_us) {
    for (const AgentSpec& uav : scenario.uavs) {
      fastest_m_s_ = std::max(fastest_m_s_, uav.speed_m_s);
    }
    // Behind them is room for tasks that no order has added.
    const auto tasks = std::span(scenario.tasks).first(scenario.n_tasks());
    double least_cost_m = tasks.empty() ? 0 : tasks[0].cost_m;
    for (const Task& task : tasks) {
      least_cost_m = std::min(least_cost_m, task.cost_m);
      to_charge_m_.push_back(NearestChargeM(*scenario.ways, task.at, scenario.charging_points));
    }
    for (const AgentSpec& uav : scenario.uavs) {
      uavs_.push_back(WindowOf(uav, SensingUs(least_cost_m, uav.speed_m_s)));
    }
    for (const AgentSpec& worker : scenario.workers) {
      workers_.push_back(WindowOf(worker, SensingUs(least_cost_m, fastest_m_s_)));
    }
  }

  std::int64_t AnyDecision() const {
    const auto n_tasks = static_cast<std::int32_t>(scenario_.n_tasks());
    // Source, sink, tasks (in, out), then each agent followed by its decisions.
    const std::int32_t source = 0, sink = 1, tasks = 2;
    std::int32_t nodes = tasks + 2 * n_tasks;
    std::vector<std::int32_t> uav_at, worker_at;
    const auto place = [&](const std::vector<Window>& windows, std::vector<std::int32_t>* at) {
      for (const Window& window : windows) {
        at->push_back(nodes);
        nodes += 1 + std::max(0, window.last - window.first + 1);
      }
    };
    place(uavs_, &uav_at);
    place(workers_, &worker_at);
    MaxFlow flow(nodes);
    for (std::int32_t x = 0; x < n_tasks; ++x) flow.Arc(tasks + 2 * x, tasks + 2 * x + 1, 1);
    for (std::size_t u = 0; u < uavs_.size(); ++u) {
      flow.Arc(source, uav_at[u], uavs_[u].tasks);
      for (std::int32_t k = uavs_[u].first; k <= uavs_[u].last; ++k) {
        const std::int32_t node = uav_at[u] + 1 + k - uavs_[u].first;
        flow.Arc(uav_at[u], node, 1);
        for (std::int32_t x = 0; x < n_tasks; ++x) {
          if (UavCan(u, k, x)) flow.Arc(node, tasks + 2 * x, 1);
        }
      }
    }
    for (std::size_t w = 0; w < workers_.size(); ++w) {
      flow.Arc(worker_at[w], sink, workers_[w].tasks);
      for (std::int32_t k = workers_[w].first; k <= workers_[w].last; ++k) {
        const std::int32_t node = worker_at[w] + 1 + k - workers_[w].first;
        flow.Arc(node, worker_at[w], 1);
        for (std::int32_t x = 0; x < n_tasks; ++x) {
          if (WorkerCan(w, k, x)) flow.Arc(tasks + 2 * x + 1, node, 1);
        }
      }
    }
    return flow.Solve(source, sink);
  }

  std::int64_t DecisionByDecision() const {
    const auto n_tasks = static_cast<std::int32_t>(scenario_.n_tasks());
    const auto n_uavs = static_cast<std::int32_t>(uavs_.size());
    const auto n_workers = static_cast<std::int32_t>(workers_.size());
    const std::int32_t source = 0, sink = 1, tasks = 2, uavs = tasks + 2 * n_tasks,
                       workers = uavs + n_uavs;
    std::int64_t sum = 0;
    for (std::int32_t k = 0; k < scenario_.decisions(); ++k) {
      MaxFlow flow(workers + n_workers);
      for (std::int32_t x = 0; x < n_tasks; ++x) flow.Arc(tasks + 2 * x, tasks + 2 * x + 1, 1);
      for (std::int32_t u = 0; u < n_uavs; ++u) {
        flow.Arc(source, uavs + u, 1);
        for (std::int32_t x = 0; x < n_tasks; ++x) {
          if (UavCan(static_cast<std::size_t>(u), k, x)) flow.Arc(uavs + u, tasks + 2 * x, 1);
        }
      }
      for (std::int32_t w = 0; w < n_workers; ++w) {
        flow.Arc(workers + w, sink, 1);
        for (std::int32_t x = 0; x < n_tasks; ++x) {
          if (WorkerCan(static_cast<std::size_t>(w), k, x)) {
            flow.Arc(tasks + 2 * x + 1, workers + w, 1);
          }
        }
      }
      sum += flow.Solve(source, sink);
    }
    return sum;
  }

 private:
  Window WindowOf(const AgentSpec& agent, TimeUs sensing_us) const {
    const Rules& rules = scenario_.rules;
    Window window;
    window.first =
        static_cast<std::int32_t>((agent.online_from_us + interval_us_ - 1) / interval_us_);
    const TimeUs end_us = std::min(agent.online_until_us, rules.limit_us);
    window.last = static_cast<std::int32_t>((end_us + interval_us_ - 1) / interval_us_) - 1;
    window.latest_us = rules.availability == Availability::kStrict ? end_us : rules.limit_us;
    if (sensing_us > rules.limit_us) return window;
    // Decisions from one command to the next.
    const auto each = static_cast<std::int32_t>(Intervals(sensing_us, interval_us_));
    for (std::int32_t k = window.first; k <= window.last; k += each) {
      if (k * interval_us_ + sensing_us <= window.latest_us) ++window.tasks;
    }
    return window;
  }

  bool Can(AgentKind kind, const AgentSpec& agent, const Window& window, std::int32_t k,
           const Task& task, double uav_speed_m_s) const {
    if (k < window.first || k > window.last) return false;
    double way_m = scenario_.ways->Length(kind, agent.at, task.at);
    if (scenario_.rules.start_on_meeting) way_m = std::max(0.0, way_m - kCellDiagonal_m);
    const TimeUs travel_us = TravelUs(way_m, agent.speed_m_s);
    const TimeUs sensing_us = SensingUs(task.cost_m, uav_speed_m_s);
    if (travel_us > window.latest_us || sensing_us > window.latest_us) return false;
    const TimeUs there_us = window.first * interval_us_ + travel_us - kRoundingUs;
    return std::max(k * interval_us_, there_us) + sensing_us <= window.latest_us;
  }
  bool UavCan(std::size_t u, std::int32_t k, std::int32_t x) const {
    const AgentSpec& uav = scenario_.uavs[u];
    const Task& task = scenario_.tasks[static_cast<std::size_t>(x)];
    return CanSense(std::max(uav.range_full_m, uav.range_m), 0, task.cost_m,
                    to_charge_m_[static_cast<std::size_t>(x)]) &&
           Can(AgentKind::kUav, uav, uavs_[u], k, task, uav.speed_m_s);
  }
  bool WorkerCan(std::size_t w, std::int32_t k, std::int32_t x) const {
    return Can(AgentKind::kWorker, scenario_.workers[w], workers_[w], k,
               scenario_.tasks[static_cast<std::size_t>(x)], fastest_m_s_);
  }

  const Scenario& scenario_;
  TimeUs interval_us_;
  double fastest_m_s_ = 0;
  std::vector<double> to_charge_m_;  ///< [n_tasks]
  std::vector<Window> uavs_, workers_;
};

}  // namespace

std::int64_t UpperBound(const Scenario& scenario) {
  const Relaxation relaxation(scenario);
  return std::min(relaxation.AnyDecision(), relaxation.DecisionByDecision());
}

}  // namespace muster::tools
