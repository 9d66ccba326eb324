#pragma once

#include "scheduler/policies/horizon/settings.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

/// Matches by value per true duration, sends ahead who would wait. Two matchings: the first among
/// the agents that are idle now or soon; of its pairs those of two idle agents are commanded. The
/// second among the same agents as they will be after it; an idle agent of one of its pairs that
/// has nothing else to do goes ahead. Source: ours.
class HorizonPolicy : public Policy {
 public:
  explicit HorizonPolicy(const HorizonSettings& settings = {}) : settings_(settings) {}
  Decision Decide(const Situation& situation) override;

 private:
  HorizonSettings settings_;
};

}  // namespace muster::scheduler
