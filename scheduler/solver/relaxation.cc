#include "scheduler/solver/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "scheduler/solver/cliques.h"
#include "scheduler/solver/matchings.h"
#include "scheduler/solver/parallel.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;

constexpr std::size_t kColumnsPerRound = 8;  ///< that a UAV may add to the linear program
constexpr std::int32_t kOffersPerPlace = 6;  ///< columns of a site that a round adds, about
/// Of these, where a UAV has enough of them; multiples of kAlike.
constexpr std::array<double, 4> kMostRegret = {0.1, 1, 70, std::numeric_limits<double>::infinity()};
constexpr int kChunk = 50;  ///< UAVs whose columns are solved for together

constexpr double kAlike = 0.05;  ///< regrets that count as equal when choosing these

/// A program that is still that far from its bound, relative, takes more work than others.
constexpr double kStillFar = 1e-4;
/// A program that is hard and still that far from its bound, relative, is begun anew,
constexpr double kFar = 0.01;
constexpr std::int64_t kWorkAnew = 30'000'000;  ///< after so many steps,
constexpr std::size_t kRowsAnew = 20000;        ///< unless it has more rows,
constexpr std::size_t kDiverse = 6;             ///< with so many columns of each UAV
constexpr std::size_t kDrawn = 200;             ///< out of so many;
constexpr double kAlikeAnew = 0.1;              ///< regrets that count as equal there.
/// Its columns are listed up to this regret, in units of kAlikeAnew, and further if they are too
/// few.
constexpr std::array<double, 3> kListed = {3, 30, std::numeric_limits<double>::infinity()};

/// Rows of the linear program: UAVs, partners, sites. More places than agents are of no use, and
/// would drown what right-hand sides are raised by.
std::vector<std::int32_t> Rows(const Instance& instance) {
  const auto agents = instance.n_uavs() + instance.n_partners();
  std::vector<std::int32_t> rows(static_cast<std::size_t>(agents), 1);
  for (const std::int32_t places : instance.capacity) rows.push_back(std::min(places, agents));
  return rows;
}

}  // namespace

Relaxation::Relaxation(const Instance& instance, Dual* dual, int threads)
    : instance_(instance),
      dual_(*dual),
      planner_(instance, *dual),
      threads_(threads),
      lp_(Rows(instance)),
      solo_known_(instance.partner_arcs.size(), 0),
      order_(instance.uavs.size()) {
  for (const auto& uav : instance.uavs) stay_weight_ += uav.stay;
  for (const auto& partner : instance.partners) stay_weight_ += partner.stay;
  std::iota(order_.begin(), order_.end(), 0);
  std::sort(order_.begin(), order_.end(), [&](Index a, Index b) {
    return std::pair(instance.uavs[At(a)].place, a) < std::pair(instance.uavs[At(b)].place, b);
  });
}

bool Relaxation::Keyed::operator<(const Keyed& other) const {
  return std::tie(alike, mix, column.uav_arc, column.partner_arc) <
         std::tie(other.alike, other.mix, other.column.uav_arc, other.column.partner_arc);
}

std::uint32_t Relaxation::MixOf(Index uav, const Column& column) const {
  return Mix(static_cast<std::uint64_t>(uav) << 32 ^ static_cast<std::uint64_t>(column.site) << 16 ^
             static_cast<std::uint64_t>(planner_.PartnerOf(column)));
}

/// As Dual::TopColumns, but with every partner: its ranks are the same few for many sites and UAVs.
void Relaxation::PairsOf(Index u, double most, std::vector<Column>* columns) const {
  dual_.ColumnsOf(u, most, columns);
  const Column& best = dual_.best(u);
  std::erase_if(*columns, [&](const Column& c) {
    return c.partner_arc < 0 || (c.uav_arc == best.uav_arc && c.partner_arc == best.partner_arc);
  });
  if (best.site >= 0) columns->insert(columns->begin(), best);
}

void Relaxation::OffersOf(Index u, std::vector<Column>* columns, std::vector<Offer>* offers) const {
  const double earns = instance_.uavs[At(u)].stay + lp_.prices()[At(u)];
  const double more = dual_.best_value(u) - earns;
  if (more <= kNegligible) return;
  for (const double most : kMostRegret) {
    columns->clear();
    if (anew_) {
      PairsOf(u, std::min(more - kNegligible, most), columns);
    } else {
      dual_.TopColumns(u, std::min(more - kNegligible, most), columns);
    }
    if (columns->size() >= kColumnsPerRound || most >= more) break;
  }
  if (columns->size() > kColumnsPerRound) {
    // The best one, then good ones: which of them differs from UAV to UAV.
    std::vector<Keyed> keyed;
    keyed.reserve(columns->size() - 1);
    for (std::size_t k = 1; k < columns->size(); ++k) {
      const Column& c = (*columns)[k];
      keyed.push_back({std::floor(c.regret / kAlike), MixOf(u, c), c});
    }
    std::nth_element(keyed.begin(), keyed.begin() + (kColumnsPerRound - 1), keyed.end());
    columns->resize(kColumnsPerRound);
    for (std::size_t k = 1; k < kColumnsPerRound; ++k) (*columns)[k] = keyed[k - 1].column;
  }
  for (const Column& column : *columns) {
    if (column.site >= 0) offers->push_back({more - column.regret, u, column});
  }
}

/// What UAVs would rather do at the program's prices, by neighbourhood.
std::vector<Relaxation::Offer> Relaxation::Offers() {
  dual_.RankPartners();
  std::array<std::vector<Offer>, 2> halves;
  ParallelFor(order_.size(), threads_, 1000, [&](std::size_t begin, std::size_t end) {
    std::vector<Column> columns;
    for (std::size_t k = begin; k < end; ++k) {
      OffersOf(order_[k], &columns, &halves[begin == 0 ? 0 : 1]);
    }
  });
  std::vector<Offer> offers = std::move(halves[0]);
  offers.insert(offers.end(), halves[1].begin(), halves[1].end());
  work_ += static_cast<std::int64_t>(instance_.uav_arcs.size() + 8 * offers.size());

  // Where all want the same site, the best few tell what it is worth.
  std::vector<std::int32_t> at_site(instance_.capacity.size(), 0);
  for (const Offer& offer : offers) ++at_site[At(offer.column.site)];
  const auto most = [&](Index site) {
    return kOffersPerPlace * (std::int64_t{instance_.capacity[At(site)]} + 1);
  };
  std::vector<std::size_t> crowded;
  for (std::size_t k = 0; k < offers.size(); ++k) {
    if (at_site[At(offers[k].column.site)] > most(offers[k].column.site)) crowded.push_back(k);
  }
  std::sort(crowded.begin(), crowded.end(), [&](std::size_t i, std::size_t j) {
    const Offer &a = offers[i], &b = offers[j];
    return std::tie(b.more, a.column.regret, a.uav, a.column.uav_arc, a.column.partner_arc) <
           std::tie(a.more, b.column.regret, b.uav, b.column.uav_arc, b.column.partner_arc);
  });
  for (const std::size_t k : crowded) at_site[At(offers[k].column.site)] = 0;
  for (const std::size_t k : crowded) {
    const Index site = offers[k].column.site;
    if (++at_site[At(site)] > most(site)) offers[k].uav = -1;
  }
  std::erase_if(offers, [](const Offer& offer) { return offer.uav < 0; });
  return offers;
}

/// Neighbourhood by neighbourhood: what is solved in one is seldom undone by the next.
bool Relaxation::AddOffers(const std::vector<Offer>& offers, const std::function<bool()>& stop,
                           std::int64_t end) {
  Index last = -1;
  int in_chunk = 0;
  for (const Offer& offer : offers) {
    if (offer.uav != last && ++in_chunk > kChunk) {
      if (!lp_.Solve(end - dual_.work() - work(), stop)) return false;
      in_chunk = 1;
    }
    last = offer.uav;
    AddColumn(offer.uav, offer.column);
  }
  return true;
}

bool Relaxation::IsHard() const { return !anew_ && lp_.is_hard() && Rest() > kFar * bound_; }

/// Columns of the UAV for a program that is begun anew, in an order that differs from UAV to UAV:
/// kDrawn of those with the least regret. Returns how many it looked at.
std::int64_t Relaxation::Draw(Index u, std::vector<Column>* columns,
                              std::vector<Keyed>* drawn) const {
  std::int64_t looked_at = 0;
  const auto alike = [](const Column& c) { return std::floor(c.regret / kAlikeAnew); };
  for (const double most : kListed) {
    columns->clear();
    // All with a smaller regret than `most`, and some that have no smaller one.
    PairsOf(u, (most + 0.5) * kAlikeAnew, columns);
    looked_at += static_cast<std::int64_t>(columns->size());
    const auto n_smaller = std::count_if(columns->begin(), columns->end(),
                                         [&](const Column& c) { return alike(c) < most; });
    if (At(static_cast<Index>(n_smaller)) >= kDrawn) break;
  }
  drawn->clear();
  for (const Column& column : *columns) drawn->push_back({alike(column), MixOf(u, column), column});
  if (drawn->size() > kDrawn) {
    std::nth_element(drawn->begin(), drawn->begin() + kDrawn, drawn->end());
    drawn->resize(kDrawn);
  }
  std::sort(drawn->begin(), drawn->end());
  return looked_at;
}

/// Where nearly all columns tie, all UAVs are offered the same few partners and sites, round by
/// round, and each round ends at a program that is of no use to the next. So the program is made
/// anew: of a plan, which says how many can act together, and of columns of each UAV that share
/// neither partner nor site.
void Relaxation::BeginAnew(const std::function<bool()>& stop) {
  work_ += lp_.work();
  lp_ = PackingLp(Rows(instance_), instance_.n_uavs());
  lp_.UseDevex();
  known_.clear();
  std::fill(solo_known_.begin(), solo_known_.end(), 0);
  dual_.set_prices(first_prices_);
  dual_.Evaluate();
  anew_ = planner_.Empty();
  Plan& plan = *anew_;
  work_ += planner_.Fill(&plan);
  Matchings matchings(instance_, dual_, threads_);
  matchings.Improve(&plan, stop);
  work_ += matchings.work();
  for (Index u = 0; u < instance_.n_uavs(); ++u) {
    if (plan.column[At(u)].site >= 0) AddColumn(u, plan.column[At(u)]);
  }
  for (Index p = 0; p < instance_.n_partners(); ++p) {
    if (plan.own[At(p)] != nullptr) AddSolo(p, plan.own[At(p)]);
  }
  lp_.Solve(std::numeric_limits<std::int64_t>::max() / 2, stop);
  AddDiverse(plan);
}

/// Columns of each UAV that share neither partner nor site, nor those of the plan.
void Relaxation::AddDiverse(const Plan& plan) {
  constexpr std::size_t kTogether = 1000;  ///< UAVs whose columns are drawn before they are added
  std::vector<std::vector<Keyed>> drawn(std::min(instance_.uavs.size(), kTogether));
  std::vector<std::int64_t> looked_at(drawn.size());
  // UAVs that have a column with the partner, at the site: the last of them.
  std::vector<Index> with_partner(instance_.partners.size(), -1);
  std::vector<Index> at_site(instance_.capacity.size(), -1);
  for (Index u = 0; u < instance_.n_uavs(); ++u) {
    const auto is_new = [&](const Column& column) {
      const Index p = planner_.PartnerOf(column);
      return at_site[At(column.site)] != u && (p < 0 || with_partner[At(p)] != u);
    };
    const auto add = [&](const Column& column) {
      AddColumn(u, column);
      at_site[At(column.site)] = u;
      if (const Index p = planner_.PartnerOf(column); p >= 0) with_partner[At(p)] = u;
    };
    if (const Column& column = plan.column[At(u)]; column.site >= 0) {
      at_site[At(column.site)] = u;
      if (const Index p = planner_.PartnerOf(column); p >= 0) with_partner[At(p)] = u;
    }
    const std::size_t k = At(u) % kTogether;
    if (k == 0) {
      const std::size_t n = std::min(instance_.uavs.size() - At(u), kTogether);
      ParallelFor(n, threads_, 100, [&](std::size_t begin, std::size_t end) {
        std::vector<Column> columns;
        std::vector<Keyed> keyed;
        for (std::size_t i = begin; i < end; ++i) {
          looked_at[i] = Draw(u + static_cast<Index>(i), &columns, &keyed);
          drawn[i].assign(keyed.begin(), keyed.end());
        }
      });
    }
    work_ += 8 * dual_.n_arcs(u) + 8 * looked_at[k];
    std::size_t added = 0;
    for (const Keyed& next : drawn[k]) {
      if (added == kDiverse) break;
      if (!is_new(next.column)) continue;
      add(next.column);
      ++added;
    }
  }
}

/// The bound that the program's prices prove.
void Relaxation::TakePrices() {
  const auto n_uavs = instance_.n_uavs(), n_partners = instance_.n_partners();
  Dual::Prices prices;
  for (Index s = 0; s < instance_.n_sites(); ++s) {
    prices.site.push_back(std::max(0.0, lp_.prices()[At(n_uavs + n_partners + s)]));
  }
  for (Index p = 0; p < n_partners; ++p) {
    prices.partner.push_back(instance_.partners[At(p)].stay +
                             std::max(0.0, lp_.prices()[At(n_uavs + p)]));
  }
  dual_.set_prices(prices);
  const double bound = dual_.Evaluate();
  if (bound < bound_) {
    bound_ = bound;
    prices_ = std::move(prices);
  }
}

void Relaxation::Solve(std::int64_t work_limit, const std::function<bool()>& stop,
                       std::int64_t work_limit_if_far) {
  const auto n_uavs = instance_.n_uavs(), n_partners = instance_.n_partners();
  std::int64_t end = dual_.work() + work() + work_limit;
  const std::int64_t end_if_far = dual_.work() + work() + work_limit_if_far;
  bound_ = dual_.Evaluate();
  prices_ = first_prices_ = dual_.prices();
  const auto stop_or_hard = [&] { return stop() || IsHard(); };
  while (!stop() && dual_.work() + work() < end) {
    const auto before = lp_.n_columns();
    bool solved = AddOffers(Offers(), stop_or_hard, end);
    for (Index p = 0; p < n_partners; ++p) {
      const double earns =
          instance_.partners[At(p)].stay + lp_.prices()[At(n_uavs + p)] + kNegligible;
      for (const Dual::Solo& solo : dual_.solos(p)) {
        const Index site = n_uavs + n_partners + solo.site;
        if (solo_known_[At(solo.arc)] || solo.weight - lp_.prices()[At(site)] <= earns) continue;
        AddSolo(p, &solo);
      }
    }
    if (lp_.n_columns() == before) {
      if (solved && !lp_.Verify()) continue;
      solved_ = solved;
      break;
    }
    solved = solved && lp_.Solve(end - dual_.work() - work(), stop_or_hard);
    if (IsHard()) {
      BeginAnew(stop);
      solved = lp_.Solve(end - dual_.work() - work(), stop);
    }
    TakePrices();
    if (dual_.work() + work() >= end && end < end_if_far && Rest() > kStillFar * bound_) {
      end = end_if_far;
      solved = lp_.Solve(end - dual_.work() - work(), stop);
      TakePrices();
    }
    if (!solved) break;
    // What is too large for a proof of the optimum need not be exact either.
    if ((known_.size() > kProofColumns && Rest() <= kCloseEnough * bound_) ||
        (anew_ && Rest() <= kCloseEnoughAnew * bound_ && lp_.Verify())) {
      solved_ = true;
      break;
    }
  }
  if (dual_.prices().site != prices_.site || dual_.prices().partner != prices_.partner) {
    dual_.set_prices(prices_);
    dual_.Evaluate();
  }
}

void Relaxation::AddColumn(Index uav, const Column& column) {
  const Index n_uavs = instance_.n_uavs(), n_partners = instance_.n_partners();
  const Index p = planner_.PartnerOf(column);
  double cost = planner_.WeightOf(uav, column) - instance_.uavs[At(uav)].stay;
  if (p >= 0) cost -= instance_.partners[At(p)].stay;
  lp_.AddColumn(cost,
                {uav, p < 0 ? PackingLp::kNoRow : n_uavs + p, n_uavs + n_partners + column.site});
  known_.push_back({uav, column, nullptr});
}

void Relaxation::AddSolo(Index partner, const Dual::Solo* solo) {
  const Index n_uavs = instance_.n_uavs(), n_partners = instance_.n_partners();
  solo_known_[At(solo->arc)] = 1;
  lp_.AddColumn(solo->weight - instance_.partners[At(partner)].stay,
                {PackingLp::kNoRow, n_uavs + partner, n_uavs + n_partners + solo->site});
  known_.push_back({partner, {}, solo});
}

bool Relaxation::AddAll(double most, std::size_t limit) {
  std::vector<std::vector<std::pair<Index, Index>>> known(instance_.uavs.size());
  for (const Known& column : known_) {
    if (column.solo != nullptr) continue;
    known[At(column.agent)].emplace_back(column.column.uav_arc, column.column.partner_arc);
  }
  std::vector<Column> columns;
  for (Index u = 0; u < instance_.n_uavs(); ++u) {
    columns.clear();
    dual_.ColumnsOf(u, most, &columns);
    work_ += 8 * dual_.n_arcs(u) + static_cast<std::int64_t>(columns.size());
    auto& of_uav = known[At(u)];
    std::sort(of_uav.begin(), of_uav.end());
    for (const Column& column : columns) {
      if (column.site >= 0 && !std::binary_search(of_uav.begin(), of_uav.end(),
                                                  std::pair(column.uav_arc, column.partner_arc))) {
        AddColumn(u, column);
      }
    }
    if (known_.size() > limit) return false;
  }
  for (Index p = 0; p < instance_.n_partners(); ++p) {
    for (const Dual::Solo& solo : dual_.solos(p)) {
      if (!solo_known_[At(solo.arc)] && planner_.OwnRegret(p, &solo) <= most) AddSolo(p, &solo);
    }
  }
  return true;
}

void Relaxation::AddCliques(double enough, std::int64_t work_limit,
                            const std::function<bool()>& stop) {
  const std::int64_t end = work() + work_limit;
  Cliques cliques;
  while (lp_.Solve(end - work(), stop) && lp_.Bound() + stay_weight_ > enough) {
    const std::int64_t before = cliques.work();
    const std::size_t found = cliques.Find(lp_);
    work_ += cliques.work() - before;
    if (found == 0) return;
    // Begun with what is used now, the new program is soon where the old one is.
    std::vector<Index> order(known_.size());
    std::iota(order.begin(), order.end(), 0);
    const auto rest = std::stable_partition(order.begin(), order.end(),
                                            [&](Index k) { return lp_.value(k) > 0; });
    cliques.Renumber(order);
    std::vector<std::int32_t> rows = Rows(instance_);
    std::vector<std::vector<Index>> more(known_.size());
    for (const std::vector<Index>& clique : cliques.all()) {
      for (const Index k : clique) more[At(k)].push_back(static_cast<Index>(rows.size()));
      rows.push_back(1);
    }
    PackingLp with(rows);
    with.UseDevex();
    std::vector<Known> known;
    for (auto k = order.begin(); k != order.end(); ++k) {
      if (k == rest && !with.Solve(end - work(), stop)) {
        work_ += with.work();
        return;
      }
      with.AddColumn(lp_.cost(*k), lp_.rows(*k), std::move(more[known.size()]));
      known.push_back(known_[At(*k)]);
    }
    work_ += lp_.work();
    lp_ = std::move(with);
    known_ = std::move(known);
  }
}

Plan Relaxation::Rounded() const {
  Plan plan = planner_.Empty();
  for (std::size_t k = 0; k < known_.size(); ++k) {
    if (lp_.value(static_cast<Index>(k)) <= 0.5) continue;
    const Known& known = known_[k];
    if (known.solo != nullptr) {
      if (plan.free_places[At(known.solo->site)] <= 0 || plan.partner_of[At(known.agent)] >= 0) {
        continue;
      }
      plan.own[At(known.agent)] = known.solo;
      --plan.free_places[At(known.solo->site)];
    } else if (planner_.IsFree(plan, known.column)) {
      planner_.Put(&plan, known.agent, known.column);
    }
  }
  return plan;
}

}  // namespace muster::scheduler
