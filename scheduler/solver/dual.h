#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scheduler/solver/instance.h"

namespace muster::scheduler {

/// A node that a UAV may choose, as arcs of the instance. Neither arc: it stays.
struct Column {
  std::int32_t site = -1;
  std::int32_t uav_arc = -1;
  std::int32_t partner_arc = -1;  ///< -1: the UAV alone
  double regret = 0;              ///< the UAV's best reduced weight less this one's, at the prices
};

/// Spreads numbers, to choose among equals.
inline std::uint32_t Mix(std::uint64_t x) {
  x *= 0x9E3779B97F4A7C15u;
  return static_cast<std::uint32_t>(x >> 40);
}

/// Prices on sites and partners, and the bound that they prove: with any prices >= 0 (partners: at
/// least their weight of staying) no solution weighs more than
///     sum over sites of capacity * price + sum over partners of max(price, best own action)
///     + sum over UAVs of the best action,
/// own and best by weight less the prices of what is used. What a solution falls short of this is
/// its loss, a sum of non-negative parts: each UAV's regret, each priced place left free, each
/// partner that earns less than its price. Source: Lagrangian relaxation of the three-index
/// assignment problem (Frieze and Yadegar 1981; Poore and Robertson 1997), with a UAV's pairs
/// priced through the best partner per (site, level).
class Dual {
 public:
  /// The instance must outlive this. threads: 1 or 2; no result depends on it.
  Dual(const Instance& instance, int threads);

  /// Bound at the current prices, rounding included; sets the best columns.
  double Evaluate();

  /// Appends the columns of one UAV whose regret is at most `most`, staying included; at the prices
  /// of the last Evaluate.
  void ColumnsOf(std::int32_t uav, double most, std::vector<Column>* columns) const;
  /// Finds the partners of highest value at each (site, level), for TopColumns.
  void RankPartners();
  /// As ColumnsOf, but of each (site, level) only pairs with the partners ranked there; the best
  /// column is always among them.
  void TopColumns(std::int32_t uav, double most, std::vector<Column>* columns) const;
  /// Best column of the UAV among those whose site has a free place and whose partner is free, by
  /// regret, then by order. Staying is always free.
  Column BestFree(std::int32_t uav, std::span<const std::int32_t> free_places,
                  std::span<const char> partner_free) const;

  struct Prices {
    std::vector<double> site, partner;
  };
  const Prices& prices() const { return prices_; }
  void set_prices(const Prices& prices) { prices_ = prices; }

  double site_price(std::int32_t s) const { return prices_.site[At(s)]; }
  /// What a pair pays for the partner: the larger of its price and its best own action.
  double partner_value(std::int32_t p) const { return value_[At(p)]; }
  const Column& best(std::int32_t uav) const { return best_column_[At(uav)]; }
  double best_value(std::int32_t uav) const { return best_value_[At(uav)]; }

  /// Moves of an agent alone that weigh more than its staying.
  struct Solo {
    std::int32_t site, arc;
    double weight;
  };
  std::span<const Solo> solos(std::int32_t partner) const {
    return {solos_.data() + solo_begin_[At(partner)],
            At(solo_begin_[At(partner) + 1] - solo_begin_[At(partner)])};
  }
  /// Number of ways that a UAV has.
  std::int64_t n_arcs(std::int32_t uav) const {
    return arc_begin_[At(uav) + 1] - arc_begin_[At(uav)];
  }
  /// Elementary steps done so far: arcs looked at.
  std::int64_t work() const { return work_; }
  /// Rounding that may hide in a bound.
  double slack() const { return slack_; }

 private:
  static std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }
  std::int32_t GroupPartners();
  std::int32_t ListWays();
  void ListSolos();
  /// Partner arcs of one site and level.
  struct Group {
    std::int32_t begin, end, level;
    std::int32_t best;  ///< arc of the partner that adds most
    double most;        ///< that
    double most_on;     ///< the most that one of this or of a higher level adds
  };
  /// What the loops over a UAV's ways need of them.
  struct Way {
    std::int32_t arc, site, level;
    double base, gain;
  };
  struct Place {
    double price;
    double most;                     ///< no partner there adds more
    std::int32_t least, begin, end;  ///< groups, and the lowest of their levels
    std::int32_t rest;               ///< level of partners that are not listed, or 0
  };
  std::span<const Way> ways(std::int32_t uav) const {
    return {ways_.data() + arc_begin_[At(uav)], At(arc_begin_[At(uav) + 1] - arc_begin_[At(uav)])};
  }
  std::span<const Solo> uav_solos(std::int32_t uav) const {
    return {uav_solos_.data() + uav_solo_begin_[At(uav)],
            At(uav_solo_begin_[At(uav) + 1] - uav_solo_begin_[At(uav)])};
  }
  void PriceSites(std::int32_t begin, std::int32_t end);
  void PriceUavs(std::int32_t begin, std::int32_t end);
  /// Calls visit(way, regret, group) where a pair's regret may be at most `most`, which visit may
  /// lower: `regret` less what the partner adds.
  template <class Visit>
  void PairsNear(std::int32_t uav, const double& most, Visit&& visit) const;
  double InverseLevel(std::int32_t a, std::int32_t b) const;

  const Instance& instance_;
  int threads_;
  std::vector<Group> groups_;             ///< by site, then level
  std::vector<Place> places_;             ///< [n_sites]
  std::vector<std::int32_t> partner_of_;  ///< [n_partner_arcs]
  std::vector<double> gain_of_;           ///< [n_partner_arcs]
  std::vector<double> adds_;              ///< [n_partner_arcs] gain less the partner's value
  std::vector<double> inverse_;           ///< 1 / level
  std::vector<std::int32_t> arc_begin_;   ///< [n_uavs + 1]
  std::vector<Way> ways_;                 ///< by UAV, then site
  std::vector<std::int32_t> solo_begin_, uav_solo_begin_;
  std::vector<Solo> solos_, uav_solos_;

  static constexpr std::size_t kRanks = 4;
  std::vector<std::array<std::int32_t, kRanks>> ranked_;  ///< [n_groups] partner arcs or -1

  Prices prices_;
  std::vector<double> value_;  ///< [n_partners]
  std::vector<double> best_value_;
  std::vector<double> bound_value_;  ///< [n_uavs] the same with partners that are not listed
  double least_value_ = 0;           ///< of a partner
  std::vector<Column> best_column_;
  std::int64_t work_ = 0;
  double slack_ = 0;
};

}  // namespace muster::scheduler
