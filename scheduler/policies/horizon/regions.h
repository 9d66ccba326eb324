#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "scheduler/policies/horizon/matching.h"

namespace muster::scheduler {

/// Parts of the area with about as many UAVs each: columns, and each column's rows.
class Regions {
 public:
  /// n columns of n rows each. With `shifted` n + 1 columns of n + 1 rows, of which those at the
  /// edges have half as many UAVs, so that the cuts are elsewhere.
  Regions(const std::vector<Participant>& uavs, std::size_t n, bool shifted);

  std::size_t size() const { return size_; }
  std::size_t Of(Point at) const;
  bool IsNearCut(Point at, double metres) const;

 private:
  std::vector<double> x_m_;               ///< cuts between columns, ascending
  std::vector<std::vector<double>> y_m_;  ///< [columns] cuts between rows, ascending
  std::vector<std::size_t> first_;        ///< [columns] number of the first row's region
  std::size_t size_ = 0;
};

/// HeaviestPairs for a situation that is too large to be matched in one piece. Each of n times n
/// regions is matched on its own. Then what is close to their cuts is matched once more, in shifted
/// regions, and what is left in one piece. If this last step makes many pairs, nothing is returned:
/// so many regions do not suit, for example because some have UAVs and no tasks. Time and memory
/// grow as the number of agents. The weight is a few thousandths below the heaviest. `candidates`,
/// when given, takes the number of pairs that were looked at; what is matched twice counts twice.
/// threads: 1 or 2; the result does not depend on it. Requires at least n UAVs. Source: ours.
std::optional<std::vector<Match>> PairsByRegion(const Situation& situation,
                                                const Participants& participants,
                                                const OpenSites& open,
                                                const HorizonSettings& settings, std::size_t n,
                                                int threads, std::int64_t* candidates);

}  // namespace muster::scheduler
