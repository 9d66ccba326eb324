#pragma once

#include <cstdint>

#include "muster/agent_t.hpp"
#include "tools/audit/audit_scenario.h"

namespace muster::tools::audit {

/// What an agent_changes_t says of an agent that it does not list, at time `t`: it goes on as it
/// was listed at `told_us`, along its leg and through an activity whose end was told. By the
/// audit's own arithmetic; to be checked like a report.
agent_t Unlisted(const agent_t& told, int kind, std::int64_t told_us, std::int64_t t,
                 const Scenario& scenario);

}  // namespace muster::tools::audit
