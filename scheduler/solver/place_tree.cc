#include "scheduler/solver/place_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/index.h"

namespace muster::scheduler {
namespace {

constexpr std::size_t kLeaf = 16;  ///< places of a cell that is not divided

}  // namespace

PlaceTree::PlaceTree(std::span<const Point> places, std::span<const double> values) {
  std::vector<std::int32_t> order(places.size());
  std::iota(order.begin(), order.end(), 0);
  Build(&order, 0, static_cast<std::int32_t>(order.size()), places, values);
  for (const std::int32_t i : order) {
    x_m_.push_back(places[At(i)].x_m);
    y_m_.push_back(places[At(i)].y_m);
    if (!values.empty()) value_.push_back(values[At(i)]);
  }
}

void PlaceTree::Build(std::vector<std::int32_t>* order, std::int32_t begin, std::int32_t end,
                      std::span<const Point> places, std::span<const double> values) {
  const auto at = [&](std::int32_t k) { return places[At((*order)[At(k)])]; };
  Cell cell{};
  cell.begin = begin;
  cell.end = end;
  cell.count = end - begin;
  Point low = at(begin), high = at(begin);
  for (std::int32_t k = begin; k < end; ++k) {
    const Point p = at(k);
    cell.x_m += p.x_m;
    cell.y_m += p.y_m;
    low = {std::min(low.x_m, p.x_m), std::min(low.y_m, p.y_m)};
    high = {std::max(high.x_m, p.x_m), std::max(high.y_m, p.y_m)};
    if (!values.empty()) {
      const double value = values[At((*order)[At(k)])];
      cell.value += value;
      cell.low = k == begin ? value : std::min(cell.low, value);
      cell.high = k == begin ? value : std::max(cell.high, value);
    }
  }
  cell.x_m /= cell.count;
  cell.y_m /= cell.count;
  double spread_m2 = 0;
  for (std::int32_t k = begin; k < end; ++k) {
    const double d = Distance({cell.x_m, cell.y_m}, at(k));
    cell.radius_m = std::max(cell.radius_m, d);
    spread_m2 += d * d / cell.count;
  }
  // Half of the variance lies along the line of sight; an even spread of half width w has w^2 / 3.
  cell.width_m = std::min(cell.radius_m, std::sqrt(1.5 * spread_m2));
  cell.leaf = end - begin <= static_cast<std::int32_t>(kLeaf) || cell.radius_m == 0;
  const std::size_t self = cells_.size();
  cells_.push_back(cell);
  if (!cell.leaf) {
    const bool by_x = high.x_m - low.x_m >= high.y_m - low.y_m;
    const std::int32_t middle = begin + (end - begin) / 2;
    std::nth_element(order->begin() + begin, order->begin() + middle, order->begin() + end,
                     [&](std::int32_t a, std::int32_t b) {
                       const Point p = places[At(a)];
                       const Point q = places[At(b)];
                       const double u = by_x ? p.x_m : p.y_m, v = by_x ? q.x_m : q.y_m;
                       return u != v ? u < v : a < b;
                     });
    Build(order, begin, middle, places, values);
    Build(order, middle, end, places, values);
  }
  cells_[self].next = static_cast<std::int32_t>(cells_.size());
}

void Queries::Divide() {
  if (!blocks_.empty() || at_.empty()) return;
  order_.resize(at_.size());
  std::iota(order_.begin(), order_.end(), 0);
  Divide(0, static_cast<std::int32_t>(order_.size()));
}

void Queries::Divide(std::int32_t begin, std::int32_t end) {
  const auto at = [&](std::int32_t k) { return at_[At(order_[At(k)])]; };
  Point low = at(begin), high = at(begin);
  for (std::int32_t k = begin; k < end; ++k) {
    const Point p = at(k);
    low = {std::min(low.x_m, p.x_m), std::min(low.y_m, p.y_m)};
    high = {std::max(high.x_m, p.x_m), std::max(high.y_m, p.y_m)};
  }
  if (end - begin <= kLanes) {
    const Point centre = {(low.x_m + high.x_m) / 2, (low.y_m + high.y_m) / 2};
    double radius_m = 0;
    for (std::int32_t k = begin; k < end; ++k) {
      radius_m = std::max(radius_m, Distance(centre, at(k)));
    }
    blocks_.push_back({centre, radius_m, begin, end});
    return;
  }
  const bool by_x = high.x_m - low.x_m >= high.y_m - low.y_m;
  // All blocks but the last are full.
  const std::int32_t blocks = (end - begin + kLanes - 1) / kLanes;
  const std::int32_t middle = begin + blocks / 2 * kLanes;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::int32_t a, std::int32_t b) {
                     const Point p = at_[At(a)];
                     const Point q = at_[At(b)];
                     const double u = by_x ? p.x_m : p.y_m, v = by_x ? q.x_m : q.y_m;
                     return u != v ? u < v : a < b;
                   });
  Divide(begin, middle);
  Divide(middle, end);
}

}  // namespace muster::scheduler
