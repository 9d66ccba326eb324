#include "base/grid_index.h"

namespace muster {

GridIndex::GridIndex(std::span<const Point> points, double per_cell) {
  if (points.empty()) {
    begin_.assign(2, 0);
    return;
  }
  double x1 = points[0].x_m, y1 = points[0].y_m;
  x_m_ = x1;
  y_m_ = y1;
  for (const Point& p : points) {
    x_m_ = std::min(x_m_, p.x_m);
    y_m_ = std::min(y_m_, p.y_m);
    x1 = std::max(x1, p.x_m);
    y1 = std::max(y1, p.y_m);
  }
  const double width = x1 - x_m_, height = y1 - y_m_;
  const double cells = std::max(1.0, static_cast<double>(points.size()) / per_cell);
  // Square cells; a row of points (no height) is cut along its length alone.
  const double side =
      std::max({std::sqrt(width * height / cells), std::max(width, height) / cells, 1e-9});
  per_m_ = 1 / side;
  columns_ = static_cast<std::int32_t>(width * per_m_) + 1;
  rows_ = static_cast<std::int32_t>(height * per_m_) + 1;

  const std::size_t n_cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  begin_.assign(n_cells + 1, 0);
  std::vector<std::size_t> cell(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    cell[i] = static_cast<std::size_t>(Row(points[i].y_m)) * static_cast<std::size_t>(columns_) +
              static_cast<std::size_t>(Column(points[i].x_m));
    ++begin_[cell[i] + 1];
  }
  for (std::size_t c = 0; c < n_cells; ++c) begin_[c + 1] += begin_[c];
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  order_.resize(points.size());
  sorted_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t at = next[cell[i]]++;
    order_[at] = static_cast<std::int32_t>(i);
    sorted_[at] = points[i];
  }
}

double GridIndex::ReachFrom(Point centre) const {
  const double side = 1 / per_m_;
  return std::hypot(columns_ * side, rows_ * side) +
         std::hypot(centre.x_m - x_m_, centre.y_m - y_m_) + side;
}

}  // namespace muster
