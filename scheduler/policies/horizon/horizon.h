#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "scheduler/policies/horizon/matching.h"
#include "scheduler/policies/horizon/settings.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

/// A decision of `horizon` with the matchings that it rests on.
struct HorizonPlan {
  Participants now;           ///< of the first matching; of agents of the situation
  std::vector<Match> first;   ///< members are indices into `now`
  Participants then;          ///< the same agents as they will be after it
  std::vector<Match> second;  ///< members are indices into `then`; empty without `send_ahead`
  Decision decision;
};

/// How a decision came about.
struct HowDecided {
  HorizonSettings settings;                ///< of the matchings
  std::optional<HorizonSettings> follow;   ///< `rollout`: the forecast decides on with these
  std::int32_t variant = 0, variants = 1;  ///< `rollout`: which of its variants, of how many
  std::vector<std::uint32_t> draws;        ///< `rollout`: the numbers of the random draws, if any
  std::size_t tasks_drawn = 0;             ///< `rollout`: tasks that the search for a plan changed
  /// Whether these settings lead to exactly the commanded actions. They do not where another build
  /// decided, or where no agent was commanded. The settings are then those of the first variant.
  bool again = false;
};
struct Deciding {
  HowDecided how;
  HorizonPlan plan;  ///< by these settings; of agents of the situation
};

/// A policy that decides by horizon's matchings, and can say how it did.
class MatchingPolicy : public Policy {
 public:
  /// How it came to command these actions in that situation. A deadline may have cut the decision
  /// short.
  virtual Deciding Explain(const Situation& situation,
                           const std::vector<Action>& commanded) const = 0;
};

/// Matches by value per true duration, sends waiting agents ahead. Two matchings: the first among
/// the agents that are idle now or soon; of its pairs those of two idle agents are commanded. The
/// second among the same agents as they will be after it; an idle agent of one of its pairs that
/// has nothing else to do goes ahead. Source: ours.
class HorizonPolicy : public MatchingPolicy {
 public:
  /// threads: 1 or 2; no decision depends on it.
  explicit HorizonPolicy(const HorizonSettings& settings = {}, int threads = 1)
      : settings_(settings), threads_(threads) {}
  Decision Decide(const Situation& situation) override;
  Deciding Explain(const Situation& situation, const std::vector<Action>& commanded) const override;
  /// "reach", kilometres, and "loss", of agents that decide without a centre.
  bool Set(std::string_view key, double value) override;
  /// The same actions, in any order, without the count of what they were chosen from.
  std::vector<Action> ActionsOf(const Situation& situation) const;

 private:
  HorizonSettings settings_;
  int threads_;
};

/// What HorizonPolicy decides, and why. `first`, when given, takes the place of the first matching.
HorizonPlan PlanHorizon(const Situation& situation, const HorizonSettings& settings,
                        const std::vector<Match>* first = nullptr);

}  // namespace muster::scheduler
