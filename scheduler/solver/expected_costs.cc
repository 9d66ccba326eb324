#include "scheduler/solver/expected_costs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/index.h"
#include "scheduler/solver/parallel.h"

namespace muster::scheduler {
namespace {

constexpr std::int32_t kTable = 64;  // exp(-64) is below any tolerance next to exp(0)

constexpr double kFarAway = 9;           ///< levels, and ln(number): the rest does not count
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
    for (int k = 0; k < kTable; ++k) t[At(k)] = std::exp(-k);
    return t;
  }();
  return table;
}

/// Coordinates of a block's queries from its centre; lanes that are not used repeat the first.
struct Lanes {
  std::array<Vector, kVectors> x, y;

  Lanes(const Queries& queries, const Queries::Block& block) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const auto k = std::min(At(block.begin) + i, At(block.end) - 1);
      const Point p = queries.at()[At(queries.order()[k])];
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
        const auto q = At(queries.order()[At(k)]);
        visit(Queries::Block{queries.at()[q], 0, k, k + 1});
      }
    }
  });
}

double Away(Point from, const PlaceTree::Cell& cell) {
  return Distance(from, {cell.x_m, cell.y_m});
}

/// Metres to some place near by, not always the nearest.
double NearbyPlace(const PlaceTree& tree, Point from) {
  const std::vector<PlaceTree::Cell>& cells = tree.cells();
  std::size_t near = 0;
  while (!cells[near].leaf) {
    const std::size_t left = near + 1, right = At(cells[left].next);
    near = Away(from, cells[left]) <= Away(from, cells[right]) ? left : right;
  }
  const PlaceTree::Cell& cell = cells[near];
  const auto begin = At(cell.begin);
  const auto end = cell.radius_m == 0 ? begin + 1 : At(cell.end);
  double nearest_m = std::numeric_limits<double>::infinity();
  for (auto i = begin; i < end; ++i) {
    nearest_m = std::min(nearest_m, Distance(from, {tree.x_m()[i], tree.y_m()[i]}));
  }
  return nearest_m;
}

/// exp(nearest - level): levels are counted from a place near by, which others may be closer than.
struct ExpOf {
  double nearest;
  double operator()(double level) const {
    const double k = level - nearest;
    return k < 0 ? std::exp(-k) : Exp()[static_cast<std::size_t>(std::min<double>(k, kTable))];
  }
};

/// A block's softmax mean and its mass, roughly. A cell is opened later when taking its places
/// together may move the mean by more than a share of the tolerance, by its weight's variation
/// times its values' distance from the mean.
struct RoughMean {
  double mean, mass = 0;

  RoughMean(const PlaceTree& tree, Point centre, double per_m, const ExpOf& exp_of, double far) {
    const std::vector<PlaceTree::Cell>& cells = tree.cells();
    double sum = 0;
    for (std::size_t c = 0; c < cells.size();) {
      const PlaceTree::Cell& cell = cells[c];
      const double z = Away(centre, cell) * per_m, radius = cell.radius_m * per_m;
      if (z - radius > far) {
        c = At(cell.next);
        continue;
      }
      if (!cell.leaf && radius > kRough * (z - exp_of.nearest) && radius > kRough) {
        ++c;
        continue;
      }
      const double e = exp_of(exp_of.nearest + std::floor(z - exp_of.nearest));
      mass += e * cell.count;
      sum += e * cell.value;
      c = At(cell.next);
    }
    mean = sum / mass;
  }
};

constexpr std::int32_t kSteps = 16;  ///< levels that a cell may be spread over

/// Softmax sums of a block's queries: masses, and values from a mean, times masses.
struct BlockSum {
  const Lanes lanes;
  const PlaceTree& tree;
  const Point centre;
  const double per_m;
  const ExpOf exp_of;
  const double mean;
  std::array<Vector, kVectors> mass{}, sum{};

  /// Places spread evenly over 2 * width along the line of sight, of which a share lies beyond the
  /// end k of a level: 1/2 + (z - k) / (2 * width), with (z^2 - k^2) / (2 k) for z - k.
  void AddTogether(const PlaceTree::Cell& cell, double first, double last) {
    std::array<Vector, kSteps> bound, slope, drop;
    const double width = cell.width_m * per_m;
    std::size_t steps = 0;
    for (double k = first; k < last; ++k) {
      slope[steps] = All(per_m * per_m / (4 * k * width));
      bound[steps] = All(0.5 - k / (4 * width));
      drop[steps++] = All(exp_of(k - 1) - exp_of(k));
    }
    const Vector px = All(cell.x_m - centre.x_m), py = All(cell.y_m - centre.y_m);
    const Vector count = All(cell.count), value = All(cell.value - cell.count * mean);
    const Vector zero = All(0.0), one = All(1.0), top = All(exp_of(first - 1));
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
  }

  /// Places one by one, all alike where they are at one spot; as many levels at a time as fit.
  void AddPlaces(const PlaceTree::Cell& cell, double first, double last) {
    std::array<Vector, kSteps> bound, drop;
    const bool spot = cell.radius_m == 0;
    const auto begin = At(cell.begin);
    const auto end = spot ? begin + 1 : At(cell.end);
    std::size_t steps = 0;
    for (double k = first; k < std::min(last, first + kSteps); ++k) {
      const double end_m = k / per_m * (1 + kClose);
      bound[steps] = All(end_m * end_m);
      drop[steps++] = All(exp_of(k - 1) - exp_of(k));
    }
    const Vector top = All(exp_of(first - 1));
    for (std::size_t i = begin; i < end; ++i) {
      const Vector px = All(tree.x_m()[i] - centre.x_m);
      const Vector py = All(tree.y_m()[i] - centre.y_m);
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
};

constexpr std::size_t kBlock = 64;
constexpr std::size_t kAtOnce = 64;  ///< places whose ways are asked for together

/// [from * to]; empty where ways are straight.
std::vector<double> LengthsOf(const WaysOf& ways, std::span<const Point> from,
                              std::span<const Point> to) {
  if (ways.straight()) return {};
  std::vector<double> lengths_m(from.size() * to.size());
  ways.ways->Lengths(ways.kind, from, to, lengths_m);
  return lengths_m;
}

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

PlaceSums::PlaceSums(std::span<const Point> places, std::span<const double> values,
                     const WaysOf& ways, std::size_t exact_up_to)
    : ways_(ways) {
  if (ways.straight() && places.size() > exact_up_to) {
    tree_.emplace_back(places, values);
    return;
  }
  if (!ways.straight()) places_.assign(places.begin(), places.end());
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
    ParallelFor(means.size(), threads, kAtOnce, [&](std::size_t begin, std::size_t end) {
      const std::size_t n = x_m_.size();
      std::vector<std::int32_t> levels(n);
      for (std::size_t first = begin; first < end; first += kAtOnce) {
        const std::span some = std::span(from->at()).subspan(first, std::min(kAtOnce, end - first));
        const std::vector<double> lengths_m = LengthsOf(ways_, some, places_);
        for (std::size_t i = 0; i < some.size(); ++i) {
          if (ways_.straight()) {
            LevelsTo(some[i], x_m_, y_m_, level, levels.data());
          } else {
            for (std::size_t k = 0; k < n; ++k) levels[k] = level(lengths_m[i * n + k]);
          }
          means[first + i] = ExactMean(levels);
        }
      }
    });
  }
  return means;
}

double PlaceSums::ExactMean(const std::vector<std::int32_t>& levels) const {
  const std::size_t n = levels.size();
  const std::int32_t least = *std::min_element(levels.begin(), levels.end());
  const auto& table = Exp();
  double mass = 0, sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double e = table[At(std::min(levels[i] - least, kTable))];
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
  const ExpOf exp_of{std::floor(NearbyPlace(tree, block.centre) * per_m)};
  const double far = exp_of.nearest + kFarAway + std::log(cells[0].count);
  const RoughMean rough(tree, block.centre, per_m, exp_of, far);
  const double mean = rough.mean;
  const double allowed = kCellTolerance * std::abs(mean) * rough.mass;

  BlockSum sum{Lanes(from, block), tree, block.centre, per_m, exp_of, mean};
  const double wide = block.radius_m * per_m;
  double shared_mass = 0, shared_sum = 0;  // the same for all queries
  for (std::size_t c = 0; c < cells.size();) {
    const PlaceTree::Cell& cell = cells[c];
    const double z = Away(block.centre, cell) * per_m, radius = cell.radius_m * per_m;
    const double from_z = z - radius - wide, to_z = z + radius + wide;
    if (from_z > far) {
      c = At(cell.next);
      continue;
    }
    // Level k covers (k - 1, k], the first one 0 too.
    const double first = std::max(1.0, std::ceil(from_z * (1 - kClose) - kClose));
    const double last = std::max(1.0, std::ceil(to_z * (1 + kClose)));
    const double most = exp_of(first - 1);
    if (first == last) {
      shared_mass += most * cell.count;
      shared_sum += most * (cell.value - cell.count * mean);
      c = At(cell.next);
      continue;
    }
    const double off = std::max(std::abs(cell.high - mean), std::abs(cell.low - mean));
    const bool together = radius > 0 && radius <= kRough * z && last - first <= kSteps &&
                          most * cell.count * std::min(1.0, radius) * off <= allowed;
    if (!together && !cell.leaf) {
      ++c;
      continue;
    }
    c = At(cell.next);
    if (together) {
      sum.AddTogether(cell, first, last);
    } else {
      sum.AddPlaces(cell, first, last);
    }
  }
  for (auto k = At(block.begin); k < At(block.end); ++k) {
    const std::size_t i = k - At(block.begin);
    const double m = shared_mass + static_cast<double>(sum.mass[i / kWidth][i % kWidth]);
    const double s = shared_sum + static_cast<double>(sum.sum[i / kWidth][i % kWidth]);
    (*means)[At(from.order()[k])] = mean + s / m;
  }
}

LevelSums::LevelSums(std::span<const Point> agents, const LevelOf& level, const WaysOf& ways,
                     std::size_t exact_up_to)
    : level_(level), ways_(ways) {
  if (ways.straight() && agents.size() > exact_up_to) {
    tree_.emplace_back(agents, std::span<const double>());
    return;
  }
  if (!ways.straight()) agents_.assign(agents.begin(), agents.end());
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
    ParallelFor(sums.size(), threads, kAtOnce, [&](std::size_t begin, std::size_t end) {
      const std::size_t n = x_m_.size();
      std::vector<std::int32_t> levels(n);
      for (std::size_t first = begin; first < end; first += kAtOnce) {
        const std::span some = std::span(to->at()).subspan(first, std::min(kAtOnce, end - first));
        const std::vector<double> lengths_m = LengthsOf(ways_, agents_, some);
        for (std::size_t i = 0; i < some.size(); ++i) {
          if (ways_.straight()) {
            LevelsTo(some[i], x_m_, y_m_, level_, levels.data());
          } else {
            for (std::size_t k = 0; k < n; ++k) levels[k] = level_(lengths_m[k * some.size() + i]);
          }
          sums[first + i] =
              static_cast<double>(std::accumulate(levels.begin(), levels.end(), std::int64_t{0}));
        }
      }
    });
  }
  return sums;
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
      c = At(cell.next);
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
      c = At(cell.next);
      continue;
    }
    if (!cell.leaf) {
      ++c;
      continue;
    }
    c = At(cell.next);
    const bool spot = cell.radius_m == 0;
    const auto begin = At(cell.begin);
    const auto end = spot ? begin + 1 : At(cell.end);
    const Vector count = All(spot ? cell.count : 1.0);
    for (std::size_t i = begin; i < end; ++i) {
      const Vector px = All(tree.x_m()[i] - block.centre.x_m);
      const Vector py = All(tree.y_m()[i] - block.centre.y_m);
      for (std::size_t v = 0; v < kVectors; ++v) {
        sum[v] += (whole(root(lanes.Square(v, px, py)) * scale) + 1) * count;
      }
    }
  }
  for (auto k = At(block.begin); k < At(block.end); ++k) {
    const std::size_t i = k - At(block.begin);
    (*sums)[At(to.order()[k])] = shared + static_cast<double>(sum[i / kWidth][i % kWidth]);
  }
}

}  // namespace muster::scheduler
