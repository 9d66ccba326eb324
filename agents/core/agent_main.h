#pragma once

#include "model/scenario.h"

namespace muster::agents {

/// The body of muster-uav, muster-worker and muster-vehicle.
int AgentMain(AgentKind kind, int argc, char** argv);

}  // namespace muster::agents
