#pragma once

#include <cstdint>
#include <map>
#include <vector>

namespace muster::tools {

/// A set of integers, kept as its runs of consecutive members: memory grows with the number of
/// gaps, not of members.
class IntervalSet {
 public:
  struct Range {
    std::int64_t first = 0;
    std::int64_t last = 0;
    bool operator==(const Range&) const = default;
  };

  /// False when `value` was in the set already. Logarithmic in the number of runs.
  bool Add(std::int64_t value);
  bool Contains(std::int64_t value) const;
  bool empty() const { return last_by_first_.empty(); }
  /// Largest member; -1 when empty.
  std::int64_t max() const { return empty() ? -1 : last_by_first_.rbegin()->second; }
  /// What is missing in [first, last], ascending.
  std::vector<Range> Missing(std::int64_t first, std::int64_t last) const;

 private:
  std::map<std::int64_t, std::int64_t> last_by_first_;
};

}  // namespace muster::tools
