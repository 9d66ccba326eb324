#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scheduler/policy.h"

namespace muster::scheduler {

/// A policy besides ours: its name, as --policy takes it, and how to make it.
struct OwnPolicy {
  std::string name;
  std::function<std::unique_ptr<Policy>()> make;
};

/// The body of muster-scheduler, and of a scheduler program of your own (docs/guide/installing.md):
/// --policy takes the names in `own` besides ours; without it the first of `own` decides. Returns
/// the exit code.
int SchedulerMain(int argc, char** argv, const std::vector<OwnPolicy>& own = {});

}  // namespace muster::scheduler
