#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/geometry.h"

namespace muster::scheduler {

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

}  // namespace muster::scheduler
