#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "base/geometry.h"

namespace muster {

/// Points in square buckets, for range queries. Built in linear time; about `per_cell` points a
/// bucket when they are spread evenly.
class GridIndex {
 public:
  explicit GridIndex(std::span<const Point> points, double per_cell = 3);

  /// Calls visit(index, point, distance) for every point within `radius_m` of `centre`, in an order
  /// that depends on the points alone.
  template <class Visit>
  void Within(Point centre, double radius_m, Visit&& visit) const {
    if (order_.empty() || !(radius_m >= 0)) return;
    const std::int32_t x0 = Column(centre.x_m - radius_m), x1 = Column(centre.x_m + radius_m);
    const std::int32_t y0 = Row(centre.y_m - radius_m), y1 = Row(centre.y_m + radius_m);
    for (std::int32_t y = y0; y <= y1; ++y) {
      // Cells of one row are neighbours in order_.
      const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_);
      const std::size_t end = begin_[row + static_cast<std::size_t>(x1) + 1];
      for (std::size_t k = begin_[row + static_cast<std::size_t>(x0)]; k < end; ++k) {
        const double distance = Distance(centre, sorted_[k]);
        if (distance <= radius_m) visit(order_[k], sorted_[k], distance);
      }
    }
  }

  /// The least length(index, point, distance), which is never below the distance; infinity when
  /// there is no point. It is asked of points that are no further away than what was found.
  template <class Length>
  double Nearest(Point centre, Length&& length) const {
    double nearest = std::numeric_limits<double>::infinity();
    if (order_.empty()) return nearest;
    const double reach = ReachFrom(centre);
    for (double radius = 1 / per_m_;; radius *= 2) {
      Within(centre, radius, [&](std::int32_t i, Point point, double distance) {
        if (distance <= nearest) nearest = std::min(nearest, length(i, point, distance));
      });
      if (nearest <= radius || radius > reach) break;
    }
    return nearest;
  }

 private:
  /// All points are within it of `centre`.
  double ReachFrom(Point centre) const;
  std::int32_t Column(double x_m) const { return Clamp((x_m - x_m_) * per_m_, columns_); }
  std::int32_t Row(double y_m) const { return Clamp((y_m - y_m_) * per_m_, rows_); }
  static std::int32_t Clamp(double cell, std::int32_t n) {
    return cell <= 0 ? 0 : cell >= n - 1 ? n - 1 : static_cast<std::int32_t>(cell);
  }

  double x_m_ = 0, y_m_ = 0;
  double per_m_ = 0;
  std::int32_t columns_ = 1, rows_ = 1;
  std::vector<std::size_t> begin_;   ///< [rows * columns + 1] into order_
  std::vector<std::int32_t> order_;  ///< point indices by cell, ascending in each
  std::vector<Point> sorted_;        ///< the points in that order
};

}  // namespace muster
