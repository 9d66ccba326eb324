#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scheduler/certified/instance.h"

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

  /// Moves of a partner alone that weigh more than its staying.
  struct Solo {
    std::int32_t site, arc;
    double weight;
  };
  std::span<const Solo> solos(std::int32_t partner) const {
    return {solos_.data() + solo_begin_[At(partner)],
            At(solo_begin_[At(partner) + 1] - solo_begin_[At(partner)])};
  }
  /// Arcs of a UAV, ascending.
  std::span<const std::int32_t> arcs(std::int32_t uav) const {
    return {arc_of_uav_.data() + arc_begin_[At(uav)],
            At(arc_begin_[At(uav) + 1] - arc_begin_[At(uav)])};
  }
  std::int32_t site_of_arc(std::int32_t uav_arc) const { return site_of_arc_[At(uav_arc)]; }
  /// Elementary steps done so far: arcs looked at.
  std::int64_t work() const { return work_; }
  /// Rounding that may hide in a bound.
  double slack() const { return slack_; }

 private:
  static std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }
  struct Group {
    std::int32_t begin, end, level;
  };
  struct HotUavArc {
    std::int32_t uav, level;
    double base, gain;
  };
  void PriceSites(std::int32_t begin, std::int32_t end, std::vector<double>* best_value,
                  std::vector<Column>* best_column) const;
  double InverseLevel(std::int32_t a, std::int32_t b) const;

  const Instance& instance_;
  int threads_;
  std::vector<std::int32_t> group_begin_;  ///< [n_sites + 1]
  std::vector<Group> groups_;              ///< partner arcs of one site and level
  std::vector<HotUavArc> hot_;             ///< [n_uav_arcs]
  std::vector<std::int32_t> partner_of_;   ///< [n_partner_arcs]
  std::vector<double> gain_of_;            ///< [n_partner_arcs]
  std::vector<double> inverse_;            ///< 1 / level
  std::vector<std::int32_t> arc_begin_, arc_of_uav_, site_of_arc_;
  std::vector<std::int32_t> solo_begin_;
  std::vector<Solo> solos_;
  std::vector<std::int32_t> uav_solos_;  ///< UAV arcs whose solo move beats staying, ascending

  static constexpr std::size_t kRanks = 4;
  std::vector<std::array<std::int32_t, kRanks>> ranked_;  ///< [n_groups] partner arcs or -1

  Prices prices_;
  std::vector<double> value_;  ///< [n_partners]
  std::vector<double> best_value_, other_value_;
  std::vector<Column> best_column_, other_column_;
  double most_gain_ = 0;  ///< no partner adds more to a reduced weight
  std::int64_t work_ = 0;
  double slack_ = 0;
};

}  // namespace muster::scheduler
