#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/audit/ways.h"

namespace muster::tools::audit {

/// The outline of a zone and its holes.
using Rings = std::vector<std::vector<Place>>;

/// The zone of an order or a scenario, one JSON object. Throws std::exception when it has none.
Rings ReadZone(const std::string& json);

/// UAVs fly around zones (docs/reference/zones.md) by the audit's own code: pieces as polygons, the
/// shortest way by Dijkstra's algorithm on a matrix. Others travel as `ground` says.
/// `width_m`, `height_m`: extent of the area, for the grid on which moves to no site end.
std::shared_ptr<const Ways> FlyAround(std::vector<Rings> zones, double margin_m, double width_m,
                                      double height_m, std::shared_ptr<const Ways> ground);

}  // namespace muster::tools::audit
