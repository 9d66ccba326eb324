#include "scheduler/solver/plan.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <tuple>

namespace muster::scheduler {
namespace {
using Index = std::int32_t;
}

Plan Planner::Empty() const {
  Plan plan;
  plan.column.resize(instance_.uavs.size());
  plan.partner_of.assign(instance_.partners.size(), -1);
  plan.own.assign(instance_.partners.size(), nullptr);
  plan.free_places = instance_.capacity;
  return plan;
}

bool Planner::IsFree(const Plan& plan, const Column& column) const {
  const Index p = PartnerOf(column);
  return (column.site < 0 || plan.free_places[At(column.site)] > 0) &&
         (p < 0 || (plan.partner_of[At(p)] < 0 && plan.own[At(p)] == nullptr));
}

void Planner::Put(Plan* plan, Index uav, const Column& column) const {
  plan->column[At(uav)] = column;
  if (column.site >= 0) --plan->free_places[At(column.site)];
  if (column.partner_arc >= 0) plan->partner_of[At(PartnerOf(column))] = uav;
}

void Planner::Remove(Plan* plan, Index uav) const {
  const Column& column = plan->column[At(uav)];
  if (column.site >= 0) ++plan->free_places[At(column.site)];
  if (column.partner_arc >= 0) plan->partner_of[At(PartnerOf(column))] = -1;
  plan->column[At(uav)] = Column{};
}

double Planner::WeightOf(Index uav, const Column& column) const {
  if (column.site < 0) return instance_.uavs[At(uav)].stay;
  const Instance::UavArc& arc = instance_.uav_arcs[At(column.uav_arc)];
  if (column.partner_arc < 0) return arc.solo;
  return Instance::PairWeight(arc, instance_.partner_arcs[At(column.partner_arc)]);
}

void Planner::Weigh(Plan* plan) const {
  plan->weight = 0;
  for (Index u = 0; u < instance_.n_uavs(); ++u) {
    plan->weight += WeightOf(u, plan->column[At(u)]);
  }
  for (std::size_t p = 0; p < plan->partner_of.size(); ++p) {
    if (plan->partner_of[p] >= 0) continue;
    plan->weight += plan->own[p] != nullptr ? plan->own[p]->weight : instance_.partners[p].stay;
  }
}

double Planner::Regret(Index uav, const Column& column) const {
  const double price = column.site < 0 ? 0 : dual_.site_price(column.site);
  const double partner = column.partner_arc < 0 ? 0 : dual_.partner_value(PartnerOf(column));
  return std::max(0.0, dual_.best_value(uav) - (WeightOf(uav, column) - price - partner));
}

double Planner::OwnRegret(Index partner, const Dual::Solo* own) const {
  const double value = own == nullptr ? instance_.partners[At(partner)].stay
                                      : own->weight - dual_.site_price(own->site);
  return std::max(0.0, dual_.partner_value(partner) - value);
}

std::int64_t Planner::Fill(Plan* plan) const {
  std::int64_t work = 0;
  std::vector<char> partner_free(instance_.partners.size());
  for (std::size_t p = 0; p < partner_free.size(); ++p) {
    partner_free[p] = plan->partner_of[p] < 0 && plan->own[p] == nullptr;
  }
  using Entry = std::tuple<double, double, Index>;  // regret, -value, agent
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<Column> next(instance_.uavs.size());
  for (Index u = 0; u < instance_.n_uavs(); ++u) {
    if (plan->column[At(u)].site >= 0) continue;
    next[At(u)] = dual_.best(u);
    queue.emplace(0.0, -dual_.best_value(u), u);
  }
  while (!queue.empty()) {
    const Index u = std::get<2>(queue.top());
    queue.pop();
    const Column& column = next[At(u)];
    if (!IsFree(*plan, column)) {
      next[At(u)] = dual_.BestFree(u, plan->free_places, partner_free);
      work += 8 * dual_.n_arcs(u);
      queue.emplace(next[At(u)].regret, -dual_.best_value(u), u);
      continue;
    }
    Put(plan, u, column);
    if (const Index p = PartnerOf(column); p >= 0) partner_free[At(p)] = 0;
  }
  const auto best_own = [&](Index p) {
    const Dual::Solo* best = nullptr;
    for (const Dual::Solo& solo : dual_.solos(p)) {
      if (plan->free_places[At(solo.site)] > 0 && OwnRegret(p, &solo) < OwnRegret(p, best)) {
        best = &solo;
      }
    }
    return best;
  };
  std::vector<const Dual::Solo*> own(instance_.partners.size(), nullptr);
  for (Index p = 0; p < instance_.n_partners(); ++p) {
    if (!partner_free[At(p)] || dual_.solos(p).empty()) continue;
    own[At(p)] = best_own(p);
    queue.emplace(OwnRegret(p, own[At(p)]), 0.0, p);
  }
  while (!queue.empty()) {
    const Index p = std::get<2>(queue.top());
    queue.pop();
    const Dual::Solo*& solo = own[At(p)];
    if (solo != nullptr && plan->free_places[At(solo->site)] <= 0) {
      solo = best_own(p);
      queue.emplace(OwnRegret(p, solo), 0.0, p);
      continue;
    }
    plan->own[At(p)] = solo;
    if (solo != nullptr) --plan->free_places[At(solo->site)];
  }
  return work;
}

Index Planner::HolderOf(const Plan& plan, Index site, Index rather) const {
  if (rather >= 0 && plan.column[At(rather)].site == site) return rather;
  for (Index i = instance_.uav_begin[At(site)]; i < instance_.uav_begin[At(site) + 1]; ++i) {
    const Index u = instance_.uav_arcs[At(i)].uav;
    if (plan.column[At(u)].site == site) return u;
  }
  return -1;
}

Index Planner::SoloAt(const Plan& plan, Index site) const {
  for (Index j = instance_.partner_begin[At(site)]; j < instance_.partner_begin[At(site) + 1];
       ++j) {
    const Index p = instance_.partner_arcs[At(j)].partner;
    if (plan.own[At(p)] != nullptr && plan.own[At(p)]->site == site) return p;
  }
  return -1;
}

}  // namespace muster::scheduler
