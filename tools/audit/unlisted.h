#pragma once

#include <cstdint>

#include "muster/agent_t.hpp"
#include "tools/audit/audit_scenario.h"

namespace muster::tools::audit {

/// What an agent_changes_t says about an agent that it does not list, at time `t`: the agent goes
/// on as it was listed at `told_us`, along its leg and through an activity whose end is known. The
/// audit computes this by its own arithmetic and checks it like a report.
agent_t Unlisted(const agent_t& told, int kind, std::int64_t told_us, std::int64_t t,
                 const Scenario& scenario);

}  // namespace muster::tools::audit
