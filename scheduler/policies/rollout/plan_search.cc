#include "scheduler/policies/rollout/plan_search.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "base/index.h"
#include "base/random.h"
#include "model/feasibility.h"
#include "scheduler/policies/horizon/horizon.h"
#include "scheduler/solver/parallel.h"

namespace muster::scheduler {
namespace {

constexpr double kDrawMost = 0.3;   ///< of a changed task, in tasks
constexpr double kEqual = 1e-9;     ///< worths of plans that differ by less are equal, in tasks
constexpr std::size_t kAtOnce = 2;  ///< plans that are simulated side by side
/// Draws of the search's own choices, apart from those of tasks and agents.
constexpr std::uint64_t kChoices = ~std::uint64_t{0};

/// The change of that number, the same at every decision: other draws for one to three tasks. False
/// where none of these tasks is open.
bool Change(std::uint32_t number, const Situation& situation, const std::vector<char>& open,
            HorizonSettings* settings) {
  Random random(situation.site->seed, Stream::kPlanSearch, kChoices, number);
  std::shared_ptr<TaskDraws> draws;
  for (std::uint32_t left = 1 + random.Below(3); left > 0; --left) {
    const std::uint32_t task = random.Below(static_cast<std::uint32_t>(open.size()));
    const std::uint32_t draw = 1 + random.Below(1000);
    if (!open[task]) continue;
    if (!draws) {
      draws = settings->task_draws ? std::make_shared<TaskDraws>(*settings->task_draws)
                                   : std::make_shared<TaskDraws>();
      draws->most = kDrawMost;
      draws->of.resize(open.size());
    }
    draws->of[task] = draw;
  }
  if (!draws) return false;
  settings->task_draws = std::move(draws);
  return true;
}

}  // namespace

Forecast ForecastOf(const std::vector<Future>& futures, const std::vector<Action>& first,
                    const HorizonSettings& follow, std::int64_t decisions, double early) {
  Forecast forecast;
  const HorizonPolicy policy(follow);
  for (const Future& future : futures) {
    ForwardModel model(future);
    model.Step(first);
    for (std::int64_t k = 1; k < decisions && !model.over() && model.anybody(); ++k) {
      model.Step(policy.ActionsOf(model.situation()));
    }
    const Site& site = *model.situation().site;
    const auto limit = static_cast<double>(site.rules.limit_us);
    forecast.done += model.done().size();
    for (const Activity& sensing : model.done()) {
      const double how_early = 1 - static_cast<double>(sensing.end_us) / limit;
      forecast.worth += WorthOf(site.tasks[At(sensing.site)], sensing.start_us, site.rules) *
                        (1 + early * how_early);
    }
  }
  return forecast;
}

SearchedPlan SearchPlans(const Situation& situation, const std::vector<Future>& futures,
                         const HorizonSettings& start, const SearchLimits& limits) {
  const auto forecast = [&](SearchedPlan* plan) {
    plan->forecast = ForecastOf(futures, HorizonPolicy(plan->settings).ActionsOf(situation),
                                plan->settings, INT64_MAX, limits.early);
  };
  SearchedPlan best{start, {}};
  std::vector<char> open;
  for (std::size_t x = 0; x < situation.task_status.size(); ++x) {
    open.push_back(futures.front().MayBeDone(x));
  }
  if (limits.forecasts <= 0 || std::count(open.begin(), open.end(), 1) == 0) return best;
  forecast(&best);
  std::uint32_t change = 0;
  for (std::int64_t tried = 0; tried < limits.forecasts; tried += kAtOnce) {
    if (limits.until && std::chrono::steady_clock::now() >= *limits.until) break;
    std::vector<SearchedPlan> next(kAtOnce, best);
    for (SearchedPlan& plan : next) {
      while (!Change(change++, situation, open, &plan.settings)) continue;
    }
    ParallelFor(kAtOnce, limits.threads, kAtOnce, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) forecast(&next[i]);
    });
    for (SearchedPlan& plan : next) {
      if (plan.forecast.worth > best.forecast.worth - kEqual) best = std::move(plan);
    }
  }
  return best;
}

}  // namespace muster::scheduler
