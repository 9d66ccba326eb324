#include "scheduler/certified/expected_costs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace muster::scheduler {
namespace {

constexpr std::int32_t kTable = 64;  // exp(-64) is below any tolerance next to exp(0)

const std::array<double, kTable + 1>& ExpTable() {
  static const auto table = [] {
    std::array<double, kTable + 1> t{};
    for (int k = 0; k < kTable; ++k) t[static_cast<std::size_t>(k)] = std::exp(-k);
    t[kTable] = 0;
    return t;
  }();
  return table;
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

PlaceSums::PlaceSums(std::span<const Point> places, std::span<const double> values,
                     std::size_t exact_up_to) {
  std::vector<std::int32_t> order(places.size());
  std::iota(order.begin(), order.end(), 0);
  (void)exact_up_to;
  for (const std::int32_t i : order) {
    x_m_.push_back(places[static_cast<std::size_t>(i)].x_m);
    y_m_.push_back(places[static_cast<std::size_t>(i)].y_m);
    value_.push_back(values[static_cast<std::size_t>(i)]);
  }
}

double PlaceSums::SoftmaxMean(Point from, const LevelOf& level) const {
  if (x_m_.empty()) return 0;
  return ExactSoftmaxMean(from, level);
}

double PlaceSums::ExactSoftmaxMean(Point from, const LevelOf& level) const {
  const std::size_t n = x_m_.size();
  thread_local std::vector<std::int32_t> levels;
  levels.resize(n);
  LevelsTo(from, x_m_, y_m_, level, levels.data());
  const std::int32_t least = *std::min_element(levels.begin(), levels.end());
  const auto& table = ExpTable();
  double mass = 0, sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double e = table[static_cast<std::size_t>(std::min(levels[i] - least, kTable))];
    mass += e;
    sum += e * value_[i];
  }
  return sum / mass;
}

LevelSums::LevelSums(std::span<const Point> agents, const LevelOf& level, std::size_t exact_up_to)
    : level_(level) {
  std::vector<std::int32_t> order(agents.size());
  std::iota(order.begin(), order.end(), 0);
  (void)exact_up_to;
  for (const std::int32_t i : order) {
    x_m_.push_back(agents[static_cast<std::size_t>(i)].x_m);
    y_m_.push_back(agents[static_cast<std::size_t>(i)].y_m);
  }
}

double LevelSums::Sum(Point to) const {
  thread_local std::vector<std::int32_t> levels;
  levels.resize(x_m_.size());
  LevelsTo(to, x_m_, y_m_, level_, levels.data());
  std::int64_t sum = 0;
  for (const std::int32_t k : levels) sum += k;
  return static_cast<double>(sum);
}

}  // namespace muster::scheduler
