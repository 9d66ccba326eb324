#include "scheduler/solver/packing_lp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace muster::scheduler {
namespace {

constexpr double kNoise = 1e-9;      ///< below it an entry of alpha counts as zero
constexpr double kPivot = 1e-5;      ///< below it no row leaves: true entries are larger
constexpr double kFeasible = 1e-12;  ///< what a value may be below zero
constexpr double kMisfit = 1e-7;     ///< of values and prices, relative to the largest cost
constexpr double kZero = 1e-11;      ///< rounding: entries are quotients of small numbers
constexpr double kRaise = 1e-6;      ///< of right-hand sides, times 1 to 2
/// Counted steps of a program that is easy: these, and those for each row. Of the paper's settings
/// none was seen to take more than 6.1 million (`rollout-steps`, mode overrun; decisions of
/// `certified`: 0.2). Up to there nothing may change: another rule ends at another vertex where
/// optima tie, and a recorded mission has to be decided again bit for bit.
constexpr std::int64_t kEasyWork = 8'000'000, kEasyWorkPerRow = 500;
/// A column of the inverse with more entries than that, and than this part of all, is an array.
constexpr std::size_t kSparse = 64, kPart = 4;
constexpr std::int64_t kArraySpeed = 4;  ///< entries of an array that cost as much as one elsewhere

/// So many steps, and these for each row, in each of so many pivots are more than factors cost.
constexpr std::int64_t kDear = 20'000, kDearPerRow = 4, kLately = 128;
constexpr std::int64_t kFactorsSpeed = 2;  ///< steps of one of the factors, which lie scattered

/// Of an array, that part of the entries is as dear to change as all of them side by side.
constexpr std::size_t kScattered = 8;

/// a -= factor * b, four at a time, which -O2 turns into vector instructions; the same to the bit.
void SubtractMultiple(double* __restrict a, const double* __restrict b, double factor,
                      std::size_t n) {
  std::size_t i = 0;
  for (; i + 4 <= n; i += 4) {
    const double x0 = a[i] - factor * b[i], x1 = a[i + 1] - factor * b[i + 1];
    const double x2 = a[i + 2] - factor * b[i + 2], x3 = a[i + 3] - factor * b[i + 3];
    a[i] = x0, a[i + 1] = x1, a[i + 2] = x2, a[i + 3] = x3;
  }
  for (; i < n; ++i) a[i] -= factor * b[i];
}

}  // namespace

PackingLp::PackingLp(std::span<const std::int32_t> capacity, std::int32_t n_first)
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
      inverse_row_{std::vector<double>(capacity.size() + 1, 0), {}},
      where_(capacity.size(), -1),
      looked_at_(capacity.size(), 0),
      largest_(capacity.size()),
      columns_at_(capacity.size()) {
  std::uint32_t state = 12345;
  for (std::int32_t i = 0; i < m_; ++i) {
    slack_position_[At(i)] = i;
    basic_[At(i)] = ~i;
    state = state * 1664525u + 1013904223u;
    const double more = n_first > 0 && i >= n_first ? 2 : 1;
    raised_[At(i)] = capacity[At(i)] + kRaise * (more + static_cast<double>(state >> 8) * 0x1p-24);
    x_[At(i)] = raised_[At(i)];
  }
}

std::int32_t PackingLp::AddColumn(double cost, std::array<std::int32_t, 3> rows,
                                  std::vector<std::int32_t> more) {
  cost_.push_back(cost);
  rows_.push_back(rows);
  position_of_.push_back(-1);
  closed_.push_back(0);
  const std::int32_t column = n_columns() - 1;
  for (const std::int32_t r : rows) {
    if (r >= 0) columns_at_[At(r)].push_back(column);
  }
  for (const std::int32_t r : more) columns_at_[At(r)].push_back(column);
  if (!more.empty() || !more_rows_.empty()) {
    more_rows_.resize(At(n_columns()));
    more_rows_.back() = std::move(more);
  }
  Changed(column);
  return column;
}

void PackingLp::Close(std::int32_t column, bool close) {
  if ((closed_[At(column)] != 0) == close) return;
  closed_[At(column)] = close;
  const double change = close ? -closed_cost_ : closed_cost_;
  cost_[At(column)] += change;
  Changed(column);
  if (IsBasic(column)) ChangeCost(position_of_[At(column)], change);
}

bool PackingLp::Require(std::int32_t row, bool require) {
  if ((slack_cost_[At(row)] != 0) == require) return false;
  slack_cost_[At(row)] = require ? -closed_cost_ : 0;
  if (IsBasic(~row)) {
    ChangeCost(slack_position_[At(row)], require ? -closed_cost_ : closed_cost_);
    price_[At(row)] = slack_cost_[At(row)];
  }
  Changed(~row);
  return true;
}

void PackingLp::Changed(std::int32_t variable) {
  if (devex_) {
    devex_->Changed(*this, variable);
  } else {
    largest_.Changed(variable);
  }
}

void PackingLp::ChangePrice(std::int32_t row, double change) {
  price_[At(row)] += change;
  if (change < 0 && !devex_) largest_.PriceFell(row);
}

void PackingLp::FillInverseRow(std::int32_t position) {
  for (const std::int32_t row : inverse_row_.rows) inverse_row_.values[At(row + 1)] = 0;
  inverse_row_.rows.clear();
  const auto add = [&](std::int32_t row, double value) {
    inverse_row_.values[At(row + 1)] = value;
    inverse_row_.rows.push_back(row);
  };
  if (factors_) {
    const std::int64_t before = factors_->work();
    vector_.values[At(position)] = 1;
    vector_.nonzero.push_back(position);
    factors_->SolveTransposed(&vector_);
    for (const std::int32_t row : vector_.nonzero) {
      if (std::abs(vector_.values[At(row)]) >= kZero) add(row, vector_.values[At(row)]);
    }
    vector_.Clear();
    work_ += kFactorsSpeed * (factors_->work() - before);
    return;
  }
  std::vector<std::int32_t>& rows = rows_at_[At(position)];
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
    add(row, entry->value);
  }
  rows.resize(kept);
  for (const std::int32_t row : dense_rows_) {
    const double value = dense_[At(row)][At(position)];
    if (std::abs(value) >= kZero) add(row, value);
  }
  work_ += static_cast<std::int64_t>(dense_rows_.size());
  // The column of a row that is not active is a unit vector.
  const std::int32_t variable = basic_[At(position)];
  if (variable < 0 && slack_position_[At(~variable)] == position) add(~variable, 1);
}

void PackingLp::ChangeCost(std::int32_t position, double change) {
  FillInverseRow(position);
  for (const std::int32_t r : inverse_row_.rows) ChangePrice(r, change * inverse_row_.at(r));
  if (devex_) devex_->BasicCostChanged(*this, inverse_row_, change, &work_);
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

double PackingLp::ReducedCost(std::int32_t variable) const {
  if (variable < 0) return slack_cost_[At(~variable)] - price_[At(~variable)];
  double reduced = cost_[At(variable)];
  for (const std::int32_t r : rows_[At(variable)]) {
    if (r >= 0) reduced -= price_[At(r)];
  }
  for (const std::int32_t r : more_rows(variable)) reduced -= price_[At(r)];
  return reduced;
}

std::int32_t PackingLp::Entering() {
  if (!devex_ && work_ >= kEasyWork + kEasyWorkPerRow * m_) UseDevex();
  return devex_ ? devex_->Entering(*this, &work_) : largest_.Entering(*this, &work_);
}

/// Where the inverse fills up, factors of the basis do not.
void PackingLp::UseFactorsIfDear() {
  const std::int64_t lately = work_ - std::exchange(work_before_, work_);
  if (factors_ || !devex_ || lately <= kLately * (kDear + kDearPerRow * m_)) return;
  if (!more_rows_.empty()) return;  // factors are of columns with three ones at most
  factors_.emplace(At(m_));
  vector_ = Sparse(At(m_));
  Refactor();
  inverse_.assign(At(m_), {});
  dense_.assign(At(m_), {});
  rows_at_.assign(At(m_), {});
  dense_rows_.clear();
}

/// alpha = inverse of the basis times the variable's column.
void PackingLp::FillAlpha(std::int32_t variable) {
  for (const std::int32_t i : alpha_nonzero_) alpha_[At(i)] = 0;
  alpha_nonzero_.clear();
  if (factors_) {
    const std::int64_t before = factors_->work();
    const std::array<std::int32_t, 3> rows =
        variable < 0 ? std::array{~variable, kNoRow, kNoRow} : rows_[At(variable)];
    for (const std::int32_t row : rows) {
      if (row < 0) continue;
      vector_.values[At(row)] = 1;
      vector_.nonzero.push_back(row);
    }
    factors_->Solve(&vector_);
    for (const std::int32_t i : vector_.nonzero) {
      if (std::abs(vector_.values[At(i)]) <= kNoise) continue;
      alpha_[At(i)] = vector_.values[At(i)];
      alpha_nonzero_.push_back(i);
    }
    vector_.Clear();
    work_ += kFactorsSpeed * (factors_->work() - before);
    return;
  }
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
    for (const std::int32_t row : more_rows(variable)) add(row);
  }
  // Sorted, so that equal ratios are decided alike whatever the order of the entries; and without
  // what cancelled, of which a position may have been listed twice.
  if (alpha_nonzero_.size() > At(m_) / kPart) {
    alpha_nonzero_.clear();
    for (std::int32_t i = 0; i < m_; ++i) {
      if (alpha_[At(i)] != 0) alpha_nonzero_.push_back(i);
    }
  } else {
    std::sort(alpha_nonzero_.begin(), alpha_nonzero_.end());
    alpha_nonzero_.erase(std::unique(alpha_nonzero_.begin(), alpha_nonzero_.end()),
                         alpha_nonzero_.end());
  }
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
    if (!factors_) {
      inverse_[At(~leaving)].assign(1, {position, 1});
      rows_at_[At(position)].push_back(~leaving);
    }
    slack_position_[At(~leaving)] = -1;
  } else {
    position_of_[At(leaving)] = -1;
  }
  FillInverseRow(position);
  for (const std::int32_t row : inverse_row_.rows) {
    ChangePrice(row, reduced * (inverse_row_.at(row) / pivot));
  }
  if (factors_) {
    factors_->Exchange(position, alpha_, alpha_nonzero_);
  } else {
    UpdateInverse(position, pivot);
  }
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
  if (devex_) {
    devex_->Pivoted(*this, inverse_row_, entering, leaving, reduced, pivot, &work_);
  }
  ++pivots_;
  if (pivots_ % kLately == 0) UseFactorsIfDear();
  if (factors_ && factors_->is_long()) Refactor();
}

/// Part of Pivot: the inverse as it is kept without factors.
void PackingLp::UpdateInverse(std::int32_t position, double pivot) {
  alpha_values_.clear();
  for (const std::int32_t i : alpha_nonzero_) alpha_values_.push_back(alpha_[At(i)]);
  const bool many = alpha_nonzero_.size() > At(m_) / kScattered;
  for (const std::int32_t row : inverse_row_.rows) {
    const double factor = inverse_row_.at(row) / pivot;
    if (dense_[At(row)].empty()) {
      UpdateSparse(row, position, factor);
      continue;
    }
    double* const column = dense_[At(row)].data();
    if (many) {
      SubtractMultiple(column, alpha_.data(), factor, alpha_.size());
    } else {
      for (std::size_t k = 0; k < alpha_nonzero_.size(); ++k) {
        column[At(alpha_nonzero_[k])] -= factor * alpha_values_[k];
      }
    }
    column[At(position)] = factor;
    work_ += static_cast<std::int64_t>(alpha_nonzero_.size()) / kArraySpeed;
  }
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
  largest_.ForgetCandidates();
  while (work_ < end) {
    const std::int32_t entering = Entering();
    if (entering == kNoVariable) {
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
    Pivot(entering, position, ReducedCost(entering));
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
    for (const std::int32_t r : more_rows(variable)) rest[At(r)] -= x_[At(position)];
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
  if (factors_) MakeFactors();
  if (devex_) {
    devex_->Restart(*this, &work_);
  } else {
    for (std::int32_t k = 0; k < n_columns(); ++k) largest_.Changed(k);
    largest_.ForgetCandidates();
  }
  work_ += m_ + n_columns();
}

void PackingLp::Refactor() {
  if (!factors_) {
    MakeInverse();
  } else if (!MakeFactors()) {
    ResetToSlacks();
  } else {
    devex_->Refresh(*this, &work_);
  }
}

/// Of the present basis, with its values and prices; false: it is singular, by rounding.
bool PackingLp::MakeFactors() {
  std::vector<BasisFactors::Rows> columns;
  for (std::int32_t i = 0; i < m_; ++i) {
    const std::int32_t variable = basic_[At(i)];
    columns.push_back(variable >= 0 ? rows_[At(variable)]
                                    : BasisFactors::Rows{~variable, kNoRow, kNoRow});
  }
  const std::int64_t before = factors_->work();
  const bool is_regular = factors_->Factor(columns);
  if (is_regular) {
    const auto set = [&](std::int32_t i, double value) {
      vector_.values[At(i)] = value;
      vector_.nonzero.push_back(i);
    };
    for (std::int32_t row = 0; row < m_; ++row) set(row, raised_[At(row)]);
    factors_->Solve(&vector_);
    x_ = vector_.values;
    vector_.Clear();
    for (std::int32_t i = 0; i < m_; ++i) {
      const std::int32_t variable = basic_[At(i)];
      set(i, variable >= 0 ? cost_[At(variable)] : slack_cost_[At(~variable)]);
    }
    factors_->SolveTransposed(&vector_);
    price_ = vector_.values;
    vector_.Clear();
  }
  work_ += kFactorsSpeed * (factors_->work() - before);
  return is_regular;
}

/// The same basis, pivot by pivot from the slacks, each at the largest entry among the rows that
/// are to be active. What does not fit, by rounding, stays outside.
void PackingLp::MakeInverse() {
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
