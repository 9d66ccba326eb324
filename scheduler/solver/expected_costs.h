#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "model/ways.h"
#include "scheduler/solver/levels.h"
#include "scheduler/solver/place_tree.h"

namespace muster::scheduler {

/// Up to this many places a sum over them is exact: every place is looked at. Beyond it, distant
/// places are taken together by cell. Random_29, the paper's largest setting, has 480 tasks.
inline constexpr std::size_t kExactPlaces = 512;
/// Beyond it a weight that is made of such sums is within this of the exact one, relative to that
/// of staying (tests/scheduler/solver/expected_costs_test.cc). One sum is within a hundredth, where
/// not many ways are whole intervals at once (place_sums_test.cc).
inline constexpr double kCostTolerance = 1e-3;

/// Softmax means over places (open tasks, charging points) of their expected costs.
class PlaceSums {
 public:
  /// `values` has one entry a place; `exact_up_to` is there for tests. Where ways are not straight,
  /// every sum is exact.
  PlaceSums(std::span<const Point> places, std::span<const double> values, const WaysOf& ways,
            std::size_t exact_up_to = kExactPlaces);

  /// sum_x softmax(-level(x)) * value_x with the level of the way from each of `from`; 0 without
  /// places. threads: 1 or 2; the result does not depend on it.
  /// Source: the paper's Eq. 4-9 to 4-17.
  std::vector<double> SoftmaxMeans(Queries* from, const LevelOf& level, int threads = 1) const;

 private:
  double ExactMean(const std::vector<std::int32_t>& levels) const;
  void BlockMeans(const Queries& from, const Queries::Block& block, const LevelOf& level,
                  std::vector<double>* means) const;

  WaysOf ways_;
  std::vector<Point> places_;  ///< where ways bend
  std::vector<double> x_m_, y_m_, value_;
  std::vector<PlaceTree> tree_;  ///< one, or none where sums are exact
};

/// Sums of levels over the agents of one speed.
class LevelSums {
 public:
  /// Where ways are not straight, every sum is exact.
  LevelSums(std::span<const Point> agents, const LevelOf& level, const WaysOf& ways,
            std::size_t exact_up_to = kExactPlaces);

  /// Sum over the agents of the level of their way to each of `to`. Source: the paper's Eq. 4-6,
  /// 4-8.
  std::vector<double> Sums(Queries* to, int threads = 1) const;

 private:
  void BlockSums(const Queries& to, const Queries::Block& block, std::vector<double>* sums) const;

  LevelOf level_;
  WaysOf ways_;
  std::vector<Point> agents_;  ///< where ways bend
  std::vector<double> x_m_, y_m_;
  std::vector<PlaceTree> tree_;
};

/// Levels of the straight lines from one place to many, into `levels` [n].
void LevelsTo(Point from, std::span<const double> x_m, std::span<const double> y_m,
              const LevelOf& level, std::int32_t* levels);

}  // namespace muster::scheduler
