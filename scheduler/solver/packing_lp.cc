#include "scheduler/solver/packing_lp.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace muster::scheduler {
namespace {

constexpr double kReducedCost = 1e-9;  ///< below it a column does not enter
constexpr double kPivot = 1e-7;        ///< below it an entry counts as zero
constexpr double kZero = 1e-11;        ///< rounding: entries are quotients of small numbers
constexpr double kRaise = 1e-6;        ///< of right-hand sides, times 1 to 2
constexpr std::size_t kCandidates = 24;
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
      inverse_(capacity.size()),
      rows_at_(capacity.size()),
      active_index_(capacity.size(), -1),
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
    x_[At(i)] = capacity[At(i)] + kRaise * (1 + static_cast<double>(state >> 8) * 0x1p-24);
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
  std::size_t kept = 0;
  ++look_;
  for (const std::int32_t row : rows) {
    // A row that lost its entry and got one again is listed twice.
    if (slack_position_[At(row)] >= 0 || looked_at_[At(row)] == look_) continue;
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
    for (const Entry& entry : inverse_[At(row)]) {
      if (alpha_[At(entry.position)] == 0) alpha_nonzero_.push_back(entry.position);
      alpha_[At(entry.position)] += entry.value;
    }
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
    if (std::abs(alpha_[At(i)]) > kPivot) return false;
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
    active_index_[At(~leaving)] = static_cast<std::int32_t>(active_.size());
    active_.push_back(~leaving);
  } else {
    position_of_[At(leaving)] = -1;
  }
  AtPosition(position, [&](std::int32_t row, double value) {
    std::vector<Entry>& column = inverse_[At(row)];
    const double factor = value / pivot;
    for (std::size_t k = 0; k < column.size(); ++k) {
      where_[At(column[k].position)] = static_cast<std::int32_t>(k);
    }
    const std::size_t old = column.size();
    for (const std::int32_t i : alpha_nonzero_) {
      const double change = -factor * alpha_[At(i)];
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
    ChangePrice(row, reduced * factor);
    work_ += static_cast<std::int64_t>(old + alpha_nonzero_.size());
  });
  basic_[At(position)] = entering;
  if (entering < 0) {
    // The row's column is a unit vector again.
    const std::int32_t row = ~entering;
    slack_position_[At(row)] = position;
    ChangePrice(row, slack_cost_[At(row)] - price_[At(row)]);
    price_[At(row)] = slack_cost_[At(row)];
    const std::int32_t index = active_index_[At(row)];
    active_[At(index)] = active_.back();
    active_index_[At(active_.back())] = index;
    active_.pop_back();
  } else {
    position_of_[At(entering)] = position;
  }
  ++pivots_;
}

bool PackingLp::Solve(std::int64_t work_limit, const std::function<bool()>& stop) {
  const std::int64_t end = work_ + work_limit;
  candidates_.clear();
  while (work_ < end) {
    const std::int32_t entering = Entering();
    if (entering == kNothing) return true;
    const double reduced =
        entering >= 0 ? ReducedCost(entering) : slack_cost_[At(~entering)] - price_[At(~entering)];
    FillAlpha(entering);
    std::int32_t position = -1;
    double least = std::numeric_limits<double>::infinity();
    for (const std::int32_t i : alpha_nonzero_) {
      if (alpha_[At(i)] <= kPivot) continue;
      const double ratio = std::max(0.0, x_[At(i)]) / alpha_[At(i)];
      if (ratio < least - 1e-12 ||
          (ratio <= least + 1e-12 && position >= 0 && alpha_[At(i)] > alpha_[At(position)])) {
        least = std::min(least, ratio);
        position = i;
      }
    }
    if (position < 0) return false;  // every column has a row: only by rounding
    Pivot(entering, position, reduced);
    if (pivots_ % 64 == 0 && stop()) return false;
  }
  return false;
}

}  // namespace muster::scheduler
