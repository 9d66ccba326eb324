#include "scheduler/certified/solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>
#include <vector>

#include "scheduler/certified/dual.h"
#include "scheduler/certified/packing_lp.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;
using Clock = std::chrono::steady_clock;

std::size_t At(Index i) { return static_cast<std::size_t>(i); }

constexpr std::size_t kColumnsPerRound = 8;   ///< that a UAV may add to the linear program
constexpr std::int32_t kOffersPerPlace = 6;   ///< columns of a site that a round adds, about
constexpr double kMostRegret = 70;            ///< of these, where a UAV has enough of them
constexpr int kChunk = 100;                   ///< UAVs whose columns are solved for together
constexpr double kAlike = 0.05;               ///< regrets that count as equal when choosing these
constexpr std::int64_t kWork = 20'000'000;    ///< default limit: this, once more for branching,
constexpr std::int64_t kWorkPerArc = 130;     ///< and this for each arc
constexpr int kChainLinks = 64;               ///< UAVs that a chain may look at
constexpr double kNegligible = 1e-9;          ///< loss
constexpr std::size_t kProofColumns = 20000;  ///< of an exact search
constexpr double kWhole = 1e-3;               ///< shares this close to 0 or 1 are whole

/// A feasible assignment under change: who holds what.
struct Plan {
  std::vector<Column> column;          ///< [n_uavs]
  std::vector<Index> partner_of;       ///< [n_partners] UAV that takes it along, or -1
  std::vector<const Dual::Solo*> own;  ///< [n_partners] its move alone; null: stays or taken along
  std::vector<Index> free_places;      ///< [n_sites]
  double weight = -std::numeric_limits<double>::infinity();
};

class Search {
 public:
  Search(const Instance& instance, const SolverLimits& limits)
      : instance_(instance),
        limits_(limits),
        dual_(instance, limits.threads),
        lp_(Rows(instance)),
        label_(instance.uavs.size(), std::numeric_limits<double>::infinity()) {
    for (const auto& uav : instance.uavs) stay_weight_ += uav.stay;
    for (const auto& partner : instance.partners) stay_weight_ += partner.stay;
    const auto arcs =
        static_cast<std::int64_t>(instance.uav_arcs.size() + instance.partner_arcs.size());
    work_limit_ = limits.work > 0 ? limits.work : kWork + kWorkPerArc * arcs;
  }

  Solution Run() {
    auto mark = Clock::now();
    best_bound_ = dual_.Evaluate();
    best_prices_ = first_prices_ = dual_.prices();
    GenerateColumns();
    bound_s_ += Lap(&mark);
    dual_.set_prices(best_prices_);
    dual_.Evaluate();
    // The relaxation's own solution, and what the prices suggest when that is fractional.
    Plan plan = Rounded();
    Weigh(&plan);
    best_ = plan;
    if (!Proven()) {
      Improve(&plan);
      Keep(std::move(plan));
    }
    if (!Proven()) {
      plan = Empty();
      Fill(&plan);
      Improve(&plan);
      Keep(std::move(plan));
    }
    if (!Proven()) {
      // Where all weights are alike, prices hide that some sites are worth more than others.
      dual_.set_prices(first_prices_);
      dual_.Evaluate();
      plan = Empty();
      Fill(&plan);
      Keep(std::move(plan));
      dual_.set_prices(best_prices_);
      dual_.Evaluate();
    }
    if (!Proven() && !Stop()) {
      if (limits_.work <= 0) work_limit_ = std::min(work_limit_, Work() + kWork);
      Prove();
    }
    search_s_ += Lap(&mark);
    return Finish();
  }

 private:
  static double Seconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
  }
  static double Lap(Clock::time_point* mark) {
    const auto now = Clock::now();
    const double s = Seconds(*mark, now);
    *mark = now;
    return s;
  }
  std::int64_t Work() const { return dual_.work() + lp_.work() + work_; }
  bool Stop() const {
    return Work() > work_limit_ || (limits_.deadline && Clock::now() >= *limits_.deadline);
  }
  void Keep(Plan&& plan) {
    Weigh(&plan);
    if (plan.weight > best_.weight) best_ = std::move(plan);
  }
  bool Proven() const {
    return Gap() <= 2 * dual_.slack() + kNegligible * static_cast<double>(instance_.uavs.size());
  }
  /// Rows of the linear program: UAVs, partners, sites.
  static std::vector<std::int32_t> Rows(const Instance& instance) {
    std::vector<std::int32_t> rows(instance.uavs.size() + instance.partners.size(), 1);
    rows.insert(rows.end(), instance.capacity.begin(), instance.capacity.end());
    return rows;
  }
  double Gap() const { return best_bound_ - best_.weight; }

  /// Linear relaxation by column generation: the program knows some columns of each UAV; at its
  /// prices each UAV's best column overall is found, which bounds the optimum and says what is
  /// missing. Ends when nothing is.
  void GenerateColumns() {
    const auto n_uavs = instance_.n_uavs(), n_partners = instance_.n_partners();
    std::vector<char> solo_known(instance_.partner_arcs.size(), 0);
    // The rest is for assignments, should the relaxation not end.
    const auto relaxation_limit = work_limit_ / 4 * 3;
    while (!Stop() && Work() < relaxation_limit) {
      const auto before = lp_.n_columns();
      struct Offer {
        double more;  ///< reduced weight above what the UAV earns
        Index uav;
        Column column;
      };
      std::vector<Offer> offers;
      dual_.RankPartners();
      for (Index u = 0; u < n_uavs; ++u) {
        const double earns = instance_.uavs[At(u)].stay + lp_.prices()[At(u)];
        const double more = dual_.best_value(u) - earns;
        if (more <= kNegligible) continue;
        columns_.clear();
        dual_.TopColumns(u, std::min(more - kNegligible, kMostRegret), &columns_);
        if (columns_.size() < kColumnsPerRound && more > kMostRegret) {
          columns_.clear();
          dual_.TopColumns(u, more - kNegligible, &columns_);
        }
        work_ += 2 * dual_.n_arcs(u);
        if (columns_.size() > kColumnsPerRound) {
          // The best one, then good ones: which of them differs from UAV to UAV.
          const auto key = [&](const Column& c) {
            return std::tuple(
                std::floor(c.regret / kAlike),
                Mix(static_cast<std::uint64_t>(u) << 32 ^ static_cast<std::uint64_t>(c.site) << 16 ^
                    static_cast<std::uint64_t>(PartnerOf(c))),
                c.uav_arc, c.partner_arc);
          };
          std::nth_element(columns_.begin() + 1, columns_.begin() + kColumnsPerRound,
                           columns_.end(),
                           [&](const Column& a, const Column& b) { return key(a) < key(b); });
          columns_.resize(kColumnsPerRound);
        }
        for (const Column& column : columns_) {
          if (column.site >= 0) offers.push_back({more - column.regret, u, column});
        }
      }
      // Where all want the same site, the best few tell what it is worth.
      std::sort(offers.begin(), offers.end(), [](const Offer& a, const Offer& b) {
        return std::tie(b.more, a.column.regret, a.uav, a.column.uav_arc, a.column.partner_arc) <
               std::tie(a.more, b.column.regret, b.uav, b.column.uav_arc, b.column.partner_arc);
      });
      std::vector<std::int32_t> offered(instance_.capacity.size(), 0);
      std::vector<Offer> taken;
      for (const Offer& offer : offers) {
        std::int32_t& at_site = offered[At(offer.column.site)];
        if (at_site / kOffersPerPlace > instance_.capacity[At(offer.column.site)]) continue;
        ++at_site;
        taken.push_back(offer);
      }
      // Neighbourhood by neighbourhood: what is solved in one is seldom undone by the next.
      std::stable_sort(taken.begin(), taken.end(), [&](const Offer& a, const Offer& b) {
        return std::pair(instance_.uavs[At(a.uav)].place, a.uav) <
               std::pair(instance_.uavs[At(b.uav)].place, b.uav);
      });
      Index last = -1;
      int in_chunk = 0;
      for (const Offer& offer : taken) {
        if (offer.uav != last && ++in_chunk > kChunk) {
          if (!lp_.Solve(relaxation_limit - Work())) break;
          in_chunk = 1;
        }
        last = offer.uav;
        AddColumn(offer.uav, offer.column);
      }
      for (Index p = 0; p < n_partners; ++p) {
        const double earns =
            instance_.partners[At(p)].stay + lp_.prices()[At(n_uavs + p)] + kNegligible;
        for (const Dual::Solo& solo : dual_.solos(p)) {
          const Index site = n_uavs + n_partners + solo.site;
          if (solo_known[At(solo.arc)] || solo.weight - lp_.prices()[At(site)] <= earns) continue;
          solo_known[At(solo.arc)] = 1;
          AddSolo(p, &solo);
        }
      }
      if (lp_.n_columns() == before) return;
      const bool solved = lp_.Solve(relaxation_limit - Work());
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
      if (bound < best_bound_) {
        best_bound_ = bound;
        best_prices_ = std::move(prices);
      }
      if (!solved) return;
    }
  }

  void AddColumn(Index uav, const Column& column) {
    const Index n_uavs = instance_.n_uavs(), n_partners = instance_.n_partners();
    const Index p = PartnerOf(column);
    double cost = WeightOf(uav, column) - instance_.uavs[At(uav)].stay;
    if (p >= 0) cost -= instance_.partners[At(p)].stay;
    lp_.AddColumn(cost,
                  {uav, p < 0 ? PackingLp::kNoRow : n_uavs + p, n_uavs + n_partners + column.site});
    known_.push_back({uav, column, nullptr});
  }
  void AddSolo(Index partner, const Dual::Solo* solo) {
    const Index n_uavs = instance_.n_uavs(), n_partners = instance_.n_partners();
    lp_.AddColumn(solo->weight - instance_.partners[At(partner)].stay,
                  {PackingLp::kNoRow, n_uavs + partner, n_uavs + n_partners + solo->site});
    known_.push_back({partner, {}, solo});
  }

  /// What the relaxation uses by more than half, the rest filled up.
  Plan Rounded() {
    Plan plan = Empty();
    for (std::size_t k = 0; k < known_.size(); ++k) {
      if (lp_.value(static_cast<Index>(k)) <= 0.5) continue;
      const Known& known = known_[k];
      if (known.solo != nullptr) {
        if (plan.free_places[At(known.solo->site)] <= 0 || plan.partner_of[At(known.agent)] >= 0) {
          continue;
        }
        plan.own[At(known.agent)] = known.solo;
        --plan.free_places[At(known.solo->site)];
      } else if (IsFree(plan, known.column)) {
        Put(&plan, known.agent, known.column);
      }
    }
    Fill(&plan);
    return plan;
  }
  bool IsFree(const Plan& plan, const Column& column) const {
    const Index p = PartnerOf(column);
    return (column.site < 0 || plan.free_places[At(column.site)] > 0) &&
           (p < 0 || (plan.partner_of[At(p)] < 0 && plan.own[At(p)] == nullptr));
  }

  Plan Empty() const {
    Plan plan;
    plan.column.resize(instance_.uavs.size());
    plan.partner_of.assign(instance_.partners.size(), -1);
    plan.own.assign(instance_.partners.size(), nullptr);
    plan.free_places = instance_.capacity;
    return plan;
  }
  Index PartnerOf(const Column& column) const {
    return column.partner_arc < 0 ? -1 : instance_.partner_arcs[At(column.partner_arc)].partner;
  }
  void Put(Plan* plan, Index uav, const Column& column) const {
    plan->column[At(uav)] = column;
    if (column.site >= 0) --plan->free_places[At(column.site)];
    if (column.partner_arc >= 0) plan->partner_of[At(PartnerOf(column))] = uav;
  }
  void Remove(Plan* plan, Index uav) const {
    const Column& column = plan->column[At(uav)];
    if (column.site >= 0) ++plan->free_places[At(column.site)];
    if (column.partner_arc >= 0) plan->partner_of[At(PartnerOf(column))] = -1;
    plan->column[At(uav)] = Column{};
  }
  double WeightOf(Index uav, const Column& column) const {
    if (column.site < 0) return instance_.uavs[At(uav)].stay;
    const Instance::UavArc& arc = instance_.uav_arcs[At(column.uav_arc)];
    if (column.partner_arc < 0) return arc.solo;
    return Instance::PairWeight(arc, instance_.partner_arcs[At(column.partner_arc)]);
  }
  void Weigh(Plan* plan) const {
    plan->weight = 0;
    for (Index u = 0; u < instance_.n_uavs(); ++u) {
      plan->weight += WeightOf(u, plan->column[At(u)]);
    }
    for (std::size_t p = 0; p < plan->partner_of.size(); ++p) {
      if (plan->partner_of[p] >= 0) continue;
      plan->weight += plan->own[p] != nullptr ? plan->own[p]->weight : instance_.partners[p].stay;
    }
  }
  double Regret(Index uav, const Column& column) const {
    const double price = column.site < 0 ? 0 : dual_.site_price(column.site);
    const double partner = column.partner_arc < 0 ? 0 : dual_.partner_value(PartnerOf(column));
    return std::max(0.0, dual_.best_value(uav) - (WeightOf(uav, column) - price - partner));
  }
  double OwnRegret(Index partner, const Dual::Solo* own) const {
    const double value = own == nullptr ? instance_.partners[At(partner)].stay
                                        : own->weight - dual_.site_price(own->site);
    return std::max(0.0, dual_.partner_value(partner) - value);
  }

  /// UAVs without a column, by regret, smallest first; one whose column is taken comes again with
  /// its next best. Then the partners that are left, likewise.
  void Fill(Plan* plan) {
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
        work_ += 8 * dual_.n_arcs(u);
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
  }

  /// Ejection chains from every UAV that loses, until none helps.
  void Improve(Plan* plan) {
    for (bool again = true; again;) {
      again = false;
      for (Index u = 0; u < instance_.n_uavs() && !Stop(); ++u) {
        if (Regret(u, plan->column[At(u)]) <= kNegligible) continue;
        if (Chain(plan, u)) again = true;
      }
    }
  }

  /// A UAV in an ejection chain: it is to go, by the column that it then takes; what it held
  /// is the next one's to take.
  struct Link {
    Index uav;
    Index parent;  ///< link whose column takes what this UAV holds; -1: the seed
    double loss;   ///< of the chain so far, against the plan
    Column takes;  ///< by the parent
  };

  /// Best chain "u takes what v holds, v takes what w holds, ..., the last takes what is free" by
  /// regret, cheapest first, each UAV at most once. True when it makes the plan better.
  bool Chain(Plan* plan, Index seed) {
    links_.clear();
    using Entry = std::pair<double, Index>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    touched_.clear();
    const auto label = [&](Index u) -> double& {
      if (label_[At(u)] == std::numeric_limits<double>::infinity()) touched_.push_back(u);
      return label_[At(u)];
    };
    links_.push_back({seed, -1, -Regret(seed, plan->column[At(seed)]), {}});
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
        if (const Index p = PartnerOf(column); p >= 0) owner = plan->partner_of[At(p)];
        if (owner == u) owner = -1;
        if (column.site >= 0 && plan->free_places[At(column.site)] <= 0 &&
            plan->column[At(u)].site != column.site) {
          const Index holder = HolderOf(*plan, column.site, owner);
          if (holder >= 0 && owner >= 0 && holder != owner) continue;
          if (holder >= 0) owner = holder;
        }
        if (owner < 0) {
          best = total;
          last = k;
          last_column = column;
          continue;
        }
        const double next = total - Regret(owner, plan->column[At(owner)]);
        if (next >= best || next >= label(owner) || OnChain(k, owner)) continue;
        label(owner) = next;
        queue.emplace(next, static_cast<Index>(links_.size()));
        links_.push_back({owner, k, next, column});
      }
    }
    for (const Index u : touched_) label_[At(u)] = std::numeric_limits<double>::infinity();
    if (last < 0) return false;

    // Carry it out; what it displaces besides (a partner on its own) stays where it is.
    std::vector<std::pair<Index, Column>> before, after;
    Column takes = last_column;
    for (Index k = last; k >= 0; k = links_[At(k)].parent) {
      before.emplace_back(links_[At(k)].uav, plan->column[At(links_[At(k)].uav)]);
      after.emplace_back(links_[At(k)].uav, takes);
      takes = links_[At(k)].takes;
    }
    double gain = 0;
    for (const auto& [u, column] : before) {
      gain -= WeightOf(u, column);
      if (column.partner_arc >= 0) gain += instance_.partners[At(PartnerOf(column))].stay;
      Remove(plan, u);
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
      gain += WeightOf(u, column);
      if (const Index p = PartnerOf(column); p >= 0) {
        if (plan->partner_of[At(p)] >= 0) {
          valid = false;
          break;
        }
        gain -= instance_.partners[At(p)].stay;
        displace(p);
      }
      if (column.site >= 0 && plan->free_places[At(column.site)] <= 0) {
        const Index p = SoloAt(*plan, column.site);
        if (p < 0) {
          valid = false;
          break;
        }
        displace(p);
      }
      Put(plan, u, column);
    }
    if (valid && gain > kNegligible) return true;
    for (std::size_t k = 0; k < put; ++k) Remove(plan, after[k].first);
    for (const auto& [u, column] : before) Put(plan, u, column);
    for (const auto& [p, own] : displaced) {
      plan->own[At(p)] = own;
      --plan->free_places[At(own->site)];
    }
    return false;
  }

  bool OnChain(Index link, Index uav) const {
    for (Index k = link; k >= 0; k = links_[At(k)].parent) {
      if (links_[At(k)].uav == uav) return true;
    }
    return false;
  }
  /// Whether a column of the chain takes what this one needs.
  bool TakenOnChain(Index link, const Column& column) const {
    const Index partner = PartnerOf(column);
    for (Index k = link; k >= 0; k = links_[At(k)].parent) {
      const Column& takes = links_[At(k)].takes;
      if (takes.site >= 0 && takes.site == column.site) return true;
      if (partner >= 0 && PartnerOf(takes) == partner) return true;
    }
    return false;
  }
  /// A UAV that holds a place at a full site, `rather` if it does; -1: only partners on their own.
  Index HolderOf(const Plan& plan, Index site, Index rather) const {
    if (rather >= 0 && plan.column[At(rather)].site == site) return rather;
    for (Index i = instance_.uav_begin[At(site)]; i < instance_.uav_begin[At(site) + 1]; ++i) {
      const Index u = instance_.uav_arcs[At(i)].uav;
      if (plan.column[At(u)].site == site) return u;
    }
    return -1;
  }
  /// A partner that goes to the site on its own, or -1.
  Index SoloAt(const Plan& plan, Index site) const {
    for (Index j = instance_.partner_begin[At(site)]; j < instance_.partner_begin[At(site) + 1];
         ++j) {
      const Index p = instance_.partner_arcs[At(j)].partner;
      if (plan.own[At(p)] != nullptr && plan.own[At(p)]->site == site) return p;
    }
    return -1;
  }

  /// Best assignment among the columns that the linear program knows, by branching on whether a UAV
  /// goes to a site, then whether a partner comes along or goes alone. Returns a bound on all of
  /// these; the best found is kept.
  double Branch(double above) {
    if (Stop() || !lp_.Solve(work_limit_ - Work())) return above;
    const double bound = std::min(above, stay_weight_ + lp_.Bound() + dual_.slack());
    if (bound <= best_.weight + kNegligible) return bound;

    // Shares of (agent, site) and (agent, partner) that are not whole; the nearest to a half.
    struct Pick {
      double share = 0;
      Index agent = -1, other = -1;
      bool is_uav = false, by_site = false;
      double Miss() const { return std::abs(share - 0.5); }
    };
    Pick pick;
    for (const bool by_site : {false, true}) {
      shares_.clear();
      for (std::size_t k = 0; k < known_.size(); ++k) {
        const double value = lp_.value(static_cast<Index>(k));
        if (value < kWhole) continue;
        const Known& known = known_[k];
        const bool is_uav = known.solo == nullptr;
        const Index other = !is_uav   ? known.solo->site
                            : by_site ? known.column.site
                                      : PartnerOf(known.column);
        if (other < 0 || (!is_uav && !by_site)) continue;
        shares_.push_back({is_uav, known.agent, other, value});
      }
      std::sort(shares_.begin(), shares_.end());
      for (std::size_t k = 0; k < shares_.size();) {
        Pick now{0, shares_[k].agent, shares_[k].other, shares_[k].is_uav, by_site};
        const auto [is_uav, agent, other, value] = shares_[k];
        for (; k < shares_.size() && shares_[k].is_uav == is_uav && shares_[k].agent == agent &&
               shares_[k].other == other;
             ++k) {
          now.share += shares_[k].value;
        }
        if (now.share < 1 - kWhole && (pick.agent < 0 || now.Miss() < pick.Miss())) pick = now;
      }
      if (pick.agent >= 0) break;
    }
    work_ += static_cast<std::int64_t>(known_.size());
    if (pick.agent < 0) {
      Keep(Rounded());
      return bound;
    }

    const auto uses = [&](const Known& known) {
      if (known.solo != nullptr) {
        return pick.by_site ? known.solo->site == pick.other : known.agent == pick.other;
      }
      return (pick.by_site ? known.column.site : PartnerOf(known.column)) == pick.other;
    };
    const bool excludes = !pick.by_site || instance_.capacity[At(pick.other)] == 1;
    const Index row = pick.is_uav ? pick.agent : instance_.n_uavs() + pick.agent;
    double highest = -std::numeric_limits<double>::infinity();
    for (const bool with : {pick.share >= 0.5, pick.share < 0.5}) {
      std::vector<Index> closed;
      for (std::size_t k = 0; k < known_.size(); ++k) {
        const Known& known = known_[k];
        const bool agents = (known.solo == nullptr) == pick.is_uav && known.agent == pick.agent;
        // A partner that goes alone goes with no UAV.
        const bool takes =
            !pick.is_uav && known.solo == nullptr && PartnerOf(known.column) == pick.agent;
        const bool close = with ? (agents ? !uses(known) : takes || (excludes && uses(known)))
                                : agents && uses(known);
        if (close && !lp_.closed(static_cast<Index>(k))) closed.push_back(static_cast<Index>(k));
      }
      for (const Index k : closed) lp_.Close(k, true);
      const bool required = with && lp_.Require(row, true);
      // Nothing changed: by rounding, columns that cannot be used still have a share.
      const bool same = closed.empty() && !required;
      highest = std::max(highest, same ? bound : Branch(bound));
      if (required) lp_.Require(row, false);
      for (const Index k : closed) lp_.Close(k, false);
      if (bound <= best_.weight + kNegligible) break;
    }
    return std::max(highest, best_.weight);
  }

  /// Branches over what the linear program knows, then over every column that a better assignment
  /// may hold: those whose regret at the best prices is within the gap, as what an assignment falls
  /// short of the bound is a sum that each of its columns' regrets is part of.
  void Prove() {
    Branch(best_bound_);
    dual_.set_prices(best_prices_);
    dual_.Evaluate();
    if (Stop() || Proven()) return;
    std::vector<std::vector<std::pair<Index, Index>>> known(instance_.uavs.size());
    std::vector<char> solo_known(instance_.partner_arcs.size(), 0);
    for (const Known& column : known_) {
      if (column.solo != nullptr) {
        solo_known[At(column.solo->arc)] = 1;
      } else {
        known[At(column.agent)].emplace_back(column.column.uav_arc, column.column.partner_arc);
      }
    }
    const double gap = Gap();
    for (Index u = 0; u < instance_.n_uavs(); ++u) {
      columns_.clear();
      dual_.ColumnsOf(u, gap, &columns_);
      work_ += 8 * dual_.n_arcs(u);
      auto& of_uav = known[At(u)];
      std::sort(of_uav.begin(), of_uav.end());
      for (const Column& column : columns_) {
        if (column.site >= 0 &&
            !std::binary_search(of_uav.begin(), of_uav.end(),
                                std::pair(column.uav_arc, column.partner_arc))) {
          AddColumn(u, column);
        }
      }
      if (known_.size() > kProofColumns) return;
    }
    for (Index p = 0; p < instance_.n_partners(); ++p) {
      for (const Dual::Solo& solo : dual_.solos(p)) {
        if (!solo_known[At(solo.arc)] && OwnRegret(p, &solo) <= gap) AddSolo(p, &solo);
      }
    }
    proven_bound_ = std::max(best_.weight, Branch(best_bound_));
    proven_bound_ = std::max(proven_bound_, best_.weight) + kNegligible;
  }

  Solution Finish() {
    Solution solution;
    Assignment& assignment = solution.assignment;
    for (const Column& column : best_.column) {
      assignment.uavs.push_back({column.site, column.uav_arc, column.partner_arc});
    }
    for (const Dual::Solo* own : best_.own) {
      assignment.partner_solo.push_back(own == nullptr ? -1 : own->arc);
    }
    assignment.weight = scheduler::WeightOf(instance_, assignment);
    solution.bound = std::max(assignment.weight, std::min(best_bound_, proven_bound_));
    solution.work = Work();
    solution.bound_s = bound_s_;
    solution.search_s = search_s_;
    return solution;
  }

  const Instance& instance_;
  SolverLimits limits_;
  Dual dual_;
  std::int64_t work_ = 0, work_limit_ = 0;
  double best_bound_ = 0;
  Dual::Prices best_prices_, first_prices_;
  Plan best_;
  double proven_bound_ = std::numeric_limits<double>::infinity();
  /// What a column of the linear program is.
  struct Known {
    Index agent;  ///< UAV, or partner on its own
    Column column;
    const Dual::Solo* solo;
  };
  PackingLp lp_;
  std::vector<Known> known_;
  struct Share {
    bool is_uav;
    Index agent, other;
    double value;
    bool operator<(const Share& b) const {
      return std::tie(is_uav, agent, other) < std::tie(b.is_uav, b.agent, b.other);
    }
  };
  std::vector<Share> shares_;
  double stay_weight_ = 0;  ///< of everybody staying
  double bound_s_ = 0, search_s_ = 0;
  std::vector<Column> columns_;
  std::vector<Link> links_;
  std::vector<double> label_;  ///< [n_uavs] infinite between chains
  std::vector<Index> touched_;
};

}  // namespace

Solution Solve(const Instance& instance, const SolverLimits& limits) {
  return Search(instance, limits).Run();
}

}  // namespace muster::scheduler
