#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/simulate/virtual_mission.h"

namespace muster::tools {

/// What kind of finding it is: the text without numbers, so that other times and agents are no
/// other kind.
std::string FindingKind(const std::string& finding);

/// The mission with less of what disturbs it, as long as `fails` holds: without faults, orders,
/// losses and schedulers that it does not take, and its faults as short as they may be. No single
/// one of the faults that are left can be left out. Delta debugging (Zeller and Hildebrandt 2002).
/// Ends early when `stop` holds.
VirtualMission Shrink(
    VirtualMission mission, const std::function<bool(const VirtualMission&)>& fails,
    const std::function<bool()>& stop = [] { return false; });

}  // namespace muster::tools
