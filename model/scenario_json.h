#pragma once

#include <string>
#include <string_view>

#include "model/scenario.h"

namespace muster {

/// Reads a scenario file, version 1 (docs/reference/scenario-format.md). Throws InputError naming
/// `file`, key, value found and value expected; SystemError when the file cannot be read.
Scenario LoadScenario(const std::string& file);

/// The same from text; `file` is only for messages.
Scenario ParseScenario(std::string_view json, std::string_view file);

/// The inverse: every optional key written out; parsing it again gives the same scenario, bit for
/// bit (numbers are written with the digits that it takes).
std::string ScenarioToJson(const Scenario& scenario);

/// A task as the file has it, without its id: {"x_km": ...}
std::string TaskToJson(const Task& task);

/// Throws InputError when a scenario that was built or changed in memory breaks a rule of the file.
/// `may_lack_tasks`: orders will bring them.
void ValidateScenario(const Scenario& scenario, std::string_view file, bool may_lack_tasks = false);

}  // namespace muster
