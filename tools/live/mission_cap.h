#pragma once

#include <optional>
#include <string>

#include "tools/report/timeline.h"

namespace muster::tools {

/// Tasks that have been reported, as alerts in CAP 1.2 inside one Atom feed, for dispatch systems
/// (docs/guide/feeds.md). What is done, expired or cancelled is a Cancel of its alert. A mission
/// without a measured agent is an exercise. `run`: its name, in the identifiers. None: the scenario
/// has no origin or no start.
std::optional<std::string> MissionCap(const Timeline& timeline, const std::string& run);

}  // namespace muster::tools
