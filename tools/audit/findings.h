#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace muster::tools::audit {

/// One violation of an invariant that a log shows.
struct Violation {
  std::int64_t at_us = 0;  ///< mission time
  std::string invariant;   ///< a row of docs/reference/audit.md
  std::string text;        ///< ids and values
};

/// The violations of a log; the first thousand are listed.
class Findings {
 public:
  template <class... T>
  void Add(std::int64_t at_us, std::string_view invariant, fmt::format_string<T...> text,
           T&&... values) {
    ++count_;
    if (list_.size() >= 1000) return;
    list_.push_back({at_us, std::string(invariant), fmt::format(text, std::forward<T>(values)...)});
  }
  std::size_t count() const { return count_; }
  /// By mission time.
  const std::vector<Violation>& Sorted() {
    std::stable_sort(list_.begin(), list_.end(),
                     [](const Violation& a, const Violation& b) { return a.at_us < b.at_us; });
    return list_;
  }

 private:
  std::vector<Violation> list_;
  std::size_t count_ = 0;
};

}  // namespace muster::tools::audit
