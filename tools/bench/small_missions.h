#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/bench/suites.h"

namespace muster::tools {

/// A small mission by one policy, beside what could be done at all.
struct SmallRow {
  std::uint64_t seed = 0;
  int uavs = 0, workers = 0, vehicles = 0, tasks = 0;
  int interval_min = 0, limit_min = 0;
  bool is_strict = true;
  std::string policy;
  std::int64_t done = 0;   ///< tasks
  std::int64_t best = 0;   ///< of the best plan that is known
  std::int64_t bound = 0;  ///< no plan does more

  /// Whether nothing better than the best plan can be.
  bool is_proven() const { return best == bound; }
};

/// Missions of up to 8 UAVs whose size, interval, time limit and mode are drawn by the seed, each
/// by each policy; of the options: methods, seeds. The best plan is that of a policy or of
/// LookBack() on the last one's mission; the bound is the smaller one of UpperBound() and
/// ScheduleBound(). Throws SystemError without Clp's library.
void RunSmallMissions(const BenchOptions& options,
                      const std::function<void(const SmallRow&)>& report);
/// What they are drawn from, for a person.
std::string SmallMissionsLimits();

std::string SmallCsvHeader();
std::string ToCsv(const SmallRow& row);
/// For a person: by policy, and how many missions are proven.
std::string SummaryOf(const std::vector<SmallRow>& rows);

}  // namespace muster::tools
