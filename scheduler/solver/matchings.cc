#include "scheduler/solver/matchings.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace muster::scheduler {
namespace {

using Index = std::int32_t;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kIdle = 9;          ///< matchings of the three kinds in turn that may gain nothing
constexpr Index kMorePlaces = 3;  ///< of a site, besides those in use, that pairs are matched to

}  // namespace

Matchings::Matchings(const Instance& instance, const Dual& dual)
    : instance_(instance), dual_(dual), planner_(instance, dual) {}

void Matchings::Improve(Plan* plan, const std::function<bool()>& stop) {
  const auto n_sites = At(instance_.n_sites());
  if (uav_arc_.empty()) {
    uav_arc_.assign(instance_.uavs.size() * n_sites, -1);
    partner_arc_.assign(instance_.partners.size() * n_sites, -1);
    for (std::size_t s = 0; s < n_sites; ++s) {
      for (Index i = instance_.uav_begin[s]; i < instance_.uav_begin[s + 1]; ++i) {
        uav_arc_[At(instance_.uav_arcs[At(i)].uav) * n_sites + s] = i;
      }
      for (Index j = instance_.partner_begin[s]; j < instance_.partner_begin[s + 1]; ++j) {
        partner_arc_[At(instance_.partner_arcs[At(j)].partner) * n_sites + s] = j;
      }
    }
    work_ += static_cast<std::int64_t>(uav_arc_.size() + partner_arc_.size());
  }
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
  const auto n_sites = At(instance_.n_sites());
  const Index i = uav_arc_[At(uav) * n_sites + At(site)];
  const Index j = partner < 0 ? -1 : partner_arc_[At(partner) * n_sites + At(site)];
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

/// UAVs stay at their sites.
Plan Matchings::MatchPartners(const Plan& plan) {
  std::vector<Index> rows;
  for (Index u = 0; u < instance_.n_uavs(); ++u) {
    if (plan.column[At(u)].site >= 0) rows.push_back(u);
  }
  const auto n = At(instance_.n_partners());
  std::vector<double> gains;
  for (const Index u : rows) {
    const Index site = plan.column[At(u)].site;
    const double alone = std::max(instance_.uavs[At(u)].stay, WeightOf(ColumnOf(u, -1, site)));
    for (Index p = 0; At(p) < n; ++p) {
      gains.push_back(WeightOf(ColumnOf(u, p, site)) - alone - OwnWeight(plan, p));
    }
  }
  const std::vector<Index> matched = Match(rows.size(), n, gains);
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
  std::vector<Index> places;
  for (Index s = 0; s < instance_.n_sites(); ++s) {
    const Index n = used[At(s)] + std::min(plan.free_places[At(s)], kMorePlaces);
    places.insert(places.end(), At(n), s);
  }
  std::vector<double> gains;
  for (const Half& half : rows) {
    double least = instance_.uavs[At(half.uav)].stay;
    if (half.partner >= 0) least += instance_.partners[At(half.partner)].stay;
    for (std::size_t k = 0; k < places.size(); ++k) {
      gains.push_back(k > 0 && places[k] == places[k - 1]
                          ? gains.back()
                          : WeightOf(ColumnOf(half.uav, half.partner, places[k])) - least);
    }
  }
  const std::vector<Index> matched = Match(rows.size(), places.size(), gains);
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
  Plan rest = plan;  // but for the places that these take
  for (Index p = 0; p < instance_.n_partners(); ++p) {
    if (plan.partner_of[At(p)] >= 0) continue;
    const Index site = plan.own[At(p)] != nullptr ? plan.own[At(p)]->site : SiteFor(rest, p, round);
    if (site < 0) continue;
    if (plan.own[At(p)] == nullptr) --rest.free_places[At(site)];
    rows.push_back({-1, p, site});
  }
  const auto n = At(instance_.n_uavs());
  std::vector<double> gains;
  for (const Half& half : rows) {
    const double own = OwnWeight(plan, half.partner);
    for (Index u = 0; At(u) < n; ++u) {
      const Column& column = plan.column[At(u)];
      const double alone =
          column.partner_arc < 0 ? planner_.WeightOf(u, column) : instance_.uavs[At(u)].stay;
      gains.push_back(WeightOf(ColumnOf(u, half.partner, half.site)) - own - alone);
    }
  }
  const std::vector<Index> matched = Match(rows.size(), n, gains);
  Plan next = planner_.Empty();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (matched[k] < 0) continue;
    PutIfFree(&next, matched[k], ColumnOf(matched[k], rows[k].partner, rows[k].site));
  }
  KeepOwn(plan, &next);
  return next;
}

/// A site with a free place where the partner loses least with any UAV; of equal ones another in
/// each round. -1: none.
Index Matchings::SiteFor(const Plan& plan, Index partner, std::uint32_t round) {
  constexpr double kAlike = 1e-4;
  double least = kInfinity;
  Index best = -1;
  std::uint32_t best_mix = 0;
  for (Index s = 0; s < instance_.n_sites(); ++s) {
    const Index j = partner_arc_[At(partner) * At(instance_.n_sites()) + At(s)];
    if (j < 0 || plan.free_places[At(s)] <= 0) continue;
    // The site's price is lost where nobody takes it.
    double regret = kInfinity;
    for (Index i = instance_.uav_begin[At(s)]; i < instance_.uav_begin[At(s) + 1]; ++i) {
      const Column column{s, i, j, 0};
      if (WeightOf(column) == -kInfinity) continue;
      regret = std::min(regret, planner_.Regret(instance_.uav_arcs[At(i)].uav, column));
    }
    work_ += instance_.uav_begin[At(s) + 1] - instance_.uav_begin[At(s)];
    regret -= dual_.site_price(s);
    const std::uint32_t mix = Mix(std::uint64_t{round} << 40 ^ At(s) << 20 ^ At(partner));
    if (regret < least - kAlike || (regret < least + kAlike && mix > best_mix && best >= 0)) {
      least = std::min(least, regret);
      best = s;
      best_mix = mix;
    }
  }
  return best;
}

std::vector<Index> Matchings::Match(std::size_t n_rows, std::size_t n_columns,
                                    const std::vector<double>& gains) {
  // Columns from 1; then one for each row, which is to gain nothing.
  const std::size_t n = n_columns + n_rows;
  std::vector<double> row_potential(n_rows + 1, 0), column_potential(n + 1, 0), least(n + 1);
  std::vector<std::size_t> row_of(n + 1, 0), before(n + 1, 0);
  std::vector<char> seen(n + 1);
  const auto cost = [&](std::size_t row, std::size_t column) {
    if (column > n_columns) return column - n_columns == row ? 0.0 : 1.0;
    const double gain = gains[(row - 1) * n_columns + column - 1];
    return gain > 0 ? -gain : 1.0;
  };
  for (std::size_t row = 1; row <= n_rows; ++row) {
    row_of[0] = row;
    std::fill(least.begin(), least.end(), kInfinity);
    std::fill(seen.begin(), seen.end(), 0);
    std::size_t column = 0;
    while (row_of[column] != 0) {
      seen[column] = 1;
      const std::size_t from = row_of[column];
      double delta = kInfinity;
      std::size_t next = 0;
      for (std::size_t k = 1; k <= n; ++k) {
        if (seen[k]) continue;
        const double reduced = cost(from, k) - row_potential[from] - column_potential[k];
        if (reduced < least[k]) {
          least[k] = reduced;
          before[k] = column;
        }
        if (least[k] < delta) {
          delta = least[k];
          next = k;
        }
      }
      for (std::size_t k = 0; k <= n; ++k) {
        if (seen[k]) {
          row_potential[row_of[k]] += delta;
          column_potential[k] -= delta;
        } else {
          least[k] -= delta;
        }
      }
      work_ += 2 * static_cast<std::int64_t>(n);
      column = next;
    }
    for (; column != 0; column = before[column]) row_of[column] = row_of[before[column]];
  }
  std::vector<Index> matched(n_rows, -1);
  for (std::size_t k = 1; k <= n_columns; ++k) {
    if (row_of[k] == 0) continue;
    const std::size_t row = row_of[k] - 1;
    if (gains[row * n_columns + k - 1] > 0) matched[row] = static_cast<Index>(k - 1);
  }
  return matched;
}

}  // namespace muster::scheduler
