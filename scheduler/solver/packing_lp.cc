#include "scheduler/solver/packing_lp.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace muster::scheduler {
namespace {

constexpr double kReducedCost = 1e-9;  ///< below it a column does not enter
constexpr double kNoise = 1e-9;        ///< below it an entry of alpha counts as zero
constexpr double kPivot = 1e-5;        ///< below it no row leaves: true entries are larger
constexpr double kFeasible = 1e-12;    ///< what a value may be below zero
constexpr double kMisfit = 1e-7;       ///< of values and prices, relative to the largest cost
constexpr double kZero = 1e-11;        ///< rounding: entries are quotients of small numbers
constexpr double kRaise = 1e-6;        ///< of right-hand sides, times 1 to 2
constexpr std::size_t kCandidates = 24;
/// A column of the inverse with more entries than that, and than this part of all, is an array.
constexpr std::size_t kSparse = 64, kPart = 4;
constexpr std::int64_t kArraySpeed = 4;  ///< entries of an array that cost as much as one elsewhere
constexpr std::int32_t kNothing = std::numeric_limits<std::int32_t>::min();

}  // namespace

PackingLp::PackingLp(std::span<const std::int32_t> capacity)
    : m_(static_cast<std::int32_t>(capacity.size())),
      capacity_(capacity.begin(), capacity.end()),
      slack_cost_(capacity.size(), 0),
      slack_position_(capacity.size()),
      basic_(capacity.size()),
      x_(capacity.size()),
      price_(capacity.size(), 0),
      raised_(capacity.size()),
      inverse_(capacity.size()),
      dense_(capacity.size()),
      rows_at_(capacity.size()),
      alpha_(capacity.size(), 0),
      where_(capacity.size(), -1),
      looked_at_(capacity.size(), 0),
      slack_pooled_(capacity.size(), 0),
      is_cheaper_(capacity.size(), 0),
      columns_at_(capacity.size()) {
  std::uint32_t state = 12345;
  for (std::int32_t i = 0; i < m_; ++i) {
    slack_position_[At(i)] = i;
    basic_[At(i)] = ~i;
    state = state * 1664525u + 1013904223u;
    raised_[At(i)] = capacity[At(i)] + kRaise * (1 + static_cast<double>(state >> 8) * 0x1p-24);
    x_[At(i)] = raised_[At(i)];
  }
}

std::int32_t PackingLp::AddColumn(double cost, std::array<std::int32_t, 3> rows) {
  cost_.push_back(cost);
  rows_.push_back(rows);
  position_of_.push_back(-1);
  closed_.push_back(0);
  column_pooled_.push_back(0);
  const std::int32_t column = n_columns() - 1;
  for (const std::int32_t r : rows) {
    if (r >= 0) columns_at_[At(r)].push_back(column);
  }
  Pool(column);
  return column;
}

void PackingLp::Close(std::int32_t column, bool close) {
  if ((closed_[At(column)] != 0) == close) return;
  closed_[At(column)] = close;
  const double change = close ? -closed_cost_ : closed_cost_;
  cost_[At(column)] += change;
  Pool(column);
  ChangeCost(position_of_[At(column)], change);
}

bool PackingLp::Require(std::int32_t row, bool require) {
  if ((slack_cost_[At(row)] != 0) == require) return false;
  slack_cost_[At(row)] = require ? -closed_cost_ : 0;
  ChangeCost(slack_position_[At(row)], require ? -closed_cost_ : closed_cost_);
  if (slack_position_[At(row)] >= 0) {
    ChangePrice(row, slack_cost_[At(row)] - price_[At(row)]);
    price_[At(row)] = slack_cost_[At(row)];
  }
  Pool(~row);
  return true;
}

void PackingLp::ChangePrice(std::int32_t row, double change) {
  price_[At(row)] += change;
  if (change >= 0 || is_cheaper_[At(row)]) return;
  is_cheaper_[At(row)] = 1;
  cheaper_.push_back(row);
}

void PackingLp::Pool(std::int32_t variable) {
  char& pooled = variable >= 0 ? column_pooled_[At(variable)] : slack_pooled_[At(~variable)];
  if (pooled) return;
  pooled = 1;
  pool_.push_back(variable);
}

template <class Visit>
void PackingLp::AtPosition(std::int32_t position, Visit&& visit) {
  std::vector<std::int32_t>& rows = rows_at_[At(position)];
  const std::size_t n_dense = dense_rows_.size();  // visit may add some of the others
  std::size_t kept = 0;
  ++look_;
  for (const std::int32_t row : rows) {
    // A row that lost its entry and got one again is listed twice.
    if (slack_position_[At(row)] >= 0 || looked_at_[At(row)] == look_) continue;
    if (!dense_[At(row)].empty()) continue;
    looked_at_[At(row)] = look_;
    std::vector<Entry>& column = inverse_[At(row)];
    const auto entry = std::find_if(column.begin(), column.end(),
                                    [&](const Entry& e) { return e.position == position; });
    work_ += entry - column.begin() + 1;
    if (entry == column.end()) continue;
    rows[kept++] = row;
    visit(row, entry->value);
  }
  rows.resize(kept);
  for (std::size_t k = 0; k < n_dense; ++k) {
    const double value = dense_[At(dense_rows_[k])][At(position)];
    if (std::abs(value) >= kZero) visit(dense_rows_[k], value);
  }
  work_ += static_cast<std::int64_t>(n_dense);
}

void PackingLp::ChangeCost(std::int32_t position, double change) {
  if (position < 0) return;
  AtPosition(position, [&](std::int32_t row, double value) { ChangePrice(row, change * value); });
}

double PackingLp::Bound() const {
  double bound = 0;
  for (std::int32_t row = 0; row < m_; ++row) {
    if (price_[At(row)] > 0 || slack_cost_[At(row)] != 0) {
      bound += price_[At(row)] * capacity_[At(row)];
    }
  }
  return bound;
}

double PackingLp::value(std::int32_t column) const {
  const std::int32_t position = position_of_[At(column)];
  return position < 0 ? 0 : x_[At(position)];
}

double PackingLp::ReducedCost(std::int32_t column) const {
  double reduced = cost_[At(column)];
  for (const std::int32_t r : rows_[At(column)]) {
    if (r >= 0) reduced -= price_[At(r)];
  }
  return reduced;
}

double PackingLp::ReducedCostOf(std::int32_t variable) const {
  return variable >= 0 ? ReducedCost(variable) : slack_cost_[At(~variable)] - price_[At(~variable)];
}

std::int32_t PackingLp::Entering() {
  for (const bool refill : {false, true}) {
    if (refill) {
      work_ += static_cast<std::int64_t>(cheaper_.size() + pool_.size());
      for (const std::int32_t r : cheaper_) {
        is_cheaper_[At(r)] = 0;
        Pool(~r);
        for (const std::int32_t j : columns_at_[At(r)]) {
          if (position_of_[At(j)] < 0 && ReducedCost(j) > kReducedCost) Pool(j);
        }
        work_ += static_cast<std::int64_t>(columns_at_[At(r)].size());
      }
      cheaper_.clear();
      candidates_.clear();
      std::erase_if(pool_, [&](std::int32_t variable) {
        const bool column = variable >= 0;
        if ((column ? position_of_[At(variable)] : slack_position_[At(~variable)]) < 0) {
          const double reduced = ReducedCostOf(variable);
          if (reduced > kReducedCost) {
            candidates_.emplace_back(reduced, variable);
            return false;
          }
        }
        (column ? column_pooled_[At(variable)] : slack_pooled_[At(~variable)]) = 0;
        return true;
      });
      if (candidates_.size() > 2 * kCandidates) {
        std::nth_element(candidates_.begin(), candidates_.begin() + kCandidates, candidates_.end(),
                         std::greater<>());
        candidates_.resize(kCandidates);
      }
    }
    double best = kReducedCost;
    std::int32_t entering = kNothing;
    for (const auto& [old, variable] : candidates_) {
      const bool basic =
          variable >= 0 ? position_of_[At(variable)] >= 0 : slack_position_[At(~variable)] >= 0;
      if (basic) continue;
      const double reduced = ReducedCostOf(variable);
      if (reduced > best) {
        best = reduced;
        entering = variable;
      }
    }
    if (entering != kNothing) return entering;
  }
  return kNothing;
}

/// alpha = inverse of the basis times the variable's column.
void PackingLp::FillAlpha(std::int32_t variable) {
  for (const std::int32_t i : alpha_nonzero_) alpha_[At(i)] = 0;
  alpha_nonzero_.clear();
  const auto add = [&](std::int32_t row) {
    if (row < 0) return;
    const std::int32_t position = slack_position_[At(row)];
    if (position >= 0) {
      if (alpha_[At(position)] == 0) alpha_nonzero_.push_back(position);
      alpha_[At(position)] += 1;
      return;
    }
    const auto add_entry = [&](std::int32_t i, double value) {
      if (alpha_[At(i)] == 0) alpha_nonzero_.push_back(i);
      alpha_[At(i)] += value;
    };
    if (const std::vector<double>& dense = dense_[At(row)]; !dense.empty()) {
      for (std::int32_t i = 0; i < m_; ++i) {
        if (dense[At(i)] != 0) add_entry(i, dense[At(i)]);
      }
      work_ += m_ / kArraySpeed;
    }
    for (const Entry& entry : inverse_[At(row)]) add_entry(entry.position, entry.value);
    work_ += static_cast<std::int64_t>(inverse_[At(row)].size());
  };
  if (variable < 0) {
    add(~variable);
  } else {
    for (const std::int32_t row : rows_[At(variable)]) add(row);
  }
  // Sorted, so that equal ratios are decided alike whatever the order of the entries; and without
  // what cancelled, of which a position may have been listed twice.
  std::sort(alpha_nonzero_.begin(), alpha_nonzero_.end());
  alpha_nonzero_.erase(std::unique(alpha_nonzero_.begin(), alpha_nonzero_.end()),
                       alpha_nonzero_.end());
  std::erase_if(alpha_nonzero_, [&](std::int32_t i) {
    if (std::abs(alpha_[At(i)]) > kNoise) return false;
    alpha_[At(i)] = 0;
    return true;
  });
}

void PackingLp::Pivot(std::int32_t entering, std::int32_t position, double reduced) {
  const double pivot = alpha_[At(position)];
  const double step = x_[At(position)] / pivot;
  for (const std::int32_t i : alpha_nonzero_) x_[At(i)] -= step * alpha_[At(i)];
  x_[At(position)] = step;

  const std::int32_t leaving = basic_[At(position)];
  if (leaving < 0) {
    // The row becomes active; its column was a unit vector.
    inverse_[At(~leaving)].assign(1, {position, 1});
    rows_at_[At(position)].push_back(~leaving);
    slack_position_[At(~leaving)] = -1;
  } else {
    position_of_[At(leaving)] = -1;
  }
  alpha_values_.clear();
  for (const std::int32_t i : alpha_nonzero_) alpha_values_.push_back(alpha_[At(i)]);
  AtPosition(position, [&](std::int32_t row, double value) {
    const double factor = value / pivot;
    if (dense_[At(row)].empty()) {
      UpdateSparse(row, position, factor);
    } else {
      std::vector<double>& column = dense_[At(row)];
      for (std::size_t k = 0; k < alpha_nonzero_.size(); ++k) {
        column[At(alpha_nonzero_[k])] -= factor * alpha_values_[k];
      }
      column[At(position)] = factor;
      work_ += static_cast<std::int64_t>(alpha_nonzero_.size()) / kArraySpeed;
    }
    ChangePrice(row, reduced * factor);
  });
  basic_[At(position)] = entering;
  if (entering < 0) {
    // The row's column is a unit vector again.
    const std::int32_t row = ~entering;
    slack_position_[At(row)] = position;
    ChangePrice(row, slack_cost_[At(row)] - price_[At(row)]);
    price_[At(row)] = slack_cost_[At(row)];
    if (!dense_[At(row)].empty()) {
      dense_[At(row)].clear();
      dense_rows_.erase(std::find(dense_rows_.begin(), dense_rows_.end(), row));
    }
  } else {
    position_of_[At(entering)] = position;
  }
  ++pivots_;
}

/// Part of Pivot: one sparse column of the inverse.
void PackingLp::UpdateSparse(std::int32_t row, std::int32_t position, double factor) {
  std::vector<Entry>& column = inverse_[At(row)];
  const std::size_t old = column.size();
  for (std::size_t k = 0; k < old; ++k) {
    where_[At(column[k].position)] = static_cast<std::int32_t>(k);
  }
  for (std::size_t k = 0; k < alpha_nonzero_.size(); ++k) {
    const std::int32_t i = alpha_nonzero_[k];
    const double change = -factor * alpha_values_[k];
    if (where_[At(i)] >= 0) {
      column[At(where_[At(i)])].value += change;
    } else {
      column.push_back({i, change});
      rows_at_[At(i)].push_back(row);
    }
  }
  column[At(where_[At(position)])].value = factor;
  for (std::size_t k = 0; k < old; ++k) where_[At(column[k].position)] = -1;
  std::erase_if(column, [](const Entry& e) { return std::abs(e.value) < kZero; });
  work_ += static_cast<std::int64_t>(old + alpha_nonzero_.size());
  if (column.size() <= std::max(kSparse, At(m_) / kPart)) return;
  dense_[At(row)].assign(At(m_), 0);
  for (const Entry& entry : column) dense_[At(row)][At(entry.position)] = entry.value;
  column.clear();
  dense_rows_.push_back(row);
}

std::int32_t PackingLp::Leaving() const {
  double most = std::numeric_limits<double>::infinity();
  for (const std::int32_t i : alpha_nonzero_) {
    if (alpha_[At(i)] <= kPivot) continue;
    most = std::min(most, (std::max(0.0, x_[At(i)]) + kFeasible) / alpha_[At(i)]);
  }
  std::int32_t position = -1;
  for (const std::int32_t i : alpha_nonzero_) {
    if (alpha_[At(i)] <= kPivot || std::max(0.0, x_[At(i)]) > most * alpha_[At(i)]) continue;
    if (position < 0 || alpha_[At(i)] > alpha_[At(position)]) position = i;
  }
  return position;
}

bool PackingLp::Solve(std::int64_t work_limit, const std::function<bool()>& stop) {
  const std::int64_t end = work_ + work_limit;
  candidates_.clear();
  while (work_ < end) {
    const std::int32_t entering = Entering();
    if (entering == kNothing) {
      if (pivots_ - verified_at_ < m_ || Verify()) return true;
      continue;
    }
    FillAlpha(entering);
    const std::int32_t position = Leaving();
    if (position < 0) {
      // Every column has a row, so this is rounding.
      if (Verify()) return false;
      continue;
    }
    Pivot(entering, position, ReducedCostOf(entering));
    if (pivots_ % 64 == 0 && stop()) return false;
  }
  return false;
}

bool PackingLp::Verify() {
  verified_at_ = pivots_;
  if (Misfit() <= kMisfit) return true;
  Refactor();
  if (Misfit() > kMisfit) ResetToSlacks();
  verified_at_ = pivots_;
  return false;
}

/// Largest error of a right-hand side, and of a basic column's reduced cost relative to the largest
/// cost; or how far a value is below zero.
double PackingLp::Misfit() const {
  double largest = 1, misfit = 0;
  std::vector<double> rest = raised_;
  for (std::int32_t position = 0; position < m_; ++position) {
    const std::int32_t variable = basic_[At(position)];
    misfit = std::max(misfit, -x_[At(position)]);
    if (variable < 0) {
      rest[At(~variable)] -= x_[At(position)];
      continue;
    }
    largest = std::max(largest, std::abs(cost_[At(variable)]));
    for (const std::int32_t r : rows_[At(variable)]) {
      if (r >= 0) rest[At(r)] -= x_[At(position)];
    }
  }
  for (const double error : rest) misfit = std::max(misfit, std::abs(error));
  for (const std::int32_t variable : basic_) {
    if (variable >= 0) misfit = std::max(misfit, std::abs(ReducedCost(variable)) / largest);
  }
  return misfit;
}

void PackingLp::ResetToSlacks() {
  for (std::int32_t row = 0; row < m_; ++row) {
    if (basic_[At(row)] >= 0) position_of_[At(basic_[At(row)])] = -1;
    inverse_[At(row)].clear();
    dense_[At(row)].clear();
    rows_at_[At(row)].clear();
  }
  dense_rows_.clear();
  for (std::int32_t row = 0; row < m_; ++row) {
    basic_[At(row)] = ~row;
    slack_position_[At(row)] = row;
    x_[At(row)] = raised_[At(row)];
    price_[At(row)] = slack_cost_[At(row)];
  }
  for (std::int32_t k = 0; k < n_columns(); ++k) Pool(k);
  candidates_.clear();
  work_ += m_ + n_columns();
}

/// The same basis, pivot by pivot from the slacks, each at the largest entry among the rows that
/// are to be active. What does not fit, by rounding, stays outside.
void PackingLp::Refactor() {
  std::vector<std::int32_t> columns;
  std::vector<char> active(At(m_));
  for (std::int32_t i = 0; i < m_; ++i) {
    if (basic_[At(i)] >= 0) columns.push_back(basic_[At(i)]);
    active[At(i)] = slack_position_[At(i)] < 0;
  }
  std::sort(columns.begin(), columns.end());
  ResetToSlacks();
  for (const std::int32_t column : columns) {
    FillAlpha(column);
    std::int32_t best = -1;
    for (const std::int32_t i : alpha_nonzero_) {
      if (std::abs(alpha_[At(i)]) <= kPivot || basic_[At(i)] >= 0 || !active[At(~basic_[At(i)])]) {
        continue;
      }
      if (best < 0 || std::abs(alpha_[At(i)]) > std::abs(alpha_[At(best)])) best = i;
    }
    if (best >= 0) Pivot(column, best, ReducedCost(column));
  }
}

}  // namespace muster::scheduler
