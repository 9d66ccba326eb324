#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "model/ways.h"

namespace muster::testing {

/// Everybody goes east or west first, then north or south: ways that bend, for tests that code does
/// not take them to be straight.
class ManhattanWays : public Ways {
 public:
  ManhattanWays() : Ways({true, true, true}) {}

 private:
  double BentLength(AgentKind, Point from, Point to) const override {
    return std::abs(to.x_m - from.x_m) + std::abs(to.y_m - from.y_m);
  }
  std::vector<Corner> BentCorners(AgentKind kind, Point from, Point to) const override {
    if (from.x_m == to.x_m || from.y_m == to.y_m) return {};
    return {{{to.x_m, from.y_m}, std::abs(to.x_m - from.x_m) / Length(kind, from, to)}};
  }
};

/// While it lives, all scenarios of this process have Manhattan ways.
class InManhattan : public ScopedDefaultWays {
 public:
  InManhattan() : ScopedDefaultWays(std::make_shared<const ManhattanWays>()) {}
};

}  // namespace muster::testing
