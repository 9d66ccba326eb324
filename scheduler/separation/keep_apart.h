#pragma once

#include "scheduler/policy.h"

namespace muster::scheduler {

/// The decision with an altitude for every UAV that it sends, such that no two UAVs come closer
/// than the site's minima, for as long as nobody gets another command, and none flies into a zone
/// that it has to fly below. Where the site has no separation the decision stays as it is.
///
/// UAVs take their turns in the order of the actions. Each gets the lowest altitude that is free
/// for its whole way: first of those of its direction (east 1st, 3rd, ...; west 2nd, 4th, ...),
/// then of all. Where none is free it sets out later, in steps of 5 s, by 2 min at most. Where that
/// does not help, or the action would then be too late, the action is left out. A UAV that stays
/// and would be met changes its altitude. One that nobody sends, in a zone that is new, goes to the
/// nearest free stop. Source: greedy colouring of the conflicts; ours.
Decision KeepApart(const Situation& situation, Decision decision);

}  // namespace muster::scheduler
