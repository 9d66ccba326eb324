#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scheduler/certified/levels.h"
#include "world/model/geometry.h"

namespace muster::scheduler {

/// Up to this many places a sum over them is exact: every place is looked at. Beyond it, distant
/// places are taken together by cell. Random_29, the paper's largest setting, has 480 tasks.
inline constexpr std::size_t kExactPlaces = 1024;

/// Sums over many places that depend on where one stands and how fast one is. Places are the open
/// tasks or the charging points with their expected costs, or a class of agents.
///
/// Beyond kExactPlaces places the sums are taken over a tree of cells. SoftmaxMean is then within
/// 1e-3 of its exact value, relative to it (tests/scheduler/expected_costs_test.cc).
class PlaceSums {
 public:
  /// `values` has one entry a place; `exact_up_to` is there for tests.
  PlaceSums(std::span<const Point> places, std::span<const double> values,
            std::size_t exact_up_to = kExactPlaces);

  /// sum_x softmax(-level(x)) * value_x with the level of the way from `from`; 0 without places.
  /// Source: the paper's Eq. 4-9 to 4-17.
  double SoftmaxMean(Point from, const LevelOf& level) const;

 private:
  struct Cell {
    double x_m, y_m;          ///< centroid of its places
    double radius_m;          ///< of the disc around the centroid that holds them
    double value;             ///< sum
    double low, high;         ///< least and greatest value
    std::int32_t begin, end;  ///< its places in the sorted arrays
    std::int32_t skip;        ///< cell to go on with when this one is not opened
  };
  double ExactSoftmaxMean(Point from, const LevelOf& level) const;
  double TreeSoftmaxMean(Point from, const LevelOf& level) const;
  void BuildTree(std::vector<std::int32_t>* order, std::int32_t begin, std::int32_t end,
                 std::span<const Point> places, std::span<const double> values);

  std::vector<double> x_m_, y_m_, value_;  ///< by cell where there is a tree
  std::vector<Cell> cells_;                ///< depth first; empty: exact
};

/// Mean over agents of one speed of the level of their way to `to`; the sum, not yet divided.
class LevelSums {
 public:
  LevelSums(std::span<const Point> agents, const LevelOf& level,
            std::size_t exact_up_to = kExactPlaces);
  double Sum(Point to) const;

 private:
  LevelOf level_;
  std::vector<double> x_m_, y_m_;
  struct Cell {
    double x_m, y_m, radius_m;
    double spread_m2;  ///< mean square distance of its agents from the centroid
    std::int32_t begin, end, skip;
  };
  void BuildTree(std::vector<std::int32_t>* order, std::int32_t begin, std::int32_t end,
                 std::span<const Point> agents);
  std::vector<Cell> cells_;
};

/// Levels from one place to many, into `levels` [n].
void LevelsTo(Point from, std::span<const double> x_m, std::span<const double> y_m,
              const LevelOf& level, std::int32_t* levels);

}  // namespace muster::scheduler
