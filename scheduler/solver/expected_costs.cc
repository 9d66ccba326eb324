#include "scheduler/solver/expected_costs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "scheduler/solver/parallel.h"

namespace muster::scheduler {
namespace {

constexpr std::int32_t kTable = 64;  // exp(-64) is below any tolerance next to exp(0)

constexpr std::size_t kLeaf = 16;        ///< places of a cell that is not divided
constexpr double kFar = 9;               ///< levels, and ln(number): the rest does not count
constexpr double kCellTolerance = 4e-4;  ///< of the mean, by one cell; errors of cells cancel
constexpr double kRough = 0.3;           ///< radius / distance of cells for a first mean
constexpr double kAngle = 0.3;           ///< radius / distance of cells whose mean level is taken
constexpr double kNear = 3;              ///< levels within which a cell's is not
constexpr double kWide = 2.5;            ///< radius of a block, in levels, to look at the tree once
/// Distances this close to a whole number of levels, relative to it, count as that.
constexpr double kClose = 2e-6;

constexpr auto kLanes = static_cast<std::size_t>(Queries::kLanes);
constexpr std::size_t kWidth = 4;
constexpr std::size_t kVectors = kLanes / kWidth;
using Vector = float __attribute__((vector_size(4 * kWidth)));
using Mask = std::int32_t __attribute__((vector_size(4 * kWidth)));

Vector All(float x) { return Vector{x, x, x, x}; }
Vector All(double x) { return All(static_cast<float>(x)); }

/// exp(-level).
const std::array<double, kTable + 1>& Exp() {
  static const std::array<double, kTable + 1> table = [] {
    std::array<double, kTable + 1> t{};
    for (int k = 0; k < kTable; ++k) t[static_cast<std::size_t>(k)] = std::exp(-k);
    return t;
  }();
  return table;
}

/// Coordinates of a block's queries from its centre; lanes that are not used repeat the first.
struct Lanes {
  std::array<Vector, kVectors> x, y;

  Lanes(const Queries& queries, const Queries::Block& block) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const auto k = std::min(static_cast<std::size_t>(block.begin) + i,
                              static_cast<std::size_t>(block.end) - 1);
      const Point p = queries.at()[static_cast<std::size_t>(queries.order()[k])];
      x[i / kWidth][i % kWidth] = static_cast<float>(p.x_m - block.centre.x_m);
      y[i / kWidth][i % kWidth] = static_cast<float>(p.y_m - block.centre.y_m);
    }
  }
  Vector Square(std::size_t v, Vector px, Vector py) const {
    const Vector dx = x[v] - px, dy = y[v] - py;
    return dx * dx + dy * dy;
  }
};

/// Calls visit(block), or visit(each query as a block) where a block is too wide for its queries
/// to see the same cells alike.
template <class Visit>
void NarrowBlocks(const Queries& queries, double per_m, int threads, Visit&& visit) {
  const std::vector<Queries::Block>& blocks = queries.blocks();
  ParallelFor(blocks.size(), threads, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      if (blocks[b].radius_m * per_m <= kWide) {
        visit(blocks[b]);
        continue;
      }
      for (std::int32_t k = blocks[b].begin; k < blocks[b].end; ++k) {
        const auto q = static_cast<std::size_t>(queries.order()[static_cast<std::size_t>(k)]);
        visit(Queries::Block{queries.at()[q], 0, k, k + 1});
      }
    }
  });
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

void Queries::Divide() {
  if (!blocks_.empty() || at_.empty()) return;
  order_.resize(at_.size());
  std::iota(order_.begin(), order_.end(), 0);
  Divide(0, static_cast<std::int32_t>(order_.size()));
}

void Queries::Divide(std::int32_t begin, std::int32_t end) {
  const auto at = [&](std::int32_t k) {
    return at_[static_cast<std::size_t>(order_[static_cast<std::size_t>(k)])];
  };
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
                     const Point p = at_[static_cast<std::size_t>(a)];
                     const Point q = at_[static_cast<std::size_t>(b)];
                     const double u = by_x ? p.x_m : p.y_m, v = by_x ? q.x_m : q.y_m;
                     return u != v ? u < v : a < b;
                   });
  Divide(begin, middle);
  Divide(middle, end);
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

std::vector<double> PlaceSums::SoftmaxMeans(Queries* from, const LevelOf& level,
                                            int threads) const {
  std::vector<double> means(from->size(), 0);
  if (!tree_.empty()) {
    from->Divide();
    NarrowBlocks(*from, level.per_m(), threads,
                 [&](const Queries::Block& block) { BlockMeans(*from, block, level, &means); });
  } else if (!x_m_.empty()) {
    ParallelFor(means.size(), threads, 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) means[i] = ExactMean(from->at()[i], level);
    });
  }
  return means;
}

double PlaceSums::ExactMean(Point from, const LevelOf& level) const {
  const std::size_t n = x_m_.size();
  thread_local std::vector<std::int32_t> levels;
  levels.resize(n);
  LevelsTo(from, x_m_, y_m_, level, levels.data());
  const std::int32_t least = *std::min_element(levels.begin(), levels.end());
  const auto& table = Exp();
  double mass = 0, sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double e = table[static_cast<std::size_t>(std::min(levels[i] - least, kTable))];
    mass += e;
    sum += e * value_[i];
  }
  return sum / mass;
}

void PlaceSums::BlockMeans(const Queries& from, const Queries::Block& block, const LevelOf& level,
                           std::vector<double>* means) const {
  const PlaceTree& tree = tree_.front();
  const std::vector<PlaceTree::Cell>& cells = tree.cells();
  const double per_m = level.per_m();
  const auto away = [&](const PlaceTree::Cell& cell) {
    return Distance(block.centre, {cell.x_m, cell.y_m});
  };
  // Some place near by: levels are counted from its.
  std::size_t near = 0;
  while (!cells[near].leaf) {
    const std::size_t left = near + 1, right = static_cast<std::size_t>(cells[left].next);
    near = away(cells[left]) <= away(cells[right]) ? left : right;
  }
  double nearest_m = std::numeric_limits<double>::infinity();
  const auto near_begin = static_cast<std::size_t>(cells[near].begin);
  const auto near_end =
      cells[near].radius_m == 0 ? near_begin + 1 : static_cast<std::size_t>(cells[near].end);
  for (auto i = near_begin; i < near_end; ++i) {
    nearest_m = std::min(nearest_m, Distance(block.centre, {tree.x_m()[i], tree.y_m()[i]}));
  }
  const double nearest = std::floor(nearest_m * per_m);
  const auto& table = Exp();
  // exp(-level) for levels counted from the nearest, which a query of the block may be closer to.
  const auto exp_of = [&](double k) {
    return k < 0 ? std::exp(-k) : table[static_cast<std::size_t>(std::min<double>(k, kTable))];
  };
  const double far = nearest + kFar + std::log(cells[0].count);

  // A rough mean at the centre first: a cell is opened when taking its places together may move
  // the mean by more than a share of the tolerance, by its weight's variation times its values'
  // distance from the mean.
  double rough_mass = 0, rough_sum = 0;
  for (std::size_t c = 0; c < cells.size();) {
    const PlaceTree::Cell& cell = cells[c];
    const double z = away(cell) * per_m, radius = cell.radius_m * per_m;
    if (z - radius > far) {
      c = static_cast<std::size_t>(cell.next);
      continue;
    }
    if (!cell.leaf && radius > kRough * (z - nearest) && radius > kRough) {
      ++c;
      continue;
    }
    const double e = exp_of(std::floor(z - nearest));
    rough_mass += e * cell.count;
    rough_sum += e * cell.value;
    c = static_cast<std::size_t>(cell.next);
  }
  const double mean = rough_sum / rough_mass;
  const double allowed = kCellTolerance * std::abs(mean) * rough_mass;

  const Lanes lanes(from, block);
  const double wide = block.radius_m * per_m;
  double shared_mass = 0, shared_sum = 0;  // the same for all queries
  std::array<Vector, kVectors> mass{}, sum{};
  constexpr std::int32_t kSteps = 16;  // levels that a cell may be spread over
  std::array<Vector, kSteps> bound, slope, drop;
  for (std::size_t c = 0; c < cells.size();) {
    const PlaceTree::Cell& cell = cells[c];
    const double z = away(cell) * per_m, radius = cell.radius_m * per_m;
    const double from_z = z - radius - wide, to_z = z + radius + wide;
    if (from_z > far) {
      c = static_cast<std::size_t>(cell.next);
      continue;
    }
    // Level k covers (k - 1, k], the first one 0 too.
    const double first = std::max(1.0, std::ceil(from_z * (1 - kClose) - kClose));
    const double last = std::max(1.0, std::ceil(to_z * (1 + kClose)));
    const double most = exp_of(first - 1 - nearest);
    if (first == last) {
      shared_mass += most * cell.count;
      shared_sum += most * (cell.value - cell.count * mean);
      c = static_cast<std::size_t>(cell.next);
      continue;
    }
    const double off = std::max(std::abs(cell.high - mean), std::abs(cell.low - mean));
    const bool together = radius > 0 && radius <= kRough * z && last - first <= kSteps &&
                          most * cell.count * std::min(1.0, radius) * off <= allowed;
    if (!together && !cell.leaf) {
      ++c;
      continue;
    }
    c = static_cast<std::size_t>(cell.next);
    const Vector top = All(most);
    if (together) {
      // Places spread evenly over 2 * width along the line of sight, of which a share lies beyond
      // the end k of a level: 1/2 + (z - k) / (2 * width), with (z^2 - k^2) / (2 k) for z - k.
      const double width = cell.width_m * per_m;
      std::size_t steps = 0;
      for (double k = first; k < last; ++k) {
        slope[steps] = All(per_m * per_m / (4 * k * width));
        bound[steps] = All(0.5 - k / (4 * width));
        drop[steps++] = All(exp_of(k - 1 - nearest) - exp_of(k - nearest));
      }
      const Vector px = All(cell.x_m - block.centre.x_m), py = All(cell.y_m - block.centre.y_m);
      const Vector count = All(cell.count), value = All(cell.value - cell.count * mean);
      const Vector zero = All(0.0), one = All(1.0);
      for (std::size_t v = 0; v < kVectors; ++v) {
        const Vector square = lanes.Square(v, px, py);
        Vector e = top;
        for (std::size_t k = 0; k < steps; ++k) {
          Vector share = square * slope[k] + bound[k];
          share = share > zero ? share : zero;
          share = share < one ? share : one;
          e -= share * drop[k];
        }
        mass[v] += e * count;
        sum[v] += e * value;
      }
      continue;
    }
    // Places one by one, all alike where they are at one spot; as many levels at a time as fit.
    const bool spot = cell.radius_m == 0;
    const auto begin = static_cast<std::size_t>(cell.begin);
    const auto end = spot ? begin + 1 : static_cast<std::size_t>(cell.end);
    std::size_t steps = 0;
    for (double k = first; k < std::min(last, first + kSteps); ++k) {
      const double end_m = k / per_m * (1 + kClose);
      bound[steps] = All(end_m * end_m);
      drop[steps++] = All(exp_of(k - 1 - nearest) - exp_of(k - nearest));
    }
    for (std::size_t i = begin; i < end; ++i) {
      const Vector px = All(tree.x_m()[i] - block.centre.x_m);
      const Vector py = All(tree.y_m()[i] - block.centre.y_m);
      const Vector count = All(spot ? cell.count : 1.0);
      const Vector value = All(spot ? cell.value - cell.count * mean : tree.value()[i] - mean);
      for (std::size_t v = 0; v < kVectors; ++v) {
        const Vector square = lanes.Square(v, px, py);
        Vector e = top;
        for (std::size_t k = 0; k < steps; ++k) {
          e -= reinterpret_cast<Vector>(reinterpret_cast<Mask>(drop[k]) & (square > bound[k]));
        }
        mass[v] += e * count;
        sum[v] += e * value;
      }
    }
  }
  for (auto k = static_cast<std::size_t>(block.begin); k < static_cast<std::size_t>(block.end);
       ++k) {
    const std::size_t i = k - static_cast<std::size_t>(block.begin);
    const double m = shared_mass + static_cast<double>(mass[i / kWidth][i % kWidth]);
    const double s = shared_sum + static_cast<double>(sum[i / kWidth][i % kWidth]);
    (*means)[static_cast<std::size_t>(from.order()[k])] = mean + s / m;
  }
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

std::vector<double> LevelSums::Sums(Queries* to, int threads) const {
  std::vector<double> sums(to->size(), 0);
  if (!tree_.empty()) {
    to->Divide();
    NarrowBlocks(*to, level_.per_m(), threads,
                 [&](const Queries::Block& block) { BlockSums(*to, block, &sums); });
  } else if (!x_m_.empty()) {
    ParallelFor(sums.size(), threads, 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) sums[i] = ExactSum(to->at()[i]);
    });
  }
  return sums;
}

double LevelSums::ExactSum(Point to) const {
  thread_local std::vector<std::int32_t> levels;
  levels.resize(x_m_.size());
  LevelsTo(to, x_m_, y_m_, level_, levels.data());
  std::int64_t sum = 0;
  for (const std::int32_t k : levels) sum += k;
  return static_cast<double>(sum);
}

void LevelSums::BlockSums(const Queries& to, const Queries::Block& block,
                          std::vector<double>* sums) const {
  const PlaceTree& tree = tree_.front();
  const std::vector<PlaceTree::Cell>& cells = tree.cells();
  const double per_m = level_.per_m();
  const Lanes lanes(to, block);
  const double wide = block.radius_m * per_m;
  double shared = 0;
  std::array<Vector, kVectors> sum{};
  const Vector scale = All(per_m * (1 - kClose));
  const auto whole = [](Vector x) {  // floor of what is not negative
    return __builtin_convertvector(__builtin_convertvector(x, Mask), Vector);
  };
  const auto root = [](Vector square) {
    for (std::size_t k = 0; k < kWidth; ++k) square[k] = std::sqrt(square[k]);
    return square;
  };
  for (std::size_t c = 0; c < cells.size();) {
    const PlaceTree::Cell& cell = cells[c];
    const double away = Distance(block.centre, {cell.x_m, cell.y_m});
    const double z = away * per_m, radius = cell.radius_m * per_m;
    const double least = z - radius - wide;
    if (radius > 0 && least > kNear && radius <= kAngle * (z - wide)) {
      c = static_cast<std::size_t>(cell.next);
      // Places beside the line of sight are a little farther than the centroid. The mean of the
      // level over 2 * width, by the integral of the level from 0 to x.
      const Vector px = All(cell.x_m - block.centre.x_m), py = All(cell.y_m - block.centre.y_m);
      const double width = cell.width_m * per_m;
      const Vector w = All(width), beside = All(width * width / (6 * z));
      const Vector factor = All(cell.count / (2 * width));
      const auto integral = [&](Vector x) {
        const Vector n = whole(x);
        return (n + 1) * (x - n / 2);
      };
      for (std::size_t v = 0; v < kVectors; ++v) {
        const Vector at = root(lanes.Square(v, px, py)) * scale + beside;
        sum[v] += (integral(at + w) - integral(at - w)) * factor;
      }
      continue;
    }
    const double first = std::max(1.0, std::ceil(least - kClose));
    if (first == std::max(1.0, std::ceil((z + radius + wide) * (1 + kClose)))) {
      shared += cell.count * first;
      c = static_cast<std::size_t>(cell.next);
      continue;
    }
    if (!cell.leaf) {
      ++c;
      continue;
    }
    c = static_cast<std::size_t>(cell.next);
    const bool spot = cell.radius_m == 0;
    const auto begin = static_cast<std::size_t>(cell.begin);
    const auto end = spot ? begin + 1 : static_cast<std::size_t>(cell.end);
    const Vector count = All(spot ? cell.count : 1.0);
    for (std::size_t i = begin; i < end; ++i) {
      const Vector px = All(tree.x_m()[i] - block.centre.x_m);
      const Vector py = All(tree.y_m()[i] - block.centre.y_m);
      for (std::size_t v = 0; v < kVectors; ++v) {
        sum[v] += (whole(root(lanes.Square(v, px, py)) * scale) + 1) * count;
      }
    }
  }
  for (auto k = static_cast<std::size_t>(block.begin); k < static_cast<std::size_t>(block.end);
       ++k) {
    const std::size_t i = k - static_cast<std::size_t>(block.begin);
    (*sums)[static_cast<std::size_t>(to.order()[k])] =
        shared + static_cast<double>(sum[i / kWidth][i % kWidth]);
  }
}

}  // namespace muster::scheduler
