#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "model/scenario.h"

namespace muster::tools {

/// A drawing for below the map, from GeoJSON in WGS84 degrees: [[kind, name, [latitude, longitude,
/// ...], ...], ...] with kind 0 for points, 1 for lines, 2 for polygons, whose rings follow each
/// other; `name` is the feature's property of that name, or "". What lies further from the
/// scenario's area than its own size is left out. Throws InputError when `text` is no GeoJSON, or
/// the scenario has no origin.
nlohmann::ordered_json Background(std::string_view text, std::string_view file,
                                  const Scenario& scenario);

}  // namespace muster::tools
