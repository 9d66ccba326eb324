#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "scheduler/solver/levels.h"

namespace muster::scheduler {

/// Up to this many places a sum over them is exact: every place is looked at. Beyond it, distant
/// places are taken together by cell. Random_29, the paper's largest setting, has 480 tasks.
inline constexpr std::size_t kExactPlaces = 512;
/// Beyond it a sum is within this of the exact one, relative to it
/// (tests/scheduler/solver/expected_costs_test.cc).
inline constexpr double kCostTolerance = 1e-3;

/// Places in a tree of cells, each with what a sum needs to take its places together.
class PlaceTree {
 public:
  struct Cell {
    double x_m, y_m;          ///< centroid
    double radius_m;          ///< all places are this close to it
    double width_m;           ///< half the width of places evenly spread along a line from afar
    double count, value;      ///< number of places, sum of their values
    double low, high;         ///< least and greatest value
    std::int32_t begin, end;  ///< places, in the tree's order
    std::int32_t next;        ///< cell to go on with when this one is not opened
    bool leaf;
  };

  /// `values` may be empty.
  PlaceTree(std::span<const Point> places, std::span<const double> values);

  const std::vector<Cell>& cells() const { return cells_; }  ///< depth first, root first
  const std::vector<double>& x_m() const { return x_m_; }
  const std::vector<double>& y_m() const { return y_m_; }
  const std::vector<double>& value() const { return value_; }

 private:
  void Build(std::vector<std::int32_t>* order, std::int32_t begin, std::int32_t end,
             std::span<const Point> places, std::span<const double> values);

  std::vector<Cell> cells_;
  std::vector<double> x_m_, y_m_, value_;
};

/// Places that sums are wanted for. Beyond the exact size they are worked on by blocks of
/// neighbours, so that a block looks at the tree once.
class Queries {
 public:
  static constexpr std::int32_t kLanes = 16;
  struct Block {
    Point centre;
    double radius_m;
    std::int32_t begin, end;  ///< of order(), at most kLanes
  };

  explicit Queries(std::vector<Point> at) : at_(std::move(at)) {}
  const std::vector<Point>& at() const { return at_; }
  std::size_t size() const { return at_.size(); }
  /// Finds the blocks; without it there are none.
  void Divide();
  const std::vector<Block>& blocks() const { return blocks_; }
  const std::vector<std::int32_t>& order() const { return order_; }

 private:
  void Divide(std::int32_t begin, std::int32_t end);

  std::vector<Point> at_;
  std::vector<std::int32_t> order_;
  std::vector<Block> blocks_;
};

/// Softmax means over places (open tasks, charging points) of their expected costs.
class PlaceSums {
 public:
  /// `values` has one entry a place; `exact_up_to` is there for tests.
  PlaceSums(std::span<const Point> places, std::span<const double> values,
            std::size_t exact_up_to = kExactPlaces);

  /// sum_x softmax(-level(x)) * value_x with the level of the way from each of `from`; 0 without
  /// places. threads: 1 or 2; the result does not depend on it.
  /// Source: the paper's Eq. 4-9 to 4-17.
  std::vector<double> SoftmaxMeans(Queries* from, const LevelOf& level, int threads = 1) const;

 private:
  double ExactMean(Point from, const LevelOf& level) const;
  void BlockMeans(const Queries& from, const Queries::Block& block, const LevelOf& level,
                  std::vector<double>* means) const;

  std::vector<double> x_m_, y_m_, value_;
  std::vector<PlaceTree> tree_;  ///< one, or none where sums are exact
};

/// Sums of levels over the agents of one speed.
class LevelSums {
 public:
  LevelSums(std::span<const Point> agents, const LevelOf& level,
            std::size_t exact_up_to = kExactPlaces);

  /// Sum over the agents of the level of their way to each of `to`. Source: the paper's Eq. 4-6,
  /// 4-8.
  std::vector<double> Sums(Queries* to, int threads = 1) const;

 private:
  double ExactSum(Point to) const;
  void BlockSums(const Queries& to, const Queries::Block& block, std::vector<double>* sums) const;

  LevelOf level_;
  std::vector<double> x_m_, y_m_;
  std::vector<PlaceTree> tree_;
};

/// Levels from one place to many, into `levels` [n].
void LevelsTo(Point from, std::span<const double> x_m, std::span<const double> y_m,
              const LevelOf& level, std::int32_t* levels);

}  // namespace muster::scheduler
