#include "scheduler/certified/expected_costs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace muster::scheduler {
namespace {

constexpr std::int32_t kTable = 64;  // exp(-64) is below any tolerance next to exp(0)

constexpr std::size_t kLeaf = 32;        ///< places of a cell that is not divided
constexpr double kFar = 15;              ///< levels beyond the nearest that do not count any more
constexpr double kCellTolerance = 5e-4;  ///< of the mean, by one cell; errors of cells cancel
constexpr double kManyLevels = 16;       ///< nearer than that, a cell's spread is
constexpr double kFewSpread = 0.05;      ///< at most this, in levels
constexpr double kAngle = 0.15;          ///< radius / distance of cells whose mean level is taken

/// exp(-level), and its integral over a distance that is measured in levels.
struct Softened {
  std::array<double, kTable + 1> exp;
  std::array<double, kTable + 2> sum;  ///< [k] integral from 0 to k of exp(1 - ceil)

  double Integral(double z) const {
    if (z <= 0) return z;  // closer than the nearest: level 1
    const auto k = static_cast<std::size_t>(std::min<double>(z, kTable));
    return sum[k] + (z - static_cast<double>(k)) * exp[k];
  }
};

const Softened& Tables() {
  static const Softened tables = [] {
    Softened t{};
    for (int k = 0; k <= kTable; ++k) {
      const auto at = static_cast<std::size_t>(k);
      t.exp[at] = k < kTable ? std::exp(-k) : 0;
      t.sum[at + 1] = t.sum[at] + t.exp[at];
    }
    return t;
  }();
  return tables;
}

constexpr std::size_t kBlock = 64;

}  // namespace

void LevelsTo(Point from, std::span<const double> x_m, std::span<const double> y_m,
              const LevelOf& level, std::int32_t* levels) {
  const std::size_t n = x_m.size();
  const double per_m = level.per_m(), close = level.close();
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t end = std::min(n, begin + kBlock);
    std::int32_t any = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const double dx = x_m[i] - from.x_m, dy = y_m[i] - from.y_m;
      const double z = std::min(std::sqrt(dx * dx + dy * dy) * per_m, 1e9);
      const auto floor = static_cast<std::int32_t>(z);
      const double rest = z - static_cast<double>(floor);
      const double near = close + z * 1e-14;
      levels[i] = floor + 1;
      any |= (static_cast<std::int32_t>(rest < near) & static_cast<std::int32_t>(z > 0.5)) |
             static_cast<std::int32_t>(rest > 1 - near);
    }
    if (any == 0) continue;
    for (std::size_t i = begin; i < end; ++i) levels[i] = level(Distance(from, {x_m[i], y_m[i]}));
  }
}

PlaceTree::PlaceTree(std::span<const Point> places, std::span<const double> values) {
  std::vector<std::int32_t> order(places.size());
  std::iota(order.begin(), order.end(), 0);
  Build(&order, 0, static_cast<std::int32_t>(order.size()), places, values);
  for (const std::int32_t i : order) {
    x_m_.push_back(places[static_cast<std::size_t>(i)].x_m);
    y_m_.push_back(places[static_cast<std::size_t>(i)].y_m);
    if (!values.empty()) value_.push_back(values[static_cast<std::size_t>(i)]);
  }
}

void PlaceTree::Build(std::vector<std::int32_t>* order, std::int32_t begin, std::int32_t end,
                      std::span<const Point> places, std::span<const double> values) {
  const auto at = [&](std::int32_t k) {
    return places[static_cast<std::size_t>((*order)[static_cast<std::size_t>(k)])];
  };
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
      const double value = values[static_cast<std::size_t>((*order)[static_cast<std::size_t>(k)])];
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
                       const Point p = places[static_cast<std::size_t>(a)];
                       const Point q = places[static_cast<std::size_t>(b)];
                       const double u = by_x ? p.x_m : p.y_m, v = by_x ? q.x_m : q.y_m;
                       return u != v ? u < v : a < b;
                     });
    Build(order, begin, middle, places, values);
    Build(order, middle, end, places, values);
  }
  cells_[self].next = static_cast<std::int32_t>(cells_.size());
}

PlaceSums::PlaceSums(std::span<const Point> places, std::span<const double> values,
                     std::size_t exact_up_to) {
  if (places.size() > exact_up_to) {
    tree_.emplace_back(places, values);
    return;
  }
  for (const Point& p : places) {
    x_m_.push_back(p.x_m);
    y_m_.push_back(p.y_m);
  }
  value_.assign(values.begin(), values.end());
}

double PlaceSums::SoftmaxMean(Point from, const LevelOf& level) const {
  if (!tree_.empty()) return TreeMean(from, level);
  return x_m_.empty() ? 0 : ExactMean(from, level);
}

double PlaceSums::ExactMean(Point from, const LevelOf& level) const {
  const std::size_t n = x_m_.size();
  thread_local std::vector<std::int32_t> levels;
  levels.resize(n);
  LevelsTo(from, x_m_, y_m_, level, levels.data());
  const std::int32_t least = *std::min_element(levels.begin(), levels.end());
  const auto& table = Tables().exp;
  double mass = 0, sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double e = table[static_cast<std::size_t>(std::min(levels[i] - least, kTable))];
    mass += e;
    sum += e * value_[i];
  }
  return sum / mass;
}

double PlaceSums::TreeMean(Point from, const LevelOf& level) const {
  const PlaceTree& tree = tree_.front();
  const std::vector<PlaceTree::Cell>& cells = tree.cells();
  const Softened& tables = Tables();
  // Some place near by: levels are counted from its.
  std::size_t near = 0;
  while (!cells[near].leaf) {
    const std::size_t left = near + 1, right = static_cast<std::size_t>(cells[left].next);
    const auto away = [&](std::size_t c) { return Distance(from, {cells[c].x_m, cells[c].y_m}); };
    near = away(left) <= away(right) ? left : right;
  }
  std::int32_t least = LevelOf::kHighest;
  for (auto i = static_cast<std::size_t>(cells[near].begin);
       i < static_cast<std::size_t>(cells[near].end); ++i) {
    least = std::min(least, level(Distance(from, {tree.x_m()[i], tree.y_m()[i]})));
  }
  const double per_m = level.per_m();
  const auto exp_of = [&](double k) {
    return k < 0 ? std::exp(-std::floor(k))
                 : tables.exp[static_cast<std::size_t>(std::min<double>(k, kTable))];
  };
  double mass = 0, sum = 0;
  const auto traverse = [&](const auto& together) {
    mass = sum = 0;
    for (std::size_t c = 0; c < cells.size();) {
      const PlaceTree::Cell& cell = cells[c];
      const double away = Distance(from, {cell.x_m, cell.y_m});
      const double z = away * per_m - (least - 1), radius = cell.radius_m * per_m;
      if (z - radius > kFar) {
        c = static_cast<std::size_t>(cell.next);
      } else if (cell.radius_m == 0) {
        const double e = exp_of(level(away) - least);
        mass += e * cell.count;
        sum += e * cell.value;
        c = static_cast<std::size_t>(cell.next);
      } else if (together(cell, z, radius)) {
        const double width = cell.width_m * per_m;
        const double e = (tables.Integral(z + width) - tables.Integral(z - width)) / (2 * width);
        mass += e * cell.count;
        sum += e * cell.value;
        c = static_cast<std::size_t>(cell.next);
      } else if (!cell.leaf) {
        ++c;
      } else {
        const auto begin = static_cast<std::size_t>(cell.begin);
        const auto n = static_cast<std::size_t>(cell.end - cell.begin);
        std::array<std::int32_t, kLeaf> levels;
        LevelsTo(from, std::span(tree.x_m()).subspan(begin, n),
                 std::span(tree.y_m()).subspan(begin, n), level, levels.data());
        for (std::size_t i = 0; i < n; ++i) {
          const double e = exp_of(levels[i] - least);
          mass += e;
          sum += e * tree.value()[begin + i];
        }
        c = static_cast<std::size_t>(cell.next);
      }
    }
  };
  // A rough mean first; then a cell is opened when taking its places together may move the mean by
  // more than a share of the tolerance: by its weight's variation times its values' distance from
  // the mean.
  traverse([&](const PlaceTree::Cell&, double z, double radius) { return radius <= 0.3 * z; });
  const double mean = sum / mass;
  const double allowed = kCellTolerance * std::abs(mean) * mass;
  traverse([&](const PlaceTree::Cell& cell, double z, double radius) {
    const double from_z = z - radius;
    if (from_z <= 1e-6) return false;
    if (std::floor(from_z - 1e-6) == std::floor(z + radius + 1e-6)) return true;  // one level
    const double off = std::max(std::abs(cell.high - mean), std::abs(cell.low - mean));
    return exp_of(from_z) * cell.count * std::min(1.0, radius) * off <= allowed;
  });
  return sum / mass;
}

LevelSums::LevelSums(std::span<const Point> agents, const LevelOf& level, std::size_t exact_up_to)
    : level_(level) {
  if (agents.size() > exact_up_to) {
    tree_.emplace_back(agents, std::span<const double>());
    return;
  }
  for (const Point& p : agents) {
    x_m_.push_back(p.x_m);
    y_m_.push_back(p.y_m);
  }
}

double LevelSums::Sum(Point to) const {
  if (tree_.empty()) {
    thread_local std::vector<std::int32_t> levels;
    levels.resize(x_m_.size());
    LevelsTo(to, x_m_, y_m_, level_, levels.data());
    std::int64_t sum = 0;
    for (const std::int32_t k : levels) sum += k;
    return static_cast<double>(sum);
  }
  // Integral of ceil from 0 to x.
  const auto integral = [](double x) {
    const double n = std::floor(x), rest = x - n;
    return n * (n + 1) / 2 + rest * (n + 1);
  };
  const PlaceTree& tree = tree_.front();
  const std::vector<PlaceTree::Cell>& cells = tree.cells();
  const double per_m = level_.per_m();
  double sum = 0;
  for (std::size_t c = 0; c < cells.size();) {
    const PlaceTree::Cell& cell = cells[c];
    const double away = Distance(to, {cell.x_m, cell.y_m});
    if (cell.radius_m > 0 && cell.radius_m <= kAngle * away &&
        (away * per_m > kManyLevels || cell.radius_m * per_m <= kFewSpread)) {
      // Places beside the line of sight are a little farther than the centroid.
      const double z = (away + cell.width_m * cell.width_m / (6 * away)) * per_m;
      const double width = cell.width_m * per_m;
      sum += cell.count * (integral(z + width) - integral(z - width)) / (2 * width);
    } else if (cell.radius_m == 0) {
      sum += cell.count * level_(away);
    } else if (!cell.leaf) {
      ++c;
      continue;
    } else {
      const auto begin = static_cast<std::size_t>(cell.begin);
      const auto n = static_cast<std::size_t>(cell.end - cell.begin);
      std::array<std::int32_t, kLeaf> levels;
      LevelsTo(to, std::span(tree.x_m()).subspan(begin, n), std::span(tree.y_m()).subspan(begin, n),
               level_, levels.data());
      for (std::size_t i = 0; i < n; ++i) sum += levels[i];
    }
    c = static_cast<std::size_t>(cell.next);
  }
  return sum;
}

}  // namespace muster::scheduler
