#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scheduler/solver/packing_lp.h"

namespace muster::scheduler {

/// Sets of columns of a packing of which any two share a row of capacity 1, so that at most one of
/// each set can be used. The linear relaxation may use halves of three: each shares a row with each
/// other, but no row has all three. Source: clique inequalities (Padberg 1973), for three-index
/// assignments Balas and Saltzman 1989; the search is ours.
class Cliques {
 public:
  /// Finds sets of which the program's solution uses more than one column in all; no set twice.
  /// Returns how many it found now.
  std::size_t Find(const PackingLp& lp);

  /// Columns get new numbers: order[k] becomes k.
  void Renumber(std::span<const std::int32_t> order);

  /// Columns of each set, ascending.
  const std::vector<std::vector<std::int32_t>>& all() const { return all_; }
  /// Elementary steps done so far.
  std::int64_t work() const { return work_; }

 private:
  std::vector<std::int32_t> Extended(const PackingLp& lp, std::vector<std::int32_t> members);

  std::vector<std::vector<std::int32_t>> all_;
  std::int64_t work_ = 0;
};

}  // namespace muster::scheduler
