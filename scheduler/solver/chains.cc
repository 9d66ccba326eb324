#include "scheduler/solver/chains.h"

#include <algorithm>
#include <limits>
#include <queue>
#include <utility>

namespace muster::scheduler {
namespace {

using Index = std::int32_t;
constexpr int kChainLinks = 64;  ///< UAVs that a chain may look at

}  // namespace

Chains::Chains(const Instance& instance, const Dual& dual)
    : instance_(instance),
      dual_(dual),
      planner_(instance, dual),
      label_(instance.uavs.size(), std::numeric_limits<double>::infinity()) {}

void Chains::Improve(Plan* plan, const std::function<bool()>& stop) {
  for (bool again = true; again;) {
    again = false;
    for (Index u = 0; u < instance_.n_uavs() && !stop(); ++u) {
      if (planner_.Regret(u, plan->column[At(u)]) <= kNegligible) continue;
      if (Chain(plan, u)) again = true;
    }
  }
}

/// Best chain "u takes what v holds, v takes what w holds, ..., the last takes what is free" by
/// regret, cheapest first, each UAV at most once. True when it makes the plan better.
bool Chains::Chain(Plan* plan, Index seed) {
  links_.clear();
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  touched_.clear();
  const auto label = [&](Index u) -> double& {
    if (label_[At(u)] == std::numeric_limits<double>::infinity()) touched_.push_back(u);
    return label_[At(u)];
  };
  links_.push_back({seed, -1, -planner_.Regret(seed, plan->column[At(seed)]), {}});
  label(seed) = links_[0].loss;
  queue.emplace(links_[0].loss, 0);
  double best = -kNegligible;
  Index last = -1;
  Column last_column;
  for (int expanded = 0; !queue.empty() && expanded < kChainLinks; ++expanded) {
    const auto [loss, k] = queue.top();
    queue.pop();
    if (loss >= best) break;
    const Index u = links_[At(k)].uav;
    if (loss > label_[At(u)]) continue;
    columns_.clear();
    dual_.ColumnsOf(u, best - loss, &columns_);
    work_ += 8 * dual_.n_arcs(u) + static_cast<std::int64_t>(columns_.size());
    for (const Column& column : columns_) {
      const double total = loss + column.regret;
      if (total >= best || TakenOnChain(k, column)) continue;
      Index owner = -1;
      if (const Index p = planner_.PartnerOf(column); p >= 0) owner = plan->partner_of[At(p)];
      if (owner == u) owner = -1;
      if (column.site >= 0 && plan->free_places[At(column.site)] <= 0 &&
          plan->column[At(u)].site != column.site) {
        const Index holder = planner_.HolderOf(*plan, column.site, owner);
        if (holder >= 0 && owner >= 0 && holder != owner) continue;
        if (holder >= 0) owner = holder;
      }
      if (owner < 0) {
        best = total;
        last = k;
        last_column = column;
        continue;
      }
      const double next = total - planner_.Regret(owner, plan->column[At(owner)]);
      if (next >= best || next >= label(owner) || OnChain(k, owner)) continue;
      label(owner) = next;
      queue.emplace(next, static_cast<Index>(links_.size()));
      links_.push_back({owner, k, next, column});
    }
  }
  for (const Index u : touched_) label_[At(u)] = std::numeric_limits<double>::infinity();
  if (last < 0) return false;

  return CarryOut(plan, last, last_column);
}

/// What it displaces besides, a partner on its own, stays where it is. True when that is better.
bool Chains::CarryOut(Plan* plan, Index last, const Column& last_column) {
  std::vector<std::pair<Index, Column>> before, after;
  Column takes = last_column;
  for (Index k = last; k >= 0; k = links_[At(k)].parent) {
    before.emplace_back(links_[At(k)].uav, plan->column[At(links_[At(k)].uav)]);
    after.emplace_back(links_[At(k)].uav, takes);
    takes = links_[At(k)].takes;
  }
  double gain = 0;
  for (const auto& [u, column] : before) {
    gain -= planner_.WeightOf(u, column);
    if (column.partner_arc >= 0) gain += instance_.partners[At(planner_.PartnerOf(column))].stay;
    planner_.Remove(plan, u);
  }
  std::vector<std::pair<Index, const Dual::Solo*>> displaced;
  const auto displace = [&](Index p) {
    const Dual::Solo* own = plan->own[At(p)];
    if (own == nullptr) return;
    gain -= own->weight - instance_.partners[At(p)].stay;
    displaced.emplace_back(p, own);
    ++plan->free_places[At(own->site)];
    plan->own[At(p)] = nullptr;
  };
  bool valid = true;
  std::size_t put = 0;
  for (; put < after.size(); ++put) {
    const auto& [u, column] = after[put];
    gain += planner_.WeightOf(u, column);
    if (const Index p = planner_.PartnerOf(column); p >= 0) {
      if (plan->partner_of[At(p)] >= 0) {
        valid = false;
        break;
      }
      gain -= instance_.partners[At(p)].stay;
      displace(p);
    }
    if (column.site >= 0 && plan->free_places[At(column.site)] <= 0) {
      const Index p = planner_.SoloAt(*plan, column.site);
      if (p < 0) {
        valid = false;
        break;
      }
      displace(p);
    }
    planner_.Put(plan, u, column);
  }
  if (valid && gain > kNegligible) return true;
  for (std::size_t k = 0; k < put; ++k) planner_.Remove(plan, after[k].first);
  for (const auto& [u, column] : before) planner_.Put(plan, u, column);
  for (const auto& [p, own] : displaced) {
    plan->own[At(p)] = own;
    --plan->free_places[At(own->site)];
  }
  return false;
}

bool Chains::OnChain(Index link, Index uav) const {
  for (Index k = link; k >= 0; k = links_[At(k)].parent) {
    if (links_[At(k)].uav == uav) return true;
  }
  return false;
}
/// Whether a column of the chain takes what this one needs.
bool Chains::TakenOnChain(Index link, const Column& column) const {
  const Index partner = planner_.PartnerOf(column);
  for (Index k = link; k >= 0; k = links_[At(k)].parent) {
    const Column& takes = links_[At(k)].takes;
    if (takes.site >= 0 && takes.site == column.site) return true;
    if (partner >= 0 && planner_.PartnerOf(takes) == partner) return true;
  }
  return false;
}

}  // namespace muster::scheduler
