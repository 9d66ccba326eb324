#include "scheduler/solver/pricing.h"

#include <algorithm>
#include <functional>

#include "scheduler/solver/packing_lp.h"

namespace muster::scheduler {
namespace {

constexpr std::size_t kCandidates = 24;
constexpr std::int64_t kCompared = 64;  ///< variables that devex always compares
/// Above it a devex weight says nothing any more, and would grow until it overflows.
constexpr double kMostWeight = 1e30;

}  // namespace

void LargestReducedCost::PriceFell(std::int32_t row) {
  if (is_cheaper_[At(row)]) return;
  is_cheaper_[At(row)] = 1;
  cheaper_.push_back(row);
}

std::int32_t LargestReducedCost::Entering(const PackingLp& lp, std::int64_t* work) {
  for (const bool refill : {false, true}) {
    if (refill) Refill(lp, work);
    double best = kReducedCost;
    std::int32_t entering = kNoVariable;
    for (const auto& [old, variable] : candidates_) {
      if (lp.IsBasic(variable)) continue;
      const double reduced = lp.ReducedCost(variable);
      if (reduced > best) {
        best = reduced;
        entering = variable;
      }
    }
    if (entering != kNoVariable) return entering;
  }
  return kNoVariable;
}

void LargestReducedCost::Refill(const PackingLp& lp, std::int64_t* work) {
  *work += static_cast<std::int64_t>(cheaper_.size() + pool_.size());
  for (const std::int32_t r : cheaper_) {
    is_cheaper_[At(r)] = 0;
    pool_.Add(~r);
    for (const std::int32_t j : lp.columns_at(r)) {
      if (!lp.IsBasic(j) && lp.ReducedCost(j) > kReducedCost) pool_.Add(j);
    }
    *work += static_cast<std::int64_t>(lp.columns_at(r).size());
  }
  cheaper_.clear();
  candidates_.clear();
  pool_.KeepIf([&](std::int32_t variable) {
    if (lp.IsBasic(variable)) return false;
    const double reduced = lp.ReducedCost(variable);
    if (reduced <= kReducedCost) return false;
    candidates_.emplace_back(reduced, variable);
    return true;
  });
  if (candidates_.size() > 2 * kCandidates) {
    std::nth_element(candidates_.begin(), candidates_.begin() + kCandidates, candidates_.end(),
                     std::greater<>());
    candidates_.resize(kCandidates);
  }
}

Devex::Devex(const PackingLp& lp, std::int64_t* work)
    : pool_(lp.prices().size()), slack_weight_(lp.prices().size()) {
  for (std::int32_t j = 0; j < lp.n_columns(); ++j) Changed(lp, j);
  for (std::int32_t r = 0; At(r) < slack_weight_.size(); ++r) Changed(lp, ~r);
  Restart(lp, work);
}

void Devex::Changed(const PackingLp& lp, std::int32_t variable) {
  if (variable >= 0) {
    if (At(variable) == reduced_.size()) {
      reduced_.push_back(0);
      column_weight_.push_back(1);
      reached_at_.push_back(0);
    }
    reduced_[At(variable)] = lp.ReducedCost(variable);
  }
  pool_.Add(variable);
}

void Devex::BasicCostChanged(const PackingLp& lp, const InverseRow& row, double change,
                             std::int64_t* work) {
  Move(lp, row, change, 0, work);
}

void Devex::Pivoted(const PackingLp& lp, const InverseRow& row, std::int32_t entering,
                    std::int32_t leaving, double reduced, double pivot, std::int64_t* work) {
  const double weight = Weight(entering) / (pivot * pivot);
  if (leaving >= 0) reduced_[At(leaving)] = 0;
  Move(lp, row, reduced / pivot, weight, work);
  Weight(leaving) = std::max(weight, 1.0);
  if (weight > kMostWeight) Restart(lp, work);
}

void Devex::Move(const PackingLp& lp, const InverseRow& row, double by, double weight,
                 std::int64_t* work) {
  fresh_ = false;
  std::size_t reached = 0;
  for (const std::int32_t r : row.rows) {
    slack_weight_[At(r)] = std::max(slack_weight_[At(r)], weight * row.at(r) * row.at(r));
    if (lp.ReducedCost(~r) > kReducedCost) pool_.Add(~r);
    reached += lp.columns_at(r).size();
  }
  const auto move = [&](std::int32_t j) {
    const auto& rows = lp.rows(j);
    double entry = row.at(rows[0]) + row.at(rows[1]) + row.at(rows[2]);
    for (const std::int32_t r : lp.more_rows(j)) entry += row.at(r);
    if (entry == 0) return;
    reduced_[At(j)] -= by * entry;
    column_weight_[At(j)] = std::max(column_weight_[At(j)], weight * entry * entry);
    if (reduced_[At(j)] > kReducedCost) pool_.Add(j);
  };
  if (reached >= reduced_.size()) {
    for (std::int32_t j = 0; j < lp.n_columns(); ++j) move(j);
    *work += lp.n_columns();
    return;
  }
  ++move_;
  for (const std::int32_t r : row.rows) {
    for (const std::int32_t j : lp.columns_at(r)) {
      if (reached_at_[At(j)] == move_) continue;
      reached_at_[At(j)] = move_;
      move(j);
    }
  }
  *work += static_cast<std::int64_t>(reached);
}

void Devex::Restart(const PackingLp& lp, std::int64_t* work) {
  std::fill(column_weight_.begin(), column_weight_.end(), 1);
  std::fill(slack_weight_.begin(), slack_weight_.end(), 1);
  Refresh(lp, work);
}

void Devex::Refresh(const PackingLp& lp, std::int64_t* work) {
  for (std::int32_t j = 0; j < lp.n_columns(); ++j) {
    reduced_[At(j)] = lp.ReducedCost(j);
    if (reduced_[At(j)] > kReducedCost && !lp.IsBasic(j)) pool_.Add(j);
  }
  for (std::int32_t r = 0; At(r) < slack_weight_.size(); ++r) {
    if (lp.ReducedCost(~r) > kReducedCost && !lp.IsBasic(~r)) pool_.Add(~r);
  }
  fresh_ = true;
  *work += lp.n_columns();
}

std::int32_t Devex::Entering(const PackingLp& lp, std::int64_t* work) {
  while (true) {
    const std::int32_t variable = Best(lp, work);
    if (variable == kNoVariable) {
      if (fresh_) return kNoVariable;
      Refresh(lp, work);
      continue;
    }
    const double reduced = lp.ReducedCost(variable);
    if (reduced > kReducedCost) return variable;
    reduced_[At(variable)] = reduced;  // of a column, as that of a slack is never off
  }
}

std::int32_t Devex::Best(const PackingLp& lp, std::int64_t* work) {
  // No more than a step costs: where steps are cheap, this would be most of it.
  const std::int64_t most =
      std::min(*work - compared_at_ + kCompared, static_cast<std::int64_t>(pool_.size()));
  double best = 0;
  std::int32_t entering = kNoVariable;
  std::int64_t compared = 0;
  for (; !pool_.empty() && (compared < most || entering == kNoVariable); ++compared) {
    if (next_in_pool_ >= pool_.size()) next_in_pool_ = 0;
    const std::int32_t variable = pool_[next_in_pool_];
    const double merit = Merit(lp, variable);
    if (merit > best) {
      best = merit;
      entering = variable;
    }
    if (merit > 0) {
      ++next_in_pool_;
    } else {
      pool_.Drop(next_in_pool_);
    }
  }
  *work += compared;
  compared_at_ = *work;
  return entering;
}

double Devex::Merit(const PackingLp& lp, std::int32_t variable) {
  if (lp.IsBasic(variable)) return 0;
  const double reduced = variable >= 0 ? reduced_[At(variable)] : lp.ReducedCost(variable);
  return reduced <= kReducedCost ? 0 : reduced * reduced / Weight(variable);
}

}  // namespace muster::scheduler
