#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tools/audit/ways.h"

namespace muster::tools::audit {

/// What a scenario says of roads: how fast each class (1 workers, 2 vehicles) is on open ground and
/// how far from the road it may go.
struct OpenGround {
  std::int64_t percent = 0;
  double reach_m = 0;
};

/// The ways of a scenario with roads.
class RoadWays : public Ways {
 public:
  /// The same without those roads. Stops stay.
  virtual std::shared_ptr<const RoadWays> Without(const std::set<int>& roads) const = 0;
  /// The roads that an order names, as JSON. Throws std::exception when it names none.
  virtual std::set<int> RoadsIn(const std::string& order) const = 0;
};

/// Ways by road, from the text of a road file (docs/reference/roads.md) by the audit's own code:
/// its own graph, of points and not of junctions, its own search for the nearest road and for the
/// shortest way. `sites`: the scenario's tasks and charging points, where moves may end as at road
/// points. Throws std::exception when the text is no road file.
std::shared_ptr<const RoadWays> ReadRoadWays(const std::string& text, const OpenGround (&ground)[3],
                                             const std::vector<Place>& sites);

}  // namespace muster::tools::audit
