#pragma once

#include "world/referee.h"

namespace muster::world {

/// Throws InputError with the reason when a directive that is taken at t cannot be kept, as far as
/// is known then: an agent has failed or left, no way leads there, range or time does not suffice,
/// another directive speaks against it. An agent that is under way is taken to be free where it
/// goes, a UAV with a full battery. `scenario` contains the directive.
void CheckDirective(const Directive& directive, TimeUs t, const Agents& agents,
                    const Scenario& scenario);

/// Throws InputError when the agent has failed or has left by t.
void CheckAgent(TimeUs t, const AgentState& agent);

}  // namespace muster::world
