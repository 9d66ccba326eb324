#pragma once

#include <GeographicLib/LocalCartesian.hpp>

#include "base/geometry.h"
#include "model/scenario.h"

namespace muster::tools {

/// The map frame of an area: local ENU at its south-west corner, in metres.
class LocalFrame {
 public:
  explicit LocalFrame(Origin corner);

  /// A place beyond the horizon (another continent) gets a point of NaN, which is in no area.
  Point ToPoint(Origin place) const;
  Origin ToPlace(Point point) const;

 private:
  GeographicLib::LocalCartesian local_;
};

}  // namespace muster::tools
