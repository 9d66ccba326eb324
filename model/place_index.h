#pragma once

#include <span>

#include "base/grid_index.h"
#include "model/ways.h"

namespace muster {

/// Places that agents of one class travel to or from. The straight line, which no way is shorter
/// than, finds the candidates; the length of the way decides.
class PlaceIndex {
 public:
  PlaceIndex(std::span<const Point> places, WaysOf ways) : grid_(places), ways_(ways) {}

  /// Calls visit(index, metres) for every place whose way from `from` is at most `radius_m`, in an
  /// order that depends on the places alone.
  template <class Visit>
  void WithinFrom(Point from, double radius_m, Visit&& visit) const {
    grid_.Within(from, radius_m, [&](std::int32_t i, Point place, double distance_m) {
      if (ways_.straight()) return visit(i, distance_m);
      const double way_m = ways_.Length(from, place);
      if (way_m <= radius_m) visit(i, way_m);
    });
  }
  /// The same for ways that lead from the places to `to`.
  template <class Visit>
  void WithinTo(Point to, double radius_m, Visit&& visit) const {
    grid_.Within(to, radius_m, [&](std::int32_t i, Point place, double distance_m) {
      if (ways_.straight()) return visit(i, distance_m);
      const double way_m = ways_.Length(place, to);
      if (way_m <= radius_m) visit(i, way_m);
    });
  }
  /// Metres to the place that is nearest by way; infinity where there is none.
  double NearestFrom(Point from) const {
    return grid_.Nearest(from, [&](std::int32_t, Point place, double distance_m) {
      return ways_.straight() ? distance_m : ways_.Length(from, place);
    });
  }

 private:
  GridIndex grid_;
  WaysOf ways_;
};

}  // namespace muster
