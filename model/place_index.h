#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/grid_index.h"
#include "model/ways.h"

namespace muster {

/// Places that agents of one class travel to or from. The straight line, which no way is shorter
/// than, finds the candidates; the length of the way decides.
class PlaceIndex {
 public:
  PlaceIndex(std::span<const Point> places, WaysOf ways)
      : grid_(places),
        ways_(ways),
        bent_(ways.straight() ? nullptr : ways.ways->DestinationsAt(ways.kind, places)) {}

  bool straight() const { return ways_.straight(); }

  /// Calls visit(index, metres) for every place whose way from `from` is at most `radius_m`, in an
  /// order that depends on the places alone.
  template <class Visit>
  void WithinFrom(Point from, double radius_m, Visit&& visit) const {
    WithinFrom(
        from, radius_m, [](std::int32_t, double) { return true; }, visit);
  }
  /// Of those only for which may(index, metres). Where it says no it must say no of longer ways,
  /// too: so it says already of the straight line which ways are not worth finding.
  template <class May, class Visit>
  void WithinFrom(Point from, double radius_m, May&& may, Visit&& visit) const {
    if (ways_.straight()) {
      return grid_.Within(from, radius_m, [&](std::int32_t i, Point, double distance_m) {
        if (may(i, distance_m)) visit(i, distance_m);
      });
    }
    const Found found(grid_, from, radius_m, may);
    std::vector<double> lengths_m(found.at.size());
    bent_->LengthsFrom(from, found.index, lengths_m);
    found.Visit(lengths_m, radius_m, [&](std::int32_t i, double metres) {
      if (may(i, metres)) visit(i, metres);
    });
  }
  /// The same for ways that lead from the places to `to`.
  template <class Visit>
  void WithinTo(Point to, double radius_m, Visit&& visit) const {
    const auto any = [](std::int32_t, double) { return true; };
    if (ways_.straight()) {
      return grid_.Within(to, radius_m,
                          [&](std::int32_t i, Point, double distance_m) { visit(i, distance_m); });
    }
    const Found found(grid_, to, radius_m, any);
    std::vector<double> lengths_m(found.at.size());
    ways_.ways->Lengths(ways_.kind, found.at, {&to, 1}, lengths_m);
    found.Visit(lengths_m, radius_m, visit);
  }
  /// Metres to the place that is nearest by way; infinity where there is none.
  double NearestFrom(Point from) const {
    return grid_.Nearest(from, [&](std::int32_t, Point place, double distance_m) {
      return ways_.straight() ? distance_m : ways_.Length(from, place);
    });
  }

 private:
  /// What may be within reach by way, too.
  struct Found {
    template <class May>
    Found(const GridIndex& grid, Point centre, double radius_m, const May& may) {
      index.reserve(64);
      at.reserve(64);
      grid.Within(centre, radius_m, [&](std::int32_t i, Point place, double distance_m) {
        if (!may(i, distance_m)) return;
        index.push_back(i);
        at.push_back(place);
      });
    }
    template <class Visits>
    void Visit(const std::vector<double>& lengths_m, double radius_m, Visits&& visit) const {
      for (std::size_t i = 0; i < index.size(); ++i) {
        if (lengths_m[i] <= radius_m) visit(index[i], lengths_m[i]);
      }
    }
    std::vector<std::int32_t> index;
    std::vector<Point> at;
  };
  GridIndex grid_;
  WaysOf ways_;
  std::unique_ptr<const Ways::Destinations> bent_;  ///< null: ways are straight
};

}  // namespace muster
