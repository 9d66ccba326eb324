#include "scheduler/solver/windows.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "scheduler/solver/branching.h"
#include "scheduler/solver/packing_lp.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;

constexpr std::size_t kUavs = 16;             ///< of a window, or twice those that it is made for
constexpr std::size_t kNeighbours = 8;        ///< columns of each whose holders join
constexpr std::size_t kColumns = 32;          ///< of a UAV in a window
constexpr std::int64_t kWorkPerUav = 60'000;  ///< of one search
constexpr double kWorthwhile = 1e-6;  ///< loss that a window is searched for, of the whole weight
constexpr double kEqual = 1e-6;       ///< regrets

}  // namespace

Windows::Windows(const Instance& instance, const Dual& dual, Relaxation* relaxation)
    : instance_(instance),
      dual_(dual),
      relaxation_(*relaxation),
      planner_(instance, dual),
      uav_row_(instance.uavs.size(), -1),
      partner_row_(instance.partners.size(), -1),
      site_row_(instance.capacity.size(), -1) {}

void Windows::ImproveFractions(Plan* plan, const std::function<bool()>& stop) {
  PackingLp& lp = *relaxation_.lp();
  std::vector<char> seen(At(lp.n_columns()), 0);
  const auto is_fraction = [&](Index k) {
    const double value = lp.value(k);
    return value > Branching::kWhole && value < 1 - Branching::kWhole;
  };
  for (Index k = 0; k < lp.n_columns() && !stop(); ++k) {
    if (seen[At(k)] || !is_fraction(k)) continue;
    // Fractional columns that hang together through their rows.
    std::vector<Index> columns = {k};
    seen[At(k)] = 1;
    std::vector<Index> uavs;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto& rows = lp.rows(columns[i]);
      if (rows[0] >= 0) uavs.push_back(rows[0]);
      for (const Index row : rows) {
        if (row < 0) continue;
        for (const Index other : lp.columns_at(row)) {
          if (seen[At(other)] || !is_fraction(other)) continue;
          seen[At(other)] = 1;
          columns.push_back(other);
        }
        work_ += static_cast<std::int64_t>(lp.columns_at(row).size());
      }
    }
    std::sort(uavs.begin(), uavs.end());
    uavs.erase(std::unique(uavs.begin(), uavs.end()), uavs.end());
    Improve(plan, std::move(uavs), stop);
  }
  work_ += lp.n_columns();
}

void Windows::ImproveLosers(Plan* plan, const std::function<bool()>& stop) {
  const double least = kWorthwhile * relaxation_.bound();
  std::vector<std::pair<double, Index>> losers;
  for (Index u = 0; u < instance_.n_uavs(); ++u) {
    const double regret = planner_.Regret(u, plan->column[At(u)]);
    if (regret > least) losers.emplace_back(-regret, u);
  }
  work_ += instance_.n_uavs();
  std::sort(losers.begin(), losers.end());
  for (const auto& [loss, u] : losers) {
    if (stop()) return;
    if (planner_.Regret(u, plan->column[At(u)]) > least) Improve(plan, {u}, stop);
  }
}

/// Adds UAVs that hold what those in the window would rather have.
void Windows::Widen(const Plan& plan, std::vector<Index>* uavs) {
  const std::size_t most = std::max(kUavs, 2 * uavs->size());
  for (const Index u : *uavs) uav_row_[At(u)] = 0;
  const auto join = [&](Index u) {
    if (u < 0 || uav_row_[At(u)] >= 0 || uavs->size() >= most) return;
    uav_row_[At(u)] = 0;
    uavs->push_back(u);
  };
  double loss = kEqual;
  for (const Index u : *uavs) loss += planner_.Regret(u, plan.column[At(u)]);
  for (std::size_t i = 0; i < uavs->size() && uavs->size() < most; ++i) {
    const Index u = (*uavs)[i];
    columns_.clear();
    dual_.TopColumns(u, loss, &columns_);
    work_ += 2 * dual_.n_arcs(u);
    const std::size_t n = std::min(kNeighbours, columns_.size());
    std::partial_sort(columns_.begin(), columns_.begin() + static_cast<std::ptrdiff_t>(n),
                      columns_.end(), [](const Column& a, const Column& b) {
                        return std::tie(a.regret, a.uav_arc, a.partner_arc) <
                               std::tie(b.regret, b.uav_arc, b.partner_arc);
                      });
    for (std::size_t k = 0; k < n; ++k) {
      const Column& column = columns_[k];
      if (column.site < 0) continue;
      if (const Index p = planner_.PartnerOf(column); p >= 0) join(plan.partner_of[At(p)]);
      if (plan.free_places[At(column.site)] <= 0) join(planner_.HolderOf(plan, column.site, -1));
    }
  }
  std::sort(uavs->begin(), uavs->end());
  for (const Index u : *uavs) uav_row_[At(u)] = -1;
}

bool Windows::Improve(Plan* plan, std::vector<Index> uavs, const std::function<bool()>& stop) {
  Widen(*plan, &uavs);
  // What the window's UAVs hold becomes free; so do partners on their own that one of them could
  // take along.
  const std::vector<Column> held = [&] {
    std::vector<Column> columns;
    for (const Index u : uavs) columns.push_back(plan->column[At(u)]);
    return columns;
  }();
  double loss = kEqual, before = 0;
  for (std::size_t i = 0; i < uavs.size(); ++i) {
    loss += planner_.Regret(uavs[i], held[i]);
    before += planner_.WeightOf(uavs[i], held[i]) - instance_.uavs[At(uavs[i])].stay;
    if (const Index p = planner_.PartnerOf(held[i]); p >= 0) {
      before -= instance_.partners[At(p)].stay;
    }
  }
  for (const Index u : uavs) planner_.Remove(plan, u);
  struct Item {
    Index agent;
    Column column;
    const Dual::Solo* solo;
  };
  std::vector<Item> items;
  std::vector<Index> partners, sites;
  std::vector<std::pair<Index, const Dual::Solo*>> own;
  const auto partner_joins = [&](Index p) {
    if (p < 0 || partner_row_[At(p)] >= 0) return;
    partner_row_[At(p)] = static_cast<Index>(partners.size());
    partners.push_back(p);
    const Dual::Solo* solo = plan->own[At(p)];
    if (solo == nullptr) return;
    own.emplace_back(p, solo);
    before += solo->weight - instance_.partners[At(p)].stay;
    ++plan->free_places[At(solo->site)];
    plan->own[At(p)] = nullptr;
  };
  const auto site_joins = [&](Index s) {
    if (site_row_[At(s)] >= 0) return;
    site_row_[At(s)] = static_cast<Index>(sites.size());
    sites.push_back(s);
  };
  std::vector<std::pair<std::size_t, Column>> wanted;
  for (std::size_t i = 0; i < uavs.size(); ++i) {
    const Index u = uavs[i];
    columns_.clear();
    dual_.TopColumns(u, loss, &columns_);
    work_ += 2 * dual_.n_arcs(u);
    for (const Index k : relaxation_.lp()->columns_at(u)) {
      const Column& column = relaxation_.known()[At(k)].column;
      columns_.push_back(column);
      columns_.back().regret = planner_.Regret(u, column);
    }
    std::erase_if(columns_, [&](const Column& c) {
      const Index p = planner_.PartnerOf(c);
      return c.site < 0 || (p >= 0 && plan->partner_of[At(p)] >= 0);
    });
    columns_.push_back(held[i]);
    columns_.back().regret = 0;
    const auto order = [](const Column& a, const Column& b) {
      return std::tie(a.regret, a.uav_arc, a.partner_arc) <
             std::tie(b.regret, b.uav_arc, b.partner_arc);
    };
    std::sort(columns_.begin(), columns_.end(), order);
    if (columns_.size() > kColumns) columns_.resize(kColumns);
    // Once each.
    std::sort(columns_.begin(), columns_.end(), [](const Column& a, const Column& b) {
      return std::tie(a.uav_arc, a.partner_arc) < std::tie(b.uav_arc, b.partner_arc);
    });
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const Column& column = columns_[k];
      if (column.site < 0) continue;
      if (k > 0 && column.uav_arc == columns_[k - 1].uav_arc &&
          column.partner_arc == columns_[k - 1].partner_arc) {
        continue;
      }
      partner_joins(planner_.PartnerOf(column));
      wanted.emplace_back(i, column);
    }
  }
  for (const auto& [i, column] : wanted) {
    if (plan->free_places[At(column.site)] <= 0) continue;
    site_joins(column.site);
    items.push_back({uavs[i], column, nullptr});
  }
  for (std::size_t k = 0; k < partners.size(); ++k) {
    for (const Dual::Solo& solo : dual_.solos(partners[k])) {
      if (plan->free_places[At(solo.site)] <= 0) continue;
      site_joins(solo.site);
      items.push_back({partners[k], {}, &solo});
    }
  }

  std::vector<std::int32_t> capacity(uavs.size() + partners.size(), 1);
  for (const Index s : sites) capacity.push_back(plan->free_places[At(s)]);
  PackingLp lp(capacity);
  const auto n_uavs = static_cast<Index>(uavs.size());
  const auto first_site = n_uavs + static_cast<Index>(partners.size());
  for (Index i = 0; i < n_uavs; ++i) uav_row_[At(uavs[At(i)])] = i;
  for (const Item& item : items) {
    const Index p = item.solo != nullptr ? item.agent : planner_.PartnerOf(item.column);
    const Index site = item.solo != nullptr ? item.solo->site : item.column.site;
    double cost = item.solo != nullptr ? item.solo->weight
                                       : planner_.WeightOf(item.agent, item.column) -
                                             instance_.uavs[At(item.agent)].stay;
    if (p >= 0) cost -= instance_.partners[At(p)].stay;
    lp.AddColumn(cost, {item.solo != nullptr ? PackingLp::kNoRow : uav_row_[At(item.agent)],
                        p < 0 ? PackingLp::kNoRow : n_uavs + partner_row_[At(p)],
                        first_site + site_row_[At(site)]});
  }
  double best = before;
  std::vector<Index> chosen;
  Branching search(
      &lp, n_uavs, 0,
      {stop, [&] { return best; },
       [&] {
         double weight = 0;
         std::vector<Index> now;
         for (Index k = 0; k < lp.n_columns(); ++k) {
           if (lp.value(k) <= 0.5) continue;
           const Item& item = items[At(k)];
           now.push_back(k);
           const Index p = item.solo != nullptr ? item.agent : planner_.PartnerOf(item.column);
           weight += item.solo != nullptr ? item.solo->weight
                                          : planner_.WeightOf(item.agent, item.column) -
                                                instance_.uavs[At(item.agent)].stay;
           if (p >= 0) weight -= instance_.partners[At(p)].stay;
         }
         if (weight <= best + kNegligible) return;
         best = weight;
         chosen = std::move(now);
       }});
  search.Search(std::numeric_limits<double>::infinity(),
                kWorkPerUav * static_cast<std::int64_t>(uavs.size()));
  work_ += search.work() + lp.work() + static_cast<std::int64_t>(capacity.size());

  for (const Index u : uavs) uav_row_[At(u)] = -1;
  for (const Index p : partners) partner_row_[At(p)] = -1;
  for (const Index s : sites) site_row_[At(s)] = -1;
  if (chosen.empty()) {
    for (std::size_t i = 0; i < uavs.size(); ++i) planner_.Put(plan, uavs[i], held[i]);
    for (const auto& [p, solo] : own) {
      plan->own[At(p)] = solo;
      --plan->free_places[At(solo->site)];
    }
    return false;
  }
  for (const Index k : chosen) {
    const Item& item = items[At(k)];
    if (item.solo == nullptr) {
      planner_.Put(plan, item.agent, item.column);
    } else {
      plan->own[At(item.agent)] = item.solo;
      --plan->free_places[At(item.solo->site)];
    }
  }
  return true;
}

}  // namespace muster::scheduler
