#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "base/geometry.h"

namespace muster::scheduler {

/// Sums of the straight ways from the centres of an area's cells to many targets. The sum of one
/// cell takes as many square roots as there are targets; bounds of it are found for a block of
/// cells at once. There the ways to targets that are far from the block are developed into a Taylor
/// polynomial of third degree around the block's centre, and only those to near targets are summed
/// one by one. Source: ours; the bound of what the polynomial leaves out follows from the
/// generating function of the Gegenbauer polynomials.
class DistanceSums {
 public:
  /// `targets` must outlive this. Cell centres are at ((column + 1/2), (row + 1/2)) * cell_m.
  DistanceSums(const std::vector<Point>& targets, double cell_m)
      : targets_(targets), cell_m_(cell_m) {}

  struct Bounds {
    double least, most;  ///< metres
  };
  /// What the sum of the cell lies between.
  Bounds BoundsOf(int column, int row);

 private:
  static constexpr int kSide = 16;                      ///< cells along a block
  static constexpr double kMiddle = (kSide - 1) / 2.0;  ///< the cell there, between two of them
  struct Block {
    std::vector<double> sum;  ///< [kSide * kSide] row by row
    double left_out;          ///< at most, per fourth power of the way from the block's centre
    double rounding;          ///< of each sum, at most
  };
  Block MakeBlock(int column, int row) const;

  const std::vector<Point>& targets_;
  double cell_m_;
  std::unordered_map<std::int64_t, Block> blocks_;
  std::int64_t last_key_ = -1;
  const Block* last_ = nullptr;
};

}  // namespace muster::scheduler
