#pragma once

#include <vector>

#include "scheduler/policies/horizon/matching.h"
#include "scheduler/policies/horizon/settings.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

/// Matches by value per true duration, sends ahead who would wait. Two matchings: the first among
/// the agents that are idle now or soon; of its pairs those of two idle agents are commanded. The
/// second among the same agents as they will be after it; an idle agent of one of its pairs that
/// has nothing else to do goes ahead. Source: ours.
class HorizonPolicy : public Policy {
 public:
  /// threads: 1 or 2; no decision depends on it.
  explicit HorizonPolicy(const HorizonSettings& settings = {}, int threads = 1)
      : settings_(settings), threads_(threads) {}
  Decision Decide(const Situation& situation) override;
  const HorizonSettings& settings() const { return settings_; }
  /// The same actions, in any order, without the count of what they were chosen from.
  std::vector<Action> ActionsOf(const Situation& situation) const;

 private:
  HorizonSettings settings_;
  int threads_;
};

/// A decision of `horizon` with the matchings that it rests on.
struct HorizonPlan {
  Participants now;           ///< of the first matching; of agents of the situation
  std::vector<Match> first;   ///< members are indices into `now`
  Participants then;          ///< the same agents as they will be after it
  std::vector<Match> second;  ///< members are indices into `then`; empty without `send_ahead`
  Decision decision;
};

/// What HorizonPolicy decides, and why. `first`, when given, takes the place of the first matching.
HorizonPlan PlanHorizon(const Situation& situation, const HorizonSettings& settings,
                        const std::vector<Match>* first = nullptr);

}  // namespace muster::scheduler
