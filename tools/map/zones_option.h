#pragma once

#include <string>
#include <vector>

#include "base/options.h"
#include "model/scenario.h"

namespace muster::tools {

/// Adds --zones, --zone-margin, --authorised and --keep-apart.
void AddZonesOptions(Options* options);

/// Puts the zones of --zones, if given, into the scenario, after its roads; with --keep-apart alone
/// an airspace without zones. Returns what came of
/// it, in lines. Throws InputError.
std::vector<std::string> TakeZones(const Arguments& arguments, Scenario* scenario);

}  // namespace muster::tools
