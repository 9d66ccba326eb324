#pragma once

#include <string>
#include <vector>

#include "base/options.h"
#include "model/scenario.h"

namespace muster::tools {

/// Adds --roads, --roads-join and --roads-credit.
void AddRoadsOptions(Options* options);

/// Puts the roads of --roads, if given, into the scenario, which needs its origin for them unless
/// they are a road file. Returns what came of it, in lines. Throws InputError.
std::vector<std::string> TakeRoads(const Arguments& arguments, Scenario* scenario);

}  // namespace muster::tools
