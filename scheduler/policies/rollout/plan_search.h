#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "scheduler/policies/horizon/settings.h"
#include "scheduler/policies/rollout/forward_model.h"

namespace muster::scheduler {

/// What a decision leads to.
struct Forecast {
  /// What the tasks that get done are worth, each with up to `early` of it more the earlier it
  /// ends.
  double worth = 0;
  std::size_t done = 0;  ///< tasks
};

/// Carries each future forward: these actions first, then what `horizon` decides with the settings
/// `follow`, for `decisions` decisions in all or to the end. The sum over the futures. `early`: how
/// much more a task done at mission start is worth than one done at the limit, in tasks.
Forecast ForecastOf(const std::vector<Future>& futures, const std::vector<Action>& first,
                    const HorizonSettings& follow, std::int64_t decisions, double early);

/// A whole plan: `horizon` decides with these settings now and at all later decisions.
struct SearchedPlan {
  HorizonSettings settings;
  Forecast forecast;
};

struct SearchLimits {
  std::int64_t forecasts = 0;  ///< so many plans are tried
  /// Trying ends then, too: an answer may then depend on the machine's speed.
  std::optional<std::chrono::steady_clock::time_point> until;
  int threads = 2;  ///< 1 or 2; no answer depends on it
  double early = 0.5;
};

/// Looks for a plan that gets more done, from `start` on: changes by chance what agents are worth
/// at one to three tasks (HorizonSettings::task_draws), simulates the whole plan, and keeps the
/// change unless it makes the plan worse. `situation` is that of all futures. The changes come in
/// the same order at every decision of a mission: what was kept at one decision is mostly kept at
/// the next, so a plan lives on although nothing is remembered. Source: ours; to search among the
/// inputs of a constructive heuristic is the idea of Storer, Wu and Vaccari (1992).
SearchedPlan SearchPlans(const Situation& situation, const std::vector<Future>& futures,
                         const HorizonSettings& start, const SearchLimits& limits);

}  // namespace muster::scheduler
