#pragma once

#include <string>

#include "base/options.h"
#include "tools/faults/fault_plan.h"

namespace muster::tools {

/// The faults of a mission and how it responds to them: the same for `muster run` and `muster
/// simulate`.
struct FaultOptions {
  double drop = 0;               ///< share of received packets that each process drops
  FaultPlan faults;              ///< not checked against the mission yet
  std::string on_loss = "wait";  ///< or continue, as muster-world takes it
  double lost_after_s = 5;
  int restarts = 5;  ///< how often a process that ended by itself is started again

  bool goes_on() const { return on_loss == "continue"; }
};

void AddDropOption(Options* options);
void AddFaultOptions(Options* options);
/// Throws InputError on a plan that cannot be read.
FaultOptions ReadFaultOptions(const Arguments& arguments);

}  // namespace muster::tools
