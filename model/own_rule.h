#pragma once

#include <optional>

#include "model/action.h"
#include "model/agent.h"
#include "model/scenario.h"

namespace muster {

/// Below this share of its full range a UAV that nobody commands goes to charge.
inline constexpr double kReserveShare = 0.5;

/// What an agent does by itself at the time t of a decision that is not in force, as no scheduler
/// is left: an idle UAV with less than kReserveShare of its range goes alone to the charging point
/// that is nearest by way (then the lower id), if its range and its time allow. None: it stays,
/// as all other agents do, and UAVs that are kept apart, as nobody gives them an altitude.
/// Source: ours.
std::optional<Action> OwnAction(const AgentState& agent, TimeUs t, const Scenario& scenario);

}  // namespace muster
