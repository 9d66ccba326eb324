#pragma once

#include "scheduler/policy.h"

namespace muster::scheduler {

/// HoCs-GREEDY: every idle agent goes to the best centre of a 1 km cell within one interval's way
/// (and, for a UAV, its range). UAVs and workers minimise the distances to the open tasks, then
/// vehicles those to the places that UAVs are bound for. Ties: the first cell, row by row from the
/// south-west. In availability mode strict the move must arrive by LatestEnd. No pairs are
/// formed: without Rules::start_on_meeting no task is ever done.
///
/// kSum takes the sum of the distances, as the paper's text says: a geometric median, so all agents
/// drift to the middle of the tasks. kNearest takes the nearest one, which is closer to the paper's
/// figures. Source: the paper's appendix B, HoCs-GREEDY; kNearest ours.
class GreedyPolicy : public Policy {
 public:
  enum class Aim { kSum, kNearest };
  explicit GreedyPolicy(Aim aim) : aim_(aim) {}
  Decision Decide(const Situation& situation) override;

 private:
  Aim aim_;
};

}  // namespace muster::scheduler
