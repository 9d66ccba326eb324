#pragma once

#include <vector>

#include "scheduler/solver/build.h"

namespace muster::scheduler {

/// The actions of an assignment, in the order of Decision::actions, with their weights.
std::vector<Action> ActionsOf(const BuiltInstance& built, const Assignment& assignment,
                              const Situation& situation);

}  // namespace muster::scheduler
