#pragma once

#include "scheduler/policy.h"

namespace muster::scheduler {

/// HoCs-KWTA: static selection by K-winners-take-all. UAVs with less than half their range, or
/// without a task within constraint (6), look for charging, the others for tasks. Sites are scored
/// by likelihood (Eq. 4-1, 4-4; 1 for partners) per interval of the way; ties: the shorter way,
/// then the smaller index. Each agent's K best sites are its winners. UAVs, the best score first,
/// take their best winner that is a free partner's winner too, with the best such partner; without
/// one they go on to rank K + 1, K + 2, ... while the partners' lists widen alike. Pairs that the
/// availability mode forbids are passed over. A vehicle takes one UAV a decision, a charging point
/// as many as it has free places. The others stay. Weights are the paper's, to compare.
/// Source: the paper's appendix B, HoCs-KWTA; the scores and K = 3 are ours.
class KwtaPolicy : public Policy {
 public:
  explicit KwtaPolicy(int winners) : winners_(winners) {}
  Decision Decide(const Situation& situation) override;

 private:
  int winners_;  // K >= 1
};

}  // namespace muster::scheduler
