#include "scheduler/solver/branching.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "scheduler/solver/plan.h"

namespace muster::scheduler {

using Index = std::int32_t;

namespace {
constexpr double kClosedCost = 100;  ///< of a column's worth
constexpr double kLeastClosedCost = 1e4;
}  // namespace

Branching::Branching(PackingLp* lp, std::int32_t n_uavs, double slack, Hooks hooks,
                     double closed_cost)
    : lp_(*lp), n_uavs_(n_uavs), slack_(slack), hooks_(std::move(hooks)) {
  if (closed_cost <= 0) {
    closed_cost = kLeastClosedCost;
    for (Index k = 0; k < lp_.n_columns(); ++k) {
      closed_cost = std::max(closed_cost, kClosedCost * lp_.cost(k));
    }
  }
  lp_.set_closed_cost(closed_cost);
}

double Branching::Search(double above, std::int64_t work_limit) {
  end_ = lp_.work() + work_ + work_limit;
  return Branch(above);
}

Branching::Pick Branching::Fraction() {
  Pick pick;
  for (const bool by_site : {false, true}) {
    shares_.clear();
    for (Index k = 0; k < lp_.n_columns(); ++k) {
      const double value = lp_.value(k);
      // Where a share is not whole, none of its columns is.
      if (value < kWhole || value > 1 - kWhole) continue;
      const auto& rows = lp_.rows(k);
      const bool is_uav = rows[0] >= 0;
      if (!by_site && (!is_uav || rows[1] < 0)) continue;
      shares_.push_back({is_uav ? rows[0] : rows[1], by_site ? rows[2] : rows[1], value});
    }
    std::sort(shares_.begin(), shares_.end(), [](const Share& a, const Share& b) {
      return std::tie(a.agent, a.other, a.value) < std::tie(b.agent, b.other, b.value);
    });
    for (std::size_t k = 0; k < shares_.size();) {
      const Index agent = shares_[k].agent, other = shares_[k].other;
      Pick now{0, agent, other, agent < n_uavs_, by_site};
      for (; k < shares_.size() && shares_[k].agent == agent && shares_[k].other == other; ++k) {
        now.share += shares_[k].value;
      }
      if (now.share < 1 - kWhole && (pick.agent < 0 || now.Miss() < pick.Miss())) pick = now;
    }
    if (pick.agent >= 0) break;
  }
  work_ += lp_.n_columns();
  return pick;
}

double Branching::Branch(double above) {
  const std::int64_t left = end_ - lp_.work() - work_;
  if (left <= 0 || hooks_.stop() || !lp_.Solve(left, hooks_.stop)) return above;
  const double bound = std::min(above, lp_.Bound() + slack_);
  if (bound <= hooks_.best() + kNegligible) return bound;
  const Pick pick = Fraction();
  if (pick.agent < 0) {
    hooks_.whole();
    return bound;
  }
  const bool excludes = !pick.by_site || lp_.capacity(pick.other) == 1;
  const auto agent_of = [&](Index k) {
    return lp_.rows(k)[0] >= 0 ? lp_.rows(k)[0] : lp_.rows(k)[1];
  };
  const auto uses = [&](Index k) { return lp_.rows(k)[pick.by_site ? 2 : 1] == pick.other; };
  double highest = -std::numeric_limits<double>::infinity();
  for (const bool with : {pick.share >= 0.5, pick.share < 0.5}) {
    std::vector<Index> closed;
    for (const Index k : lp_.columns_at(pick.agent)) {
      // A partner that goes alone goes with no UAV.
      const bool is_agent = agent_of(k) == pick.agent;
      if (with ? !is_agent || !uses(k) : is_agent && uses(k)) closed.push_back(k);
    }
    if (with && excludes) {
      for (const Index k : lp_.columns_at(pick.other)) {
        if (agent_of(k) != pick.agent) closed.push_back(k);
      }
    }
    std::sort(closed.begin(), closed.end());
    closed.erase(std::unique(closed.begin(), closed.end()), closed.end());
    std::erase_if(closed, [&](Index k) { return lp_.closed(k); });
    for (const Index k : closed) lp_.Close(k, true);
    const bool required = with && lp_.Require(pick.agent, true);
    // Nothing changed: columns that cannot be used still have a share. Deeper, nothing would.
    const bool same = closed.empty() && !required;
    highest = std::max(highest, same ? bound : Branch(bound));
    if (required) lp_.Require(pick.agent, false);
    for (const Index k : closed) lp_.Close(k, false);
    if (bound <= hooks_.best() + kNegligible) break;
  }
  return std::max(highest, hooks_.best());
}

}  // namespace muster::scheduler
