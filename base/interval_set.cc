#include "base/interval_set.h"

#include <algorithm>
#include <iterator>

namespace muster {

bool IntervalSet::Add(std::int64_t value) {
  auto next = last_by_first_.upper_bound(value);
  if (next != last_by_first_.begin()) {
    const auto before = std::prev(next);
    if (value <= before->second) return false;
    if (before->second + 1 == value) {
      before->second = value;
      ++size_;
      if (next != last_by_first_.end() && next->first - 1 == value) {
        before->second = next->second;
        last_by_first_.erase(next);
      }
      return true;
    }
  }
  std::int64_t last = value;
  if (next != last_by_first_.end() && next->first - 1 == value) {
    last = next->second;
    next = last_by_first_.erase(next);
  }
  last_by_first_.emplace_hint(next, value, last);
  ++size_;
  return true;
}

bool IntervalSet::Contains(std::int64_t value) const {
  const auto next = last_by_first_.upper_bound(value);
  return next != last_by_first_.begin() && value <= std::prev(next)->second;
}

std::vector<IntervalSet::Range> IntervalSet::Missing(std::int64_t first, std::int64_t last) const {
  std::vector<Range> missing;
  for (const auto& [run_first, run_last] : last_by_first_) {
    if (run_last < first) continue;
    if (run_first > last) break;
    if (run_first > first) missing.push_back({first, run_first - 1});
    if (run_last >= last) return missing;
    first = run_last + 1;
  }
  if (first <= last) missing.push_back({first, last});
  return missing;
}

}  // namespace muster
