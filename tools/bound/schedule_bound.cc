#include "tools/bound/schedule_bound.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include "base/index.h"
#include "scheduler/solver/parallel.h"
#include "tools/bound/agent_times.h"
#include "tools/bound/linear_program.h"

namespace muster::tools {
namespace {

constexpr double kGain = 1e-9;

/// The linear program, its columns and what agents' lists are worth at its prices.
class Schedules {
 public:
  explicit Schedules(const Scenario& scenario)
      : agents_(scenario),
        n_uavs_(agents_.uavs().size()),
        n_workers_(agents_.workers().size()),
        n_agents_(n_uavs_ + n_workers_ + agents_.vehicles().size()),
        sensing_(agents_.n_tasks(), agents_.decisions(), 0.5),
        charging_(agents_.n_charging(), agents_.decisions(), 0),
        agents_worth_(n_agents_),
        tasks_(agents_.n_tasks()),
        program_(Limits()) {}

  double value() const { return program_.value(); }

  /// Adds the list that is worth most of each agent, and solves the program. Returns the bound that
  /// the prices before prove.
  double Round() {
    const double bound = AddLists();
    program_.Solve();
    const std::vector<double> prices = program_.Prices();
    std::copy_n(prices.begin(), n_agents_, agents_worth_.begin());
    for (std::size_t x = 0; x < tasks_.size(); ++x) tasks_[x] = prices[n_agents_ + x];
    for (std::size_t i = 0; i < sensing_.size(); ++i) sensing_[i] = prices[FirstVisitRow() + i];
    for (std::size_t i = 0; i < charging_.size(); ++i) {
      charging_[i] = prices[FirstVisitRow() + sensing_.size() + i];
    }
    return bound;
  }

 private:
  // Rows: agents, tasks, (task, decision), (charging point, decision).
  std::size_t FirstVisitRow() const { return n_agents_ + tasks_.size(); }
  std::size_t RowOfSensing(Visit visit) const { return FirstVisitRow() + sensing_.IndexOf(visit); }
  std::size_t RowOfCharging(Visit visit) const {
    return FirstVisitRow() + sensing_.size() + charging_.IndexOf(visit);
  }
  std::vector<double> Limits() const {
    std::vector<double> limits(FirstVisitRow(), 1);
    limits.resize(limits.size() + sensing_.size() + charging_.size(), 0);
    return limits;
  }

  double AddLists() {
    const auto decisions = At(agents_.decisions());
    Prices uav_prices = sensing_;
    for (std::size_t i = 0; i < uav_prices.size(); ++i) {
      uav_prices[i] = 1 - tasks_[i / decisions] - sensing_[i];
    }
    std::vector<BestList> lists(n_agents_);
    const auto find = [&](std::size_t first) {
      for (std::size_t i = first; i < n_agents_; i += 2) {
        if (i < n_uavs_) {
          const AgentTimes::Uav& uav = agents_.uavs()[i];
          lists[i] = BestFlightsOf(*uav.table, uav.times, uav_prices, charging_);
        } else if (i < n_uavs_ + n_workers_) {
          const AgentTimes::Partner& worker = agents_.workers()[i - n_uavs_];
          lists[i] = BestListOf(*worker.table, worker.times, sensing_);
        } else {
          const AgentTimes::Partner& vehicle = agents_.vehicles()[i - n_uavs_ - n_workers_];
          lists[i] = BestListOf(*vehicle.table, vehicle.times, charging_);
        }
      }
    };
    scheduler::AtOnce([&] { find(0); }, [&] { find(1); });
    double bound = 0;
    for (const double price : tasks_) bound += price;
    for (std::size_t i = 0; i < n_agents_; ++i) {
      bound += lists[i].worth;
      // One that is worth no more than what the program has for the agent changes nothing.
      if (lists[i].worth > agents_worth_[i] + kGain) AddColumn(i, lists[i].visits);
    }
    return bound;
  }

  void AddColumn(std::size_t agent, std::span<const Visit> list) {
    std::map<std::size_t, double> factors = {{agent, 1}};
    double worth = 0;
    for (const Visit& visit : list) {
      if (agent >= n_uavs_) {
        factors[agent < n_uavs_ + n_workers_ ? RowOfSensing(visit) : RowOfCharging(visit)] -= 1;
      } else if (At(visit.site) < tasks_.size()) {
        worth += 1;
        factors[n_agents_ + At(visit.site)] += 1;
        factors[RowOfSensing(visit)] += 1;
      } else {
        const auto point = visit.site - static_cast<std::int32_t>(tasks_.size());
        factors[RowOfCharging({point, visit.free_at})] += 1;
      }
    }
    std::vector<LinearProgram::Entry> entries;
    for (const auto& [row, factor] : factors) {
      entries.push_back({static_cast<std::int32_t>(row), factor});
    }
    program_.AddColumn(worth, entries);
  }

  const AgentTimes agents_;
  const std::size_t n_uavs_, n_workers_, n_agents_;
  Prices sensing_, charging_;         ///< what partners get
  std::vector<double> agents_worth_;  ///< what each agent's lists are worth in the program
  std::vector<double> tasks_;         ///< what it is worth that a task can be done once more
  LinearProgram program_;
};

}  // namespace

double ScheduleBound(const Scenario& scenario, std::int64_t rounds, const BoundProgress& progress) {
  auto best = static_cast<double>(scenario.n_tasks());
  if (scenario.rules.start_on_meeting || scenario.n_tasks() == 0) return best;
  Schedules schedules(scenario);
  for (std::int64_t round = 0; round < rounds; ++round) {
    best = std::min(best, schedules.Round());
    if (progress) progress(round + 1, best);
    // The bound is never below the program's value, and more columns only make that larger.
    if (WholeTasks(best) <= WholeTasks(schedules.value())) break;
  }
  return best;
}

}  // namespace muster::tools
