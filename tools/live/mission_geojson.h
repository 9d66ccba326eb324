#pragma once

#include <optional>
#include <string>

#include "tools/report/timeline.h"

namespace muster::tools {

/// Tasks that have been reported, charging points and agents as they are now, for maps of other
/// programs: a FeatureCollection of points (docs/guide/orders.md). None: the scenario has no
/// origin.
std::optional<std::string> MissionGeoJson(const Timeline& timeline);

}  // namespace muster::tools
