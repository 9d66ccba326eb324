#pragma once

#include <string>

#include "model/scenario.h"

namespace muster::tools {

/// Writes a scenario to `file`, and its road file, if any, beside it: each whole or, on failure
/// (SystemError), not at all, the road file first.
void WriteScenarioFile(const Scenario& scenario, const std::string& file);

}  // namespace muster::tools
