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
  /// n columns of n rows each, cut where UAVs are; or, with `shifted`, n + 1 of n + 1, where those
  /// at the edges have half as many UAVs, so that few cuts are where the others are.
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

/// HeaviestPairs of a situation that is too large to be matched in one piece. Its n times n regions
/// are matched each on its own, what is close to their cuts once more in shifted regions, and what
/// is left in one piece. Where that is much, nothing is returned: regions do not suit, as where all
/// UAVs start from one place. Time and memory grow as the number of agents; the weight is within a
/// few thousandths of the heaviest. `candidates`, when given, takes the number of pairs that were
/// looked at. The threads, 1 or 2, do not change the result. Source: ours.
/// Requires at least n UAVs.
std::optional<std::vector<Match>> PairsByRegion(const Situation& situation,
                                                const Participants& participants,
                                                const OpenSites& open,
                                                const HorizonSettings& settings, std::size_t n,
                                                int threads, std::int64_t* candidates);

}  // namespace muster::scheduler
