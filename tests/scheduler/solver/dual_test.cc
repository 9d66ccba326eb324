// Prices against the explicit graph. Weights are multiples of 1/16 and levels powers of two, so
// that sums are exact and ties are ties.
#include "scheduler/solver/dual.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "base/index.h"
#include "base/random.h"
#include "tests/scheduler/solver/explicit_graph.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;

double Rounded(double x) { return x == Instance::kNone ? x : std::round(16 * x) / 16; }

Instance ExactInstance(std::uint64_t seed) {
  Instance instance =
      testing::RandomInstance(seed, 1 + static_cast<int>(seed % 7), 1 + static_cast<int>(seed % 23),
                              1 + static_cast<int>(seed % 6));
  const auto level = [&](Index was) {
    return seed % 8 == 5 && was == 3 ? 8192 : was == 3 ? 4 : was;
  };
  for (auto& uav : instance.uavs) uav.stay = Rounded(uav.stay);
  for (auto& partner : instance.partners) partner.stay = Rounded(partner.stay);
  for (auto& arc : instance.uav_arcs) {
    arc.level = level(arc.level);
    arc.solo = Rounded(arc.solo);
    arc.base = std::round(arc.base) * (arc.level > 4 ? 1024 : 1);
    arc.pair_gain = Rounded(arc.pair_gain);
  }
  for (auto& arc : instance.partner_arcs) {
    arc.level = level(arc.level);
    arc.gain = Rounded(arc.gain);
  }
  return instance;
}

/// The definitions of dual.h, by plain loops over all nodes.
class PricedGraph {
 public:
  PricedGraph(const Instance& instance, const Dual::Prices& prices)
      : instance_(instance), prices_(prices) {
    for (std::size_t p = 0; p < instance.partners.size(); ++p) {
      value.push_back(std::max(instance.partners[p].stay, prices.partner[p]));
    }
    ForEachPartnerArc([&](Index s, Index j) {
      const auto& arc = instance.partner_arcs[At(j)];
      if (!arc.solo || arc.gain <= instance.partners[At(arc.partner)].stay) return;
      value[At(arc.partner)] = std::max(value[At(arc.partner)], arc.gain - prices.site[At(s)]);
      ++n_solos;
    });
    for (Index u = 0; u < instance.n_uavs(); ++u) AddColumns(u);
  }

  double Bound() const {
    double bound = 0;
    for (std::size_t s = 0; s < prices_.site.size(); ++s) {
      bound += prices_.site[s] * instance_.capacity[s];
    }
    for (const double v : value) bound += v;
    for (std::size_t u = 0; u < best.size(); ++u) bound += std::max(best[u], BestUnlisted(u));
    return bound;
  }
  double Adds(Index j) const {
    const auto& arc = instance_.partner_arcs[At(j)];
    return arc.gain - value[At(arc.partner)];
  }

  std::vector<double> value;                 ///< [n_partners]
  std::vector<double> best;                  ///< [n_uavs]
  std::vector<std::vector<Column>> columns;  ///< [n_uavs] staying, moves alone, pairs
  int n_solos = 0;                           ///< of partners

 private:
  template <class Visit>
  void ForEachPartnerArc(Visit&& visit) const {
    for (Index s = 0; s < instance_.n_sites(); ++s) {
      for (Index j = instance_.partner_begin[At(s)]; j < instance_.partner_begin[At(s) + 1]; ++j) {
        visit(s, j);
      }
    }
  }

  void AddColumns(Index u) {
    const double stay = instance_.uavs[At(u)].stay;
    std::vector<Column> moves, pairs;
    for (Index s = 0; s < instance_.n_sites(); ++s) {
      for (Index i = instance_.uav_begin[At(s)]; i < instance_.uav_begin[At(s) + 1]; ++i) {
        const auto& arc = instance_.uav_arcs[At(i)];
        if (arc.uav != u) continue;
        if (arc.solo > stay) moves.push_back({s, i, -1, arc.solo - prices_.site[At(s)]});
        if (arc.pair_gain == Instance::kNone) continue;
        for (Index j = instance_.partner_begin[At(s)]; j < instance_.partner_begin[At(s) + 1];
             ++j) {
          const auto& partner = instance_.partner_arcs[At(j)];
          if (!instance_.Compatible(arc, partner)) continue;
          pairs.push_back({s, i, j,
                           Instance::PairWeight(arc, partner) - prices_.site[At(s)] -
                               value[At(partner.partner)]});
        }
      }
    }
    std::vector<Column> all = {{-1, -1, -1, stay}};
    all.insert(all.end(), moves.begin(), moves.end());
    all.insert(all.end(), pairs.begin(), pairs.end());
    double most = stay;
    for (const Column& column : all) most = std::max(most, column.regret);
    for (Column& column : all) column.regret = most - column.regret;
    best.push_back(most);
    columns.push_back(std::move(all));
  }

  /// With a partner that is not listed: of the lowest level that it may have, at the least value.
  double BestUnlisted(std::size_t u) const {
    double most = Instance::kNone;
    for (Index s = 0; s < instance_.n_sites() && !instance_.rest_level.empty(); ++s) {
      const Index rest = instance_.rest_level[At(s)];
      for (Index i = instance_.uav_begin[At(s)]; i < instance_.uav_begin[At(s) + 1]; ++i) {
        const auto& arc = instance_.uav_arcs[At(i)];
        if (rest == 0 || arc.uav != static_cast<Index>(u)) continue;
        most = std::max(
            most, arc.pair_gain - prices_.site[At(s)] + arc.base / std::max(arc.level, rest) +
                      Instance::kMostGain / rest - *std::min_element(value.begin(), value.end()));
      }
    }
    return most;
  }

  const Instance& instance_;
  const Dual::Prices& prices_;
};

using ColumnKey = std::tuple<Index, Index, Index, double>;
std::set<ColumnKey> SetOf(const std::vector<Column>& columns) {
  std::set<ColumnKey> keys;
  for (const Column& c : columns) keys.emplace(c.site, c.uav_arc, c.partner_arc, c.regret);
  EXPECT_EQ(keys.size(), columns.size());
  return keys;
}
ColumnKey KeyOf(const Column& c) { return {c.site, c.uav_arc, c.partner_arc, c.regret}; }

/// Of each (site, level) the best four partners, whichever of equal ones.
void ExpectTop(const Instance& instance, const PricedGraph& reference, Index u, double most,
               const std::vector<Column>& columns) {
  const std::set<ColumnKey> top = SetOf(columns);
  for (const Column& column : reference.columns[At(u)]) {
    if (column.partner_arc < 0) continue;
    const auto& partner = instance.partner_arcs[At(column.partner_arc)];
    int above = 0, not_below = 0;  // it, of its group
    for (Index j = instance.partner_begin[At(column.site)];
         j < instance.partner_begin[At(column.site) + 1]; ++j) {
      if (instance.partner_arcs[At(j)].level != partner.level) continue;
      above += reference.Adds(j) > reference.Adds(column.partner_arc);
      not_below += reference.Adds(j) >= reference.Adds(column.partner_arc);
    }
    const bool is_best = KeyOf(column) == KeyOf(columns.front());
    if (not_below <= 4 && column.regret <= most) {
      EXPECT_TRUE(top.contains(KeyOf(column)));
    }
    if (!is_best && (above >= 4 || column.regret > most)) {
      EXPECT_FALSE(top.contains(KeyOf(column)));
    }
  }
}

TEST(Dual, IsItsDefinition) {
  int ties = 0;
  for (std::uint64_t seed = 0; seed < 1200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Instance instance = ExactInstance(seed);
    Random random(seed, Stream::kTest, 1);
    const auto sixteenths = [&](std::uint32_t most) { return random.Below(most) / 16.0; };
    if (seed % 3 == 0) {
      for (Index s = 0; s < instance.n_sites(); ++s) {
        instance.rest_level.push_back(static_cast<Index>(random.Below(3)));
      }
    }
    Dual dual(instance, 1);
    const bool zero = seed % 6 == 1;
    Dual::Prices prices;
    for (Index s = 0; s < instance.n_sites(); ++s) {
      prices.site.push_back(zero || random.Below(3) == 0 ? 0 : sixteenths(600));
    }
    for (const auto& partner : instance.partners) {
      prices.partner.push_back(zero ? partner.stay : partner.stay + sixteenths(400));
    }
    dual.set_prices(prices);
    const PricedGraph reference(instance, prices);
    const double bound = dual.Evaluate();
    ASSERT_NEAR(bound, reference.Bound(), 1e-9);
    ASSERT_GE(bound, reference.Bound());
    EXPECT_EQ(dual.work(), instance.uav_arcs.size() + instance.partner_arcs.size() +
                               static_cast<std::size_t>(reference.n_solos + instance.n_sites()));
    dual.RankPartners();
    std::vector<std::int32_t> free_places = instance.capacity;
    for (Index& n : free_places) n -= random.Below(2) == 0 ? n : 0;
    std::vector<char> partner_free;
    for (Index p = 0; p < instance.n_partners(); ++p) {
      ASSERT_EQ(dual.partner_value(p), reference.value[At(p)]);
      partner_free.push_back(random.Below(3) != 0);
    }
    for (Index u = 0; u < instance.n_uavs(); ++u) {
      ASSERT_EQ(dual.best_value(u), reference.best[At(u)]);
      const std::vector<Column>& all = reference.columns[At(u)];
      // Of equal ones the first: staying, pairs, moves alone.
      const auto rank = [](const Column& c) {
        return std::tuple(c.regret,
                          c.site < 0           ? 0
                          : c.partner_arc >= 0 ? 1
                                               : 2,
                          c.site, c.partner_arc);
      };
      const Column& best = *std::min_element(
          all.begin(), all.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
      ASSERT_EQ(KeyOf(dual.best(u)), KeyOf(best));
      for (const double most : {0.0, sixteenths(50), sixteenths(2000)}) {
        std::vector<Column> expected = all, found;
        std::erase_if(expected, [&](const Column& c) { return c.regret > most; });
        dual.ColumnsOf(u, most, &found);
        ASSERT_EQ(SetOf(found), SetOf(expected)) << most;
        ties += static_cast<int>(std::count_if(all.begin(), all.end(), [&](const Column& c) {
          return c.regret == most && c.site >= 0;
        }));
        found.clear();
        dual.TopColumns(u, most, &found);
        if (best.site >= 0) {
          ASSERT_EQ(KeyOf(found.front()), KeyOf(best));
        }
        if (!found.empty()) ExpectTop(instance, reference, u, most, found);
      }
      // The first of equal ones again, in another order: staying, moves alone, pairs.
      const Column* free = &all.front();
      for (const Column& c : all) {
        if (c.site >= 0 && free_places[At(c.site)] == 0) continue;
        if (c.partner_arc >= 0 &&
            partner_free[At(instance.partner_arcs[At(c.partner_arc)].partner)] == 0) {
          continue;
        }
        if (c.regret < free->regret) free = &c;
      }
      ASSERT_EQ(KeyOf(dual.BestFree(u, free_places, partner_free)), KeyOf(*free));
    }
  }
  EXPECT_GT(ties, 1000);
}

}  // namespace
}  // namespace muster::scheduler
