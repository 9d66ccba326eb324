#include "scheduler/solver/basis_factors.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace muster::scheduler {
namespace {

constexpr double kCancelled = 1e-12;  ///< rounding: entries are quotients of small numbers
constexpr double kSingular = 1e-7;    ///< a pivot is larger
constexpr double kLargeShare = 0.1;   ///< a pivot is at least that share of its column's largest

}  // namespace

/// Gaussian elimination on what is left of the basis.
class BasisFactors::Elimination {
 public:
  Elimination(std::span<const Rows> columns, BasisFactors* out)
      : out_(*out),
        rows_(columns.size()),
        columns_(columns.size()),
        count_(columns.size(), 0),
        row_done_(columns.size(), 0),
        position_done_(columns.size(), 0),
        where_(columns.size(), -1) {
    Peel(columns);
    for (std::int32_t p = 0; At(p) < columns.size(); ++p) {
      if (position_done_[At(p)]) continue;
      for (const std::int32_t r : columns[At(p)]) {
        if (r < 0 || row_done_[At(r)]) continue;
        rows_[At(r)].push_back({p, 1});
        columns_[At(p)].push_back(r);
      }
      Queue(p);
    }
  }

  bool Run() {
    while (out_.row_.size() < rows_.size()) {
      std::int32_t row = -1, position = -1;
      if (!Choose(&row, &position)) return false;
      Pivot(row, position);
    }
    return true;
  }

 private:
  /// What has one entry in its row or column, again and again: most of a basis. Nothing fills up,
  /// so all that is left are ones.
  void Peel(std::span<const Rows> columns) {
    std::vector<std::size_t> begin(columns.size() + 1, 0);
    for (const Rows& rows : columns) {
      for (const std::int32_t r : rows) begin[At(r + 1)] += r >= 0;
    }
    for (std::size_t r = 0; r < columns.size(); ++r) begin[r + 1] += begin[r];
    std::vector<std::int32_t> positions(begin.back()), row_count(columns.size());
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    std::vector<std::int32_t> single_columns, single_rows;
    for (std::int32_t p = 0; At(p) < columns.size(); ++p) {
      for (const std::int32_t r : columns[At(p)]) {
        if (r < 0) continue;
        positions[next[At(r)]++] = p;
        ++count_[At(p)];
      }
      if (count_[At(p)] == 1) single_columns.push_back(p);
    }
    for (std::int32_t r = 0; At(r) < columns.size(); ++r) {
      row_count[At(r)] = static_cast<std::int32_t>(begin[At(r) + 1] - begin[At(r)]);
      if (row_count[At(r)] == 1) single_rows.push_back(r);
    }
    const auto pivot = [&](std::int32_t row, std::int32_t position) {
      row_done_[At(row)] = 1;
      position_done_[At(position)] = 1;
      for (const std::int32_t r : columns[At(position)]) {
        if (r < 0 || row_done_[At(r)]) continue;
        out_.lower_.entries.push_back({r, 1});
        if (--row_count[At(r)] == 1) single_rows.push_back(r);
      }
      for (std::size_t k = begin[At(row)]; k < begin[At(row) + 1]; ++k) {
        const std::int32_t p = positions[k];
        if (position_done_[At(p)]) continue;
        out_.upper_.entries.push_back({p, 1});
        if (--count_[At(p)] == 1) single_columns.push_back(p);
      }
      EndStep(row, position, 1);
    };
    while (!single_columns.empty() || !single_rows.empty()) {
      if (!single_columns.empty()) {
        const std::int32_t p = single_columns.back();
        single_columns.pop_back();
        if (position_done_[At(p)] || count_[At(p)] != 1) continue;
        for (const std::int32_t r : columns[At(p)]) {
          if (r < 0 || row_done_[At(r)]) continue;
          pivot(r, p);
          break;
        }
        continue;
      }
      const std::int32_t r = single_rows.back();
      single_rows.pop_back();
      if (row_done_[At(r)] || row_count[At(r)] != 1) continue;
      for (std::size_t k = begin[At(r)]; k < begin[At(r) + 1]; ++k) {
        if (position_done_[At(positions[k])]) continue;
        pivot(r, positions[k]);
        break;
      }
    }
  }

  void EndStep(std::int32_t row, std::int32_t position, double pivot) {
    out_.row_.push_back(row);
    out_.position_.push_back(position);
    out_.pivot_.push_back(pivot);
    out_.lower_.begin.push_back(out_.lower_.entries.size());
    out_.upper_.begin.push_back(out_.upper_.entries.size());
  }

  void Queue(std::int32_t position) { queue_.emplace(count_[At(position)], position); }

  /// Rows that still have an entry in the column; forgets the others.
  const std::vector<std::int32_t>& RowsOf(std::int32_t position) {
    std::vector<std::int32_t>& rows = columns_[At(position)];
    std::erase_if(rows, [&](std::int32_t r) {
      return row_done_[At(r)] || Find(r, position) == rows_[At(r)].end();
    });
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    return rows;
  }
  std::vector<Entry>::iterator Find(std::int32_t row, std::int32_t position) {
    return std::find_if(rows_[At(row)].begin(), rows_[At(row)].end(),
                        [&](const Entry& e) { return e.index == position; });
  }

  /// A row or a column with one entry, which fills nothing; else the column with the fewest entries
  /// and its shortest row among those of large entries.
  bool Choose(std::int32_t* row, std::int32_t* position) {
    while (!single_rows_.empty()) {
      *row = single_rows_.back();
      single_rows_.pop_back();
      if (row_done_[At(*row)] || rows_[At(*row)].size() != 1) continue;
      const Entry& only = rows_[At(*row)].front();
      if (std::abs(only.value) < kSingular) continue;
      *position = only.index;
      return true;
    }
    while (!queue_.empty()) {
      const auto [count, p] = queue_.top();
      queue_.pop();
      if (position_done_[At(p)] || count != count_[At(p)]) continue;
      const std::vector<std::int32_t>& rows = RowsOf(p);
      double largest = 0;
      for (const std::int32_t r : rows) largest = std::max(largest, std::abs(Find(r, p)->value));
      if (largest < kSingular) return false;
      std::size_t shortest = std::numeric_limits<std::size_t>::max();
      for (const std::int32_t r : rows) {
        if (std::abs(Find(r, p)->value) < kLargeShare * largest) continue;
        if (rows_[At(r)].size() < shortest) {
          shortest = rows_[At(r)].size();
          *row = r;
        }
      }
      *position = p;
      return true;
    }
    return false;
  }

  void Pivot(std::int32_t row, std::int32_t position) {
    std::vector<Entry> pivot_row = std::move(rows_[At(row)]);
    rows_[At(row)].clear();
    row_done_[At(row)] = 1;
    position_done_[At(position)] = 1;
    double pivot = 0;
    for (Entry& entry : pivot_row) {
      if (entry.index == position) {
        pivot = entry.value;
        std::swap(entry, pivot_row.back());
        break;
      }
    }
    pivot_row.pop_back();
    for (const std::int32_t r : RowsOf(position)) {
      const auto entry = Find(r, position);
      const double factor = entry->value / pivot;
      *entry = rows_[At(r)].back();
      rows_[At(r)].pop_back();
      out_.lower_.entries.push_back({r, factor});
      Subtract(r, pivot_row, factor);
    }
    for (const Entry& entry : pivot_row) {
      --count_[At(entry.index)];
      Queue(entry.index);
    }
    out_.upper_.entries.insert(out_.upper_.entries.end(), pivot_row.begin(), pivot_row.end());
    EndStep(row, position, pivot);
  }

  void Subtract(std::int32_t r, const std::vector<Entry>& pivot_row, double factor) {
    std::vector<Entry>& row = rows_[At(r)];
    const std::size_t old = row.size();
    for (std::size_t k = 0; k < old; ++k) where_[At(row[k].index)] = static_cast<std::int32_t>(k);
    for (const Entry& entry : pivot_row) {
      const std::int32_t k = where_[At(entry.index)];
      if (k >= 0) {
        row[At(k)].value -= factor * entry.value;
      } else {
        row.push_back({entry.index, -factor * entry.value});
        columns_[At(entry.index)].push_back(r);
        ++count_[At(entry.index)];
        Queue(entry.index);
      }
    }
    for (std::size_t k = 0; k < old; ++k) where_[At(row[k].index)] = -1;
    std::erase_if(row, [&](const Entry& entry) {
      if (std::abs(entry.value) >= kCancelled) return false;
      --count_[At(entry.index)];
      Queue(entry.index);
      return true;
    });
    if (row.size() == 1) single_rows_.push_back(r);
  }

  using Counted = std::pair<std::int32_t, std::int32_t>;

  BasisFactors& out_;
  std::vector<std::vector<Entry>> rows_;            ///< what is left, by row: by position
  std::vector<std::vector<std::int32_t>> columns_;  ///< rows that have, or had, an entry
  std::vector<std::int32_t> count_;                 ///< entries of a column
  std::vector<char> row_done_, position_done_;
  std::vector<std::int32_t> where_;  ///< -1 between uses
  std::vector<std::int32_t> single_rows_;
  std::priority_queue<Counted, std::vector<Counted>, std::greater<>> queue_;
};

BasisFactors::BasisFactors(std::size_t n_rows)
    : n_(n_rows),
      step_of_row_(n_rows),
      step_of_position_(n_rows),
      exchanges_at_(n_rows),
      by_step_(n_rows, 0),
      steps_(n_rows),
      turns_(kMostExchanges),
      out_(n_rows) {}

bool BasisFactors::Factor(std::span<const Rows> columns) {
  for (const Exchanged& exchange : exchanges_) {
    exchanges_at_[At(exchange.position)].clear();
    for (const Entry& entry : exchange.others) exchanges_at_[At(entry.index)].clear();
  }
  exchanges_.clear();
  row_.clear(), position_.clear(), pivot_.clear();
  for (Steps* steps : {&lower_, &upper_}) steps->begin.assign(1, 0), steps->entries.clear();
  if (!Elimination(columns, this).Run()) return false;
  for (std::size_t k = 0; k < n_; ++k) {
    step_of_row_[At(row_[k])] = static_cast<std::int32_t>(k);
    step_of_position_[At(position_[k])] = static_cast<std::int32_t>(k);
  }
  for (Entry& entry : lower_.entries) entry.index = step_of_row_[At(entry.index)];
  for (Entry& entry : upper_.entries) entry.index = step_of_position_[At(entry.index)];
  lower_up_ = Transposed(lower_);
  upper_up_ = Transposed(upper_);
  work_ += 20 * static_cast<std::int64_t>(n_ + lower_.entries.size() + upper_.entries.size());
  return true;
}

BasisFactors::Steps BasisFactors::Transposed(const Steps& steps) const {
  Steps up;
  up.begin.assign(n_ + 1, 0);
  for (const Entry& entry : steps.entries) ++up.begin[At(entry.index) + 1];
  for (std::size_t k = 0; k < n_; ++k) up.begin[k + 1] += up.begin[k];
  up.entries.resize(steps.entries.size());
  std::vector<std::size_t> next(up.begin.begin(), up.begin.end() - 1);
  for (std::int32_t k = 0; At(k) < n_; ++k) {
    for (const Entry& entry : steps.at(k)) up.entries[next[At(entry.index)]++] = {k, entry.value};
  }
  return up;
}

void BasisFactors::Solve(Sparse* vector) {
  for (const std::int32_t row : vector->nonzero) {
    by_step_[At(step_of_row_[At(row)])] = vector->values[At(row)];
    steps_.Add(step_of_row_[At(row)]);
  }
  vector->Clear();
  const auto subtract = [&](std::span<const Entry> entries, double times, Agenda* agenda) {
    for (const Entry& entry : entries) {
      by_step_[At(entry.index)] -= entry.value * times;
      agenda->Add(entry.index);
    }
    work_ += static_cast<std::int64_t>(entries.size()) + 2;
  };
  steps_.TakeUp([&](std::int32_t k) {
    if (by_step_[At(k)] == 0) return;
    subtract(lower_.at(k), by_step_[At(k)], &steps_);
    out_.Add(k);
  });
  out_.TakeDown([&](std::int32_t k) {
    const double value = std::exchange(by_step_[At(k)], 0) / pivot_[At(k)];
    if (value == 0) return;
    subtract(upper_up_.at(k), value, &out_);
    vector->values[At(position_[At(k)])] = value;
    steps_.Add(position_[At(k)]);
  });
  for (const Exchanged& exchange : exchanges_) {
    double& value = vector->values[At(exchange.position)];
    if (value == 0) continue;
    value /= exchange.pivot;
    for (const Entry& entry : exchange.others) {
      vector->values[At(entry.index)] -= entry.value * value;
      steps_.Add(entry.index);
    }
    work_ += static_cast<std::int64_t>(exchange.others.size());
  }
  work_ += static_cast<std::int64_t>(exchanges_.size() + n_ / 16);
  steps_.TakeUp([&](std::int32_t position) { vector->nonzero.push_back(position); });
}

/// From the last to the first, those that have a position that is not 0.
void BasisFactors::UndoExchanges(Sparse* vector) {
  const auto note = [&](std::int32_t position, std::int32_t before) {
    for (const std::int32_t k : exchanges_at_[At(position)]) {
      if (k < before) turns_.Add(k);
    }
    work_ += static_cast<std::int64_t>(exchanges_at_[At(position)].size());
  };
  for (const std::int32_t position : vector->nonzero) {
    note(position, static_cast<std::int32_t>(kMostExchanges));
  }
  turns_.TakeDown([&](std::int32_t k) {
    const Exchanged& exchange = exchanges_[At(k)];
    double& entry_there = vector->values[At(exchange.position)];
    const bool is_new = entry_there == 0;
    double value = entry_there;
    for (const Entry& entry : exchange.others) {
      value -= entry.value * vector->values[At(entry.index)];
    }
    entry_there = value / exchange.pivot;
    work_ += static_cast<std::int64_t>(exchange.others.size());
    if (!is_new || entry_there == 0) return;
    vector->nonzero.push_back(exchange.position);
    note(exchange.position, k);
  });
}

void BasisFactors::SolveTransposed(Sparse* vector) {
  UndoExchanges(vector);
  for (const std::int32_t position : vector->nonzero) {
    by_step_[At(step_of_position_[At(position)])] = vector->values[At(position)];
    steps_.Add(step_of_position_[At(position)]);
  }
  vector->Clear();
  const auto subtract = [&](std::span<const Entry> entries, double times, Agenda* agenda) {
    for (const Entry& entry : entries) {
      by_step_[At(entry.index)] -= entry.value * times;
      agenda->Add(entry.index);
    }
    work_ += static_cast<std::int64_t>(entries.size()) + 2;
  };
  steps_.TakeUp([&](std::int32_t k) {
    if (by_step_[At(k)] == 0) return;
    by_step_[At(k)] /= pivot_[At(k)];
    subtract(upper_.at(k), by_step_[At(k)], &steps_);
    out_.Add(k);
  });
  out_.TakeDown([&](std::int32_t k) {
    const double value = std::exchange(by_step_[At(k)], 0);
    if (value == 0) return;
    subtract(lower_up_.at(k), value, &out_);
    vector->values[At(row_[At(k)])] = value;
    steps_.Add(row_[At(k)]);
  });
  steps_.TakeUp([&](std::int32_t row) { vector->nonzero.push_back(row); });
  work_ += static_cast<std::int64_t>(n_ / 16);
}

void BasisFactors::Exchange(std::int32_t position, std::span<const double> x,
                            std::span<const std::int32_t> nonzero) {
  const auto k = static_cast<std::int32_t>(exchanges_.size());
  Exchanged exchange{position, x[At(position)], {}};
  exchange.others.reserve(nonzero.size());
  exchanges_at_[At(position)].push_back(k);
  for (const std::int32_t i : nonzero) {
    if (i == position) continue;
    exchange.others.push_back({i, x[At(i)]});
    exchanges_at_[At(i)].push_back(k);
  }
  work_ += static_cast<std::int64_t>(nonzero.size());
  exchanges_.push_back(std::move(exchange));
}

}  // namespace muster::scheduler
