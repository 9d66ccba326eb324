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
constexpr std::size_t kNeighbourColumns = 8;  ///< columns of each whose holders join
constexpr std::size_t kColumns = 32;          ///< of a UAV in a window
constexpr std::int64_t kWorkPerUav = 60'000;  ///< of one search
constexpr double kWorthwhile = 1e-6;  ///< loss that a window is searched for, of the whole weight
constexpr double kEqual = 1e-6;       ///< regrets

bool LessRegret(const Column& a, const Column& b) {
  return std::tie(a.regret, a.uav_arc, a.partner_arc) <
         std::tie(b.regret, b.uav_arc, b.partner_arc);
}

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
    const std::size_t n = std::min(kNeighbourColumns, columns_.size());
    std::partial_sort(columns_.begin(), columns_.begin() + static_cast<std::ptrdiff_t>(n),
                      columns_.end(), LessRegret);
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

/// What a window's UAVs hold becomes free.
Windows::Window Windows::Open(Plan* plan, std::vector<Index> uavs) {
  Window window;
  window.uavs = std::move(uavs);
  window.loss = kEqual;
  for (const Index u : window.uavs) {
    const Column held = plan->column[At(u)];
    window.held.push_back(held);
    window.loss += planner_.Regret(u, held);
    window.before += planner_.WeightOf(u, held) - instance_.uavs[At(u)].stay;
    if (const Index p = planner_.PartnerOf(held); p >= 0) {
      window.before -= instance_.partners[At(p)].stay;
    }
  }
  for (const Index u : window.uavs) planner_.Remove(plan, u);
  return window;
}

/// The columns of a UAV that may be in the window's solution, into columns_: those of little
/// regret, those that the relaxation knows, and the one that it holds; once each.
void Windows::ListColumns(const Plan& plan, Index u, const Column& held, double loss) {
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
    return c.site < 0 || (p >= 0 && plan.partner_of[At(p)] >= 0);
  });
  columns_.push_back(held);
  columns_.back().regret = 0;
  std::sort(columns_.begin(), columns_.end(), LessRegret);
  if (columns_.size() > kColumns) columns_.resize(kColumns);
  const auto arcs = [](const Column& c) { return std::tie(c.uav_arc, c.partner_arc); };
  std::sort(columns_.begin(), columns_.end(),
            [&](const Column& a, const Column& b) { return arcs(a) < arcs(b); });
  columns_.erase(std::unique(columns_.begin(), columns_.end(),
                             [&](const Column& a, const Column& b) { return arcs(a) == arcs(b); }),
                 columns_.end());
  std::erase_if(columns_, [](const Column& c) { return c.site < 0; });
}

/// A partner that a UAV of the window could take along; what it does on its own becomes free.
void Windows::AddPartner(Plan* plan, Index p, Window* window) {
  if (p < 0 || partner_row_[At(p)] >= 0) return;
  partner_row_[At(p)] = static_cast<Index>(window->partners.size());
  window->partners.push_back(p);
  const Dual::Solo* solo = plan->own[At(p)];
  if (solo == nullptr) return;
  window->own.emplace_back(p, solo);
  window->before += solo->weight - instance_.partners[At(p)].stay;
  ++plan->free_places[At(solo->site)];
  plan->own[At(p)] = nullptr;
}

/// All that the window's UAVs and partners can do where places are free.
void Windows::ListItems(Plan* plan, Window* window) {
  std::vector<std::pair<Index, Column>> wanted;
  for (std::size_t i = 0; i < window->uavs.size(); ++i) {
    const Index u = window->uavs[i];
    ListColumns(*plan, u, window->held[i], window->loss);
    for (const Column& column : columns_) {
      AddPartner(plan, planner_.PartnerOf(column), window);
      wanted.emplace_back(u, column);
    }
  }
  const auto add = [&](const Window::Item& item) {
    if (plan->free_places[At(item.site)] <= 0) return;
    if (site_row_[At(item.site)] < 0) {
      site_row_[At(item.site)] = static_cast<Index>(window->sites.size());
      window->sites.push_back(item.site);
    }
    window->items.push_back(item);
  };
  for (const auto& [u, column] : wanted) {
    const Index p = planner_.PartnerOf(column);
    double gain = planner_.WeightOf(u, column) - instance_.uavs[At(u)].stay;
    if (p >= 0) gain -= instance_.partners[At(p)].stay;
    add({.uav = u, .partner = p, .site = column.site, .gain = gain, .column = column});
  }
  for (const Index p : window->partners) {
    for (const Dual::Solo& solo : dual_.solos(p)) {
      const double gain = solo.weight - instance_.partners[At(p)].stay;
      add({.uav = -1, .partner = p, .site = solo.site, .gain = gain, .solo = &solo});
    }
  }
}

/// The window's items as a packing: rows of UAVs, then partners, then sites.
PackingLp Windows::Program(const Plan& plan, const Window& window) {
  std::vector<std::int32_t> capacity(window.uavs.size() + window.partners.size(), 1);
  for (const Index s : window.sites) capacity.push_back(plan.free_places[At(s)]);
  PackingLp lp(capacity);
  const auto n_uavs = static_cast<Index>(window.uavs.size());
  const auto first_site = n_uavs + static_cast<Index>(window.partners.size());
  for (Index i = 0; i < n_uavs; ++i) uav_row_[At(window.uavs[At(i)])] = i;
  for (const Window::Item& item : window.items) {
    lp.AddColumn(item.gain,
                 {item.uav < 0 ? PackingLp::kNoRow : uav_row_[At(item.uav)],
                  item.partner < 0 ? PackingLp::kNoRow : n_uavs + partner_row_[At(item.partner)],
                  first_site + site_row_[At(item.site)]});
  }
  work_ += static_cast<std::int64_t>(capacity.size());
  return lp;
}

/// The items that together are heavier than what was held; none where nothing is.
std::vector<Index> Windows::Search(const Plan& plan, const Window& window,
                                   const std::function<bool()>& stop) {
  PackingLp lp = Program(plan, window);
  double best = window.before;
  std::vector<Index> chosen;
  const auto take = [&] {
    double weight = 0;
    std::vector<Index> now;
    for (Index k = 0; k < lp.n_columns(); ++k) {
      if (lp.value(k) <= 0.5) continue;
      now.push_back(k);
      weight += window.items[At(k)].gain;
    }
    if (weight <= best + kNegligible) return;
    best = weight;
    chosen = std::move(now);
  };
  Branching search(&lp, static_cast<Index>(window.uavs.size()), 0,
                   {stop, [&] { return best; }, take});
  search.Search(std::numeric_limits<double>::infinity(),
                kWorkPerUav * static_cast<std::int64_t>(window.uavs.size()));
  work_ += search.work() + lp.work();
  return chosen;
}

void Windows::Close(Plan* plan, const Window& window, const std::vector<Index>& chosen) {
  for (const Index u : window.uavs) uav_row_[At(u)] = -1;
  for (const Index p : window.partners) partner_row_[At(p)] = -1;
  for (const Index s : window.sites) site_row_[At(s)] = -1;
  const auto put_own = [&](Index p, const Dual::Solo* solo) {
    plan->own[At(p)] = solo;
    --plan->free_places[At(solo->site)];
  };
  if (chosen.empty()) {
    for (std::size_t i = 0; i < window.uavs.size(); ++i) {
      planner_.Put(plan, window.uavs[i], window.held[i]);
    }
    for (const auto& [p, solo] : window.own) put_own(p, solo);
  }
  for (const Index k : chosen) {
    const Window::Item& item = window.items[At(k)];
    if (item.solo == nullptr) {
      planner_.Put(plan, item.uav, item.column);
    } else {
      put_own(item.partner, item.solo);
    }
  }
}

void Windows::Improve(Plan* plan, std::vector<Index> uavs, const std::function<bool()>& stop) {
  Widen(*plan, &uavs);
  Window window = Open(plan, std::move(uavs));
  ListItems(plan, &window);
  Close(plan, window, Search(*plan, window, stop));
}

}  // namespace muster::scheduler
