#include "scheduler/solver/matchings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "scheduler/solver/parallel.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kIdle = 9;          ///< matchings of the three kinds in turn that may gain nothing
constexpr Index kMorePlaces = 3;  ///< of a site, besides those in use, that pairs are matched to

}  // namespace

Matchings::Matchings(const Instance& instance, const Dual& dual, int threads)
    : instance_(instance), dual_(dual), planner_(instance, dual), threads_(threads) {}

void Matchings::Improve(Plan* plan, const std::function<bool()>& stop) {
  if (uav_arcs_.begin.empty()) {
    uav_arcs_ = UavArcsOf(instance_);
    partner_arcs_ = PartnerArcsOf(instance_);
    work_ += static_cast<std::int64_t>(uav_arcs_.site_arc.size() + partner_arcs_.site_arc.size());
  }
  regret_.assign(instance_.partner_arcs.size(), std::numeric_limits<double>::quiet_NaN());
  planner_.Weigh(plan);
  int idle = 0;
  for (std::uint32_t round = 0; idle < kIdle && !stop(); ++round) {
    Plan next = round % 3 == 0   ? MatchUavs(*plan, round)
                : round % 3 == 1 ? MatchSites(*plan)
                                 : MatchPartners(*plan);
    work_ += planner_.Fill(&next);
    planner_.Weigh(&next);
    if (next.weight > plan->weight + kNegligible) {
      *plan = std::move(next);
      idle = 0;
    } else {
      ++idle;
    }
  }
}

Column Matchings::ColumnOf(Index uav, Index partner, Index site) const {
  const Index i = uav_arcs_.Find(uav, site);
  const Index j = partner < 0 ? -1 : partner_arcs_.Find(partner, site);
  if (i < 0 || (partner >= 0 && j < 0)) return {};
  return {site, i, j, 0};
}

double Matchings::WeightOf(const Column& column) const {
  if (column.site < 0) return -kInfinity;
  const Instance::UavArc& arc = instance_.uav_arcs[At(column.uav_arc)];
  if (column.partner_arc < 0) return arc.solo;
  const Instance::PartnerArc& partner = instance_.partner_arcs[At(column.partner_arc)];
  if (arc.pair_gain == Instance::kNone || !instance_.Compatible(arc, partner)) return -kInfinity;
  return Instance::PairWeight(arc, partner);
}

double Matchings::OwnWeight(const Plan& plan, Index partner) const {
  const Dual::Solo* own = plan.own[At(partner)];
  return own != nullptr ? own->weight : instance_.partners[At(partner)].stay;
}

void Matchings::PutIfFree(Plan* plan, Index uav, const Column& column) const {
  if (column.site >= 0 && planner_.IsFree(*plan, column)) planner_.Put(plan, uav, column);
}

/// UAVs and partners that go alone do so still, where they are not matched.
void Matchings::KeepOwn(const Plan& before, Plan* plan) const {
  for (Index u = 0; u < instance_.n_uavs(); ++u) {
    const Column& column = before.column[At(u)];
    if (plan->column[At(u)].site < 0 && column.partner_arc < 0) PutIfFree(plan, u, column);
  }
  for (Index p = 0; p < instance_.n_partners(); ++p) {
    const Dual::Solo* own = before.own[At(p)];
    if (own == nullptr || plan->partner_of[At(p)] >= 0) continue;
    if (plan->free_places[At(own->site)] <= 0) continue;
    plan->own[At(p)] = own;
    --plan->free_places[At(own->site)];
  }
}

template <class Add>
Matchings::Edges Matchings::EdgesOf(std::size_t n_rows, const Add& add) const {
  std::array<Edges, 2> halves;
  ParallelFor(n_rows, threads_, 500, [&](std::size_t begin, std::size_t end) {
    Edges& edges = halves[begin == 0 ? 0 : 1];
    for (std::size_t k = begin; k < end; ++k) {
      add(k, &edges);
      edges.EndRow();
    }
  });
  Edges edges = std::move(halves[0]);
  const std::size_t n_first = edges.all.size();
  edges.all.insert(edges.all.end(), halves[1].all.begin(), halves[1].all.end());
  for (std::size_t k = 1; k < halves[1].begin.size(); ++k) {
    edges.begin.push_back(n_first + halves[1].begin[k]);
  }
  return edges;
}

/// UAVs stay at their sites.
Plan Matchings::MatchPartners(const Plan& plan) {
  std::vector<Index> rows;
  for (Index u = 0; u < instance_.n_uavs(); ++u) {
    if (plan.column[At(u)].site >= 0) rows.push_back(u);
  }
  const Edges edges = EdgesOf(rows.size(), [&](std::size_t k, Edges* of_row) {
    const Index u = rows[k], site = plan.column[At(u)].site;
    const Column own = ColumnOf(u, -1, site);
    const double alone = std::max(instance_.uavs[At(u)].stay, WeightOf(own));
    for (Index j = instance_.partner_begin[At(site)]; j < instance_.partner_begin[At(site) + 1];
         ++j) {
      const Index p = instance_.partner_arcs[At(j)].partner;
      of_row->Add(p, WeightOf({site, own.uav_arc, j, 0}) - alone - OwnWeight(plan, p));
    }
  });
  const std::vector<Index> matched = Match(At(instance_.n_partners()), edges);
  Plan next = planner_.Empty();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Index site = plan.column[At(rows[k])].site;
    if (matched[k] >= 0) PutIfFree(&next, rows[k], ColumnOf(rows[k], matched[k], site));
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Column alone = ColumnOf(rows[k], -1, plan.column[At(rows[k])].site);
    if (matched[k] < 0 && WeightOf(alone) > instance_.uavs[At(rows[k])].stay) {
      PutIfFree(&next, rows[k], alone);
    }
  }
  KeepOwn(plan, &next);
  return next;
}

/// Pairs and UAVs alone stay what they are.
Plan Matchings::MatchSites(const Plan& plan) {
  std::vector<Half> rows;
  std::vector<Index> used(instance_.capacity.size(), 0);
  for (Index u = 0; u < instance_.n_uavs(); ++u) {
    const Column& column = plan.column[At(u)];
    if (column.site < 0) continue;
    rows.push_back({u, planner_.PartnerOf(column), -1});
    ++used[At(column.site)];
  }
  std::vector<Index> place_begin(1, 0), places;
  for (Index s = 0; s < instance_.n_sites(); ++s) {
    const Index n = used[At(s)] + std::min(plan.free_places[At(s)], kMorePlaces);
    places.insert(places.end(), At(n), s);
    place_begin.push_back(static_cast<Index>(places.size()));
  }
  const Edges edges = EdgesOf(rows.size(), [&](std::size_t row, Edges* of_row) {
    const Half& half = rows[row];
    double least = instance_.uavs[At(half.uav)].stay;
    if (half.partner >= 0) least += instance_.partners[At(half.partner)].stay;
    for (const auto& [site, arc] :
         half.partner >= 0 ? partner_arcs_.of(half.partner) : uav_arcs_.of(half.uav)) {
      const double gain = WeightOf(ColumnOf(half.uav, half.partner, site)) - least;
      for (Index k = place_begin[At(site)]; k < place_begin[At(site) + 1]; ++k) {
        of_row->Add(k, gain);
      }
    }
  });
  const std::vector<Index> matched = Match(places.size(), edges);
  Plan next = planner_.Empty();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (matched[k] < 0) continue;
    PutIfFree(&next, rows[k].uav, ColumnOf(rows[k].uav, rows[k].partner, places[At(matched[k])]));
  }
  KeepOwn(plan, &next);
  return next;
}

/// Partners stay at their sites; those without one go where a UAV would rather have them.
Plan Matchings::MatchUavs(const Plan& plan, std::uint32_t round) {
  std::vector<Half> rows;
  for (const Column& column : plan.column) {
    if (column.partner_arc >= 0) rows.push_back({-1, planner_.PartnerOf(column), column.site});
  }
  FindRegrets(plan);
  Plan rest = plan;  // but for the places that these take
  for (Index p = 0; p < instance_.n_partners(); ++p) {
    if (plan.partner_of[At(p)] >= 0) continue;
    const Index site = plan.own[At(p)] != nullptr ? plan.own[At(p)]->site : SiteFor(rest, p, round);
    if (site < 0) continue;
    if (plan.own[At(p)] == nullptr) --rest.free_places[At(site)];
    rows.push_back({-1, p, site});
  }
  const Edges edges = EdgesOf(rows.size(), [&](std::size_t k, Edges* of_row) {
    const Half& half = rows[k];
    const double own = OwnWeight(plan, half.partner);
    const Index j = partner_arcs_.Find(half.partner, half.site);
    for (Index i = instance_.uav_begin[At(half.site)]; i < instance_.uav_begin[At(half.site) + 1];
         ++i) {
      const Index u = instance_.uav_arcs[At(i)].uav;
      const Column& column = plan.column[At(u)];
      const double alone =
          column.partner_arc < 0 ? planner_.WeightOf(u, column) : instance_.uavs[At(u)].stay;
      of_row->Add(u, WeightOf({half.site, i, j, 0}) - own - alone);
    }
  });
  const std::vector<Index> matched = Match(At(instance_.n_uavs()), edges);
  Plan next = planner_.Empty();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (matched[k] < 0) continue;
    PutIfFree(&next, matched[k], ColumnOf(matched[k], rows[k].partner, rows[k].site));
  }
  KeepOwn(plan, &next);
  return next;
}

/// Sets the regrets that SiteFor asks for.
void Matchings::FindRegrets(const Plan& plan) {
  ParallelFor(instance_.partners.size(), threads_, 500, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      if (plan.partner_of[p] >= 0 || plan.own[p] != nullptr) continue;
      for (const auto& [s, j] : partner_arcs_.of(static_cast<Index>(p))) {
        if (plan.free_places[At(s)] > 0 && std::isnan(regret_[At(j)])) {
          regret_[At(j)] = LeastRegret(s, j);
        }
      }
    }
  });
}

/// The least regret of a UAV that goes to the site with the partner; infinity: none can.
double Matchings::LeastRegret(Index s, Index j) const {
  double regret = kInfinity;
  for (Index i = instance_.uav_begin[At(s)]; i < instance_.uav_begin[At(s) + 1]; ++i) {
    const Column column{s, i, j, 0};
    if (WeightOf(column) == -kInfinity) continue;
    regret = std::min(regret, planner_.Regret(instance_.uav_arcs[At(i)].uav, column));
  }
  return regret;
}

/// A site with a free place where the partner loses least with any UAV; of equal ones another in
/// each round. -1: none.
Index Matchings::SiteFor(const Plan& plan, Index partner, std::uint32_t round) {
  constexpr double kAlike = 1e-4;
  double least = kInfinity;
  Index best = -1;
  std::uint32_t best_mix = 0;
  for (const auto& [s, j] : partner_arcs_.of(partner)) {
    if (plan.free_places[At(s)] <= 0) continue;
    work_ += instance_.uav_begin[At(s) + 1] - instance_.uav_begin[At(s)];
    // The site's price is lost where nobody takes it.
    const double regret = regret_[At(j)] - dual_.site_price(s);
    const std::uint32_t mix = Mix(std::uint64_t{round} << 40 ^ At(s) << 20 ^ At(partner));
    if (regret < least - kAlike || (regret < least + kAlike && mix > best_mix && best >= 0)) {
      least = std::min(least, regret);
      best = s;
      best_mix = mix;
    }
  }
  return best;
}

std::vector<Index> Matchings::Match(std::size_t n_columns, const Edges& edges) {
  const std::size_t n_rows = edges.begin.size() - 1;
  // Costs are gains below zero. A row may also stay without a column, at no cost.
  std::vector<double> row_potential(n_rows, 0), column_potential(n_columns, 0);
  std::vector<Index> row_of(n_columns, -1), column_of(n_rows, -1);
  std::vector<double> distance(n_columns, kInfinity);
  std::vector<Index> before(n_columns, -1);  // the row that a column was reached from
  std::vector<char> passed(n_columns, 0);
  std::vector<Index> reached;
  using Next = std::pair<double, Index>;
  std::priority_queue<Next, std::vector<Next>, std::greater<>> queue;
  const auto potential_of = [&](Index row) -> double& { return row_potential[At(row)]; };
  for (Index first = 0; At(first) < n_rows; ++first) {
    for (std::size_t k = edges.begin[At(first)]; k < edges.begin[At(first) + 1]; ++k) {
      const Edge& edge = edges.all[k];
      potential_of(first) =
          std::min(potential_of(first), -edge.gain - column_potential[At(edge.column)]);
    }
    // The row that is cheapest to leave without a column, and the cheapest free column.
    double least = kInfinity;
    Index without = -1, free = -1;
    const auto reach_from = [&](Index row, double so_far) {
      if (so_far - potential_of(row) < least) {
        least = so_far - potential_of(row);
        without = row;
      }
      for (std::size_t k = edges.begin[At(row)]; k < edges.begin[At(row) + 1]; ++k) {
        const auto& [column, gain] = edges.all[k];
        const double to = so_far - gain - potential_of(row) - column_potential[At(column)];
        if (passed[At(column)] || to >= distance[At(column)] || to >= least) continue;
        if (distance[At(column)] == kInfinity) reached.push_back(column);
        distance[At(column)] = to;
        before[At(column)] = row;
        queue.emplace(to, column);
      }
      work_ += 4 * static_cast<std::int64_t>(edges.begin[At(row) + 1] - edges.begin[At(row)]);
    };
    reach_from(first, 0);
    while (!queue.empty() && queue.top().first < least) {
      const auto [so_far, column] = queue.top();
      queue.pop();
      if (passed[At(column)] || so_far > distance[At(column)]) continue;
      if (row_of[At(column)] < 0) {
        least = so_far;
        free = column;
        break;
      }
      passed[At(column)] = 1;
      reach_from(row_of[At(column)], so_far);
    }
    potential_of(first) += least;
    for (const Index column : reached) {
      if (!passed[At(column)]) continue;
      column_potential[At(column)] -= least - distance[At(column)];
      potential_of(row_of[At(column)]) += least - distance[At(column)];
    }
    Index column = free;
    if (free < 0) {
      column = column_of[At(without)];
      column_of[At(without)] = -1;
    }
    while (column >= 0) {
      const Index row = before[At(column)];
      const Index rest = column_of[At(row)];
      row_of[At(column)] = row;
      column_of[At(row)] = column;
      if (row == first) break;
      column = rest;
    }
    for (const Index c : reached) {
      distance[At(c)] = kInfinity;
      passed[At(c)] = 0;
    }
    reached.clear();
    queue = {};
  }
  return column_of;
}

}  // namespace muster::scheduler
