#pragma once

#include <cstdint>
#include <map>
#include <vector>

namespace muster {

/// A set of integers from 0 on, kept as its runs of consecutive members: memory grows with the
/// number of gaps, not of members.
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
  /// How many members.
  std::int64_t size() const { return size_; }
  /// Everything from 0 up to it is a member.
  std::int64_t next() const {
    const auto first = last_by_first_.find(0);
    return first == last_by_first_.end() ? 0 : first->second + 1;
  }
  /// What is missing in [first, last], ascending.
  std::vector<Range> Missing(std::int64_t first, std::int64_t last) const;

 private:
  std::map<std::int64_t, std::int64_t> last_by_first_;
  std::int64_t size_ = 0;
};

}  // namespace muster
