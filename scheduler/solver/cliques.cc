#include "scheduler/solver/cliques.h"

#include <algorithm>
#include <span>
#include <tuple>
#include <utility>

#include "base/index.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;

constexpr double kUsed = 1e-3;              ///< a value that counts
constexpr double kViolated = 1.01;          ///< a sum of values that does
constexpr std::size_t kPerRound = 200;      ///< sets that one search returns
constexpr int kPerColumn = 2;               ///< of which each column that is used may be in so many
constexpr std::size_t kUsedColumns = 3000;  ///< with more, no search

bool Has(const PackingLp& lp, Index column, Index row) {
  const auto& rows = lp.rows(column);
  return rows[0] == row || rows[1] == row || rows[2] == row;
}

/// Whether the two share a row of capacity 1.
bool Conflict(const PackingLp& lp, Index a, Index b) {
  return std::ranges::any_of(
      lp.rows(a), [&](Index row) { return row >= 0 && lp.capacity(row) == 1 && Has(lp, b, row); });
}

}  // namespace

/// The set with every column that shares a row with each of its members, the more used first.
std::vector<Index> Cliques::Extended(const PackingLp& lp, std::vector<Index> members) {
  const auto meets_all = [&](Index k) {
    return std::ranges::all_of(members, [&](Index m) { return m != k && Conflict(lp, m, k); });
  };
  std::vector<std::pair<double, Index>> others;
  for (const Index row : lp.rows(members[0])) {
    if (row < 0 || lp.capacity(row) != 1) continue;
    for (const Index k : lp.columns_at(row)) {
      if (meets_all(k)) others.emplace_back(-lp.value(k), k);
    }
    work_ += static_cast<std::int64_t>(8 * lp.columns_at(row).size());
  }
  std::ranges::sort(others);
  for (const auto& other : others) {
    if (meets_all(other.second)) members.push_back(other.second);
    work_ += static_cast<std::int64_t>(4 * members.size());
  }
  std::ranges::sort(members);
  return members;
}

void Cliques::Renumber(std::span<const Index> order) {
  std::vector<Index> number(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) number[At(order[k])] = static_cast<Index>(k);
  for (std::vector<Index>& set : all_) {
    for (Index& k : set) k = number[At(k)];
    std::ranges::sort(set);
  }
}

std::size_t Cliques::Find(const PackingLp& lp) {
  std::vector<Index> used;
  for (Index k = 0; k < lp.n_columns(); ++k) {
    if (lp.value(k) > kUsed && lp.value(k) < 1 - kUsed) used.push_back(k);
  }
  work_ += lp.n_columns();
  if (used.size() > kUsedColumns) return 0;
  const auto in_conflict = [&](Index k) {
    std::vector<Index> with;
    for (const Index j : used) {
      if (j > k && Conflict(lp, k, j)) with.push_back(j);
    }
    work_ += static_cast<std::int64_t>(4 * used.size());
    return with;
  };
  // Three that no row has all of, which are in most sets that are violated.
  std::vector<std::tuple<double, Index, Index, Index>> threes;
  for (const Index a : used) {
    const std::vector<Index> with = in_conflict(a);
    for (std::size_t i = 0; i < with.size(); ++i) {
      for (std::size_t j = i + 1; j < with.size(); ++j) {
        const Index b = with[i], c = with[j];
        const bool in_a_row = std::ranges::any_of(
            lp.rows(a), [&](Index row) { return row >= 0 && Has(lp, b, row) && Has(lp, c, row); });
        if (in_a_row || !Conflict(lp, b, c)) continue;
        threes.emplace_back(-lp.value(a) - lp.value(b) - lp.value(c), a, b, c);
      }
    }
    work_ += static_cast<std::int64_t>(4 * with.size() * with.size());
  }
  std::ranges::sort(threes);
  std::vector<int> times(At(lp.n_columns()), 0);
  std::size_t found = 0;
  for (const auto& [sum, a, b, c] : threes) {
    if (found == kPerRound) break;
    if (std::max({times[At(a)], times[At(b)], times[At(c)]}) >= kPerColumn) continue;
    std::vector<Index> members = Extended(lp, {a, b, c});
    double value = 0;
    for (const Index k : members) value += lp.value(k);
    if (value < kViolated || std::ranges::find(all_, members) != all_.end()) continue;
    for (const Index k : members) ++times[At(k)];
    all_.push_back(std::move(members));
    ++found;
  }
  return found;
}

}  // namespace muster::scheduler
