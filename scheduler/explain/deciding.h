#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/policies/horizon/horizon.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

/// How a decision of the `horizon` or `rollout` family came about.
struct Deciding {
  HorizonSettings settings;  ///< decided with these
  /// `rollout`: the forecast decides on with these.
  std::optional<HorizonSettings> follow;
  std::int32_t variant = 0, variants = 1;  ///< `rollout`: which of its variants, of how many
  std::vector<std::uint32_t> draws;        ///< `rollout`: varied by chance, the draws' numbers
  HorizonPlan plan;                        ///< of agents of the situation
  /// Whether the plan's decision is the commanded one. It is not where a deadline cut a decision
  /// short, where another build made it, or where nobody was commanded; the settings are then those
  /// of the first variant.
  bool again = false;
};

/// Whether reasons in horizon's terms can be given for what this policy decides.
bool DecidesByHorizon(const Policy& policy);

/// The way to weigh that leads to exactly the commanded actions: `horizon`'s own; of `rollout` the
/// first of its variants, else of its draws and theirs. Which one it was is read from the weights
/// of what was commanded, so nothing is carried forward. `policy` must decide by horizon.
Deciding HowDecided(const Situation& situation, const std::vector<Action>& commanded,
                    const Policy& policy);

/// What tells the settings from horizon's own: "patience 0.6"; empty when nothing does. Chance is
/// left out.
std::string Difference(const HorizonSettings& settings);

/// Tasks that are done when the situation is carried forward (ForwardModel) with these actions
/// first and the decisions of `follow` after them, to the end of the known agents' time.
std::size_t ForecastDone(const Situation& situation, const std::vector<Action>& actions,
                         const HorizonSettings& follow);

}  // namespace muster::scheduler
