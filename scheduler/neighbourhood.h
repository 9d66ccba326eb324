#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "model/scenario.h"
#include "scheduler/situation.h"

namespace muster::scheduler {

/// Numbers places along a Z-order curve, so that places with close numbers are close to each other.
/// Large situations list agents and sites in this order, as memory far apart is slow to reach.
class Neighbourhoods {
 public:
  explicit Neighbourhoods(const Site& site)
      : cell_m_(std::max(std::max(site.width_m, site.height_m) / 65535, 1e-3)) {}

  std::uint32_t Of(Point place) const { return Cell(place.x_m) | Cell(place.y_m) << 1; }

  /// Sorts elements by the neighbourhood of at(element); those of one cell keep their order.
  template <class Element, class At>
  void Sort(std::vector<Element>* elements, const At& at) const {
    std::vector<std::pair<std::uint32_t, std::size_t>> keyed;
    keyed.reserve(elements->size());
    for (std::size_t i = 0; i < elements->size(); ++i)
      keyed.emplace_back(Of(at((*elements)[i])), i);
    std::sort(keyed.begin(), keyed.end());
    std::vector<Element> sorted;
    sorted.reserve(elements->size());
    for (const auto& [cell, i] : keyed) sorted.push_back((*elements)[i]);
    *elements = std::move(sorted);
  }

 private:
  /// The cell's number along one axis, its bits spread to every second place.
  std::uint32_t Cell(double metres) const {
    auto z = static_cast<std::uint32_t>(std::clamp(metres / cell_m_, 0.0, 65535.0));
    z = (z | z << 8) & 0x00FF00FFu;
    z = (z | z << 4) & 0x0F0F0F0Fu;
    z = (z | z << 2) & 0x33333333u;
    return (z | z << 1) & 0x55555555u;
  }

  double cell_m_;
};

/// Whether the situation is so large that it is listed by neighbourhood; small ones are listed by
/// id.
inline bool ByNeighbourhood(const Situation& situation) {
  constexpr std::size_t kMany = 4096;
  return situation.uavs.size() + situation.workers.size() + situation.vehicles.size() +
             situation.site->tasks.size() >
         kMany;
}

}  // namespace muster::scheduler
