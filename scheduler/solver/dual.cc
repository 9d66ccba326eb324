#include "scheduler/solver/dual.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scheduler/solver/parallel.h"

namespace muster::scheduler {
namespace {

/// Neumaier's sum: its error does not grow with the number of terms.
class Sum {
 public:
  void Add(double x) {
    const double t = sum_ + x;
    rest_ += std::abs(sum_) >= std::abs(x) ? (sum_ - t) + x : (x - t) + sum_;
    sum_ = t;
    magnitude_ += std::abs(x);
  }
  double value() const { return sum_ + rest_; }
  double magnitude() const { return magnitude_; }

 private:
  double sum_ = 0, rest_ = 0, magnitude_ = 0;
};

}  // namespace

Dual::Dual(const Instance& instance, int threads) : instance_(instance), threads_(threads) {
  const std::int32_t highest = std::max(GroupPartners(), ListWays());
  ListSolos();
  for (std::int32_t level = 0; level <= std::min(highest, 4096); ++level) {
    inverse_.push_back(1.0 / std::max(level, 1));
  }
  prices_.site.assign(instance.capacity.size(), 0);
  for (const Instance::Partner& partner : instance.partners) {
    prices_.partner.push_back(partner.stay);
  }
  value_.resize(instance.partners.size());
  best_value_.resize(instance.uavs.size());
  bound_value_.resize(instance.uavs.size());
  best_column_.resize(instance.uavs.size());
}

/// Partners of each site by level; returns the highest.
std::int32_t Dual::GroupPartners() {
  const Instance& instance = instance_;
  std::int32_t highest = 1;
  places_.resize(At(instance.n_sites()));
  for (std::size_t s = 0; s < places_.size(); ++s) {
    places_[s].begin = static_cast<std::int32_t>(groups_.size());
    for (std::int32_t j = instance.partner_begin[s]; j < instance.partner_begin[s + 1]; ++j) {
      const std::int32_t level = instance.partner_arcs[At(j)].level;
      if (j == instance.partner_begin[s] || groups_.back().level != level) {
        groups_.push_back({j, j, level, -1, 0, 0});
      }
      groups_.back().end = j + 1;
      highest = std::max(highest, level);
    }
    places_[s].end = static_cast<std::int32_t>(groups_.size());
    places_[s].least = 1;
    places_[s].rest = instance.rest_level.empty() ? 0 : instance.rest_level[s];
    if (places_[s].begin < places_[s].end) places_[s].least = groups_[At(places_[s].begin)].level;
  }
  return highest;
}

/// Ways of each UAV, and those that it may take alone; returns the highest level.
std::int32_t Dual::ListWays() {
  const Instance& instance = instance_;
  std::int32_t highest = 1;
  arc_begin_.assign(instance.uavs.size() + 1, 0);
  uav_solo_begin_.assign(instance.uavs.size() + 1, 0);
  const auto uav_is_solo = [&](const Instance::UavArc& arc) {
    return arc.solo > instance.uavs[At(arc.uav)].stay;
  };
  for (const Instance::UavArc& arc : instance.uav_arcs) {
    ++arc_begin_[At(arc.uav) + 1];
    if (uav_is_solo(arc)) ++uav_solo_begin_[At(arc.uav) + 1];
    highest = std::max(highest, arc.level);
  }
  for (std::size_t u = 0; u < instance.uavs.size(); ++u) {
    arc_begin_[u + 1] += arc_begin_[u];
    uav_solo_begin_[u + 1] += uav_solo_begin_[u];
  }
  ways_.resize(instance.uav_arcs.size());
  uav_solos_.resize(At(uav_solo_begin_.back()));
  std::vector<std::int32_t> next(arc_begin_.begin(), arc_begin_.end() - 1);
  std::vector<std::int32_t> next_solo(uav_solo_begin_.begin(), uav_solo_begin_.end() - 1);
  for (std::int32_t s = 0; s < instance.n_sites(); ++s) {
    for (std::int32_t i = instance.uav_begin[At(s)]; i < instance.uav_begin[At(s) + 1]; ++i) {
      const Instance::UavArc& arc = instance.uav_arcs[At(i)];
      ways_[At(next[At(arc.uav)]++)] = {i, s, arc.level, arc.base, arc.pair_gain};
      if (uav_is_solo(arc)) uav_solos_[At(next_solo[At(arc.uav)]++)] = {s, i, arc.solo};
    }
  }
  return highest;
}

/// Ways that each partner may take alone.
void Dual::ListSolos() {
  const Instance& instance = instance_;
  solo_begin_.assign(instance.partners.size() + 1, 0);
  const auto is_solo = [&](const Instance::PartnerArc& arc) {
    return arc.solo && arc.gain > instance.partners[At(arc.partner)].stay;
  };
  partner_of_.reserve(instance.partner_arcs.size());
  gain_of_.reserve(instance.partner_arcs.size());
  for (const Instance::PartnerArc& arc : instance.partner_arcs) {
    partner_of_.push_back(arc.partner);
    gain_of_.push_back(arc.gain);
    if (is_solo(arc)) ++solo_begin_[At(arc.partner) + 1];
  }
  adds_.resize(gain_of_.size());
  for (std::size_t p = 0; p < instance.partners.size(); ++p) solo_begin_[p + 1] += solo_begin_[p];
  solos_.resize(At(solo_begin_.back()));
  std::vector<std::int32_t> next(solo_begin_.begin(), solo_begin_.end() - 1);
  for (std::int32_t s = 0; s < instance.n_sites(); ++s) {
    for (std::int32_t j = instance.partner_begin[At(s)]; j < instance.partner_begin[At(s) + 1];
         ++j) {
      const Instance::PartnerArc& arc = instance.partner_arcs[At(j)];
      if (is_solo(arc)) solos_[At(next[At(arc.partner)]++)] = {s, j, arc.gain};
    }
  }
}

double Dual::InverseLevel(std::int32_t a, std::int32_t b) const {
  const auto level = At(std::max(a, b));
  return level < inverse_.size() ? inverse_[level] : 1.0 / static_cast<double>(level);
}

double Dual::Evaluate() {
  Sum sum;
  for (std::size_t s = 0; s < prices_.site.size(); ++s) {
    if (prices_.site[s] > 0) sum.Add(prices_.site[s] * instance_.capacity[s]);
  }
  for (std::size_t p = 0; p < value_.size(); ++p) {
    double own = instance_.partners[p].stay;
    for (const Solo& solo : solos(static_cast<std::int32_t>(p))) {
      own = std::max(own, solo.weight - prices_.site[At(solo.site)]);
    }
    value_[p] = std::max(own, prices_.partner[p]);
    sum.Add(value_[p]);
  }
  least_value_ = value_.empty() ? 0 : *std::min_element(value_.begin(), value_.end());
  const auto arcs = ways_.size() + gain_of_.size();
  const int threads = arcs > 100000 ? threads_ : 1;
  ParallelFor(places_.size(), threads, 2, [&](std::size_t begin, std::size_t end) {
    PriceSites(static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end));
  });
  ParallelFor(best_value_.size(), threads, 2, [&](std::size_t begin, std::size_t end) {
    PriceUavs(static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end));
  });
  for (const double value : bound_value_) sum.Add(value);
  work_ += static_cast<std::int64_t>(arcs + solos_.size() + prices_.site.size());
  // The sum is good to two roundings; each term is made of at most a dozen operations.
  slack_ = 32 * std::numeric_limits<double>::epsilon() * sum.magnitude();
  return sum.value() + slack_;
}

/// What partners add at the current prices.
void Dual::PriceSites(std::int32_t begin, std::int32_t end) {
  for (std::int32_t s = begin; s < end; ++s) {
    Place& place = places_[At(s)];
    place.price = prices_.site[At(s)];
    place.most = -std::numeric_limits<double>::infinity();
    for (std::int32_t g = place.begin; g < place.end; ++g) {
      Group& group = groups_[At(g)];
      group.most = -std::numeric_limits<double>::infinity();
      for (std::int32_t j = group.begin; j < group.end; ++j) {
        const double adds = gain_of_[At(j)] - value_[At(partner_of_[At(j)])];
        adds_[At(j)] = adds;
        if (adds > group.most) {
          group.most = adds;
          group.best = j;
        }
      }
    }
    for (std::int32_t g = place.end; g-- > place.begin;) {
      place.most = std::max(place.most, groups_[At(g)].most);
      groups_[At(g)].most_on = place.most;
    }
  }
}

/// Best column of each UAV; of equal ones the first: staying, pairs by site and level, moves alone.
void Dual::PriceUavs(std::int32_t begin, std::int32_t end) {
  for (std::int32_t u = begin; u < end; ++u) {
    double best = instance_.uavs[At(u)].stay, rest_best = best;
    Column column;
    for (const Way& way : ways(u)) {
      const Place& place = places_[At(way.site)];
      const double own = way.gain - place.price;
      if (place.rest > 0) {
        const double inverse = InverseLevel(way.level, place.rest);
        rest_best = std::max(
            rest_best, own + way.base * inverse + Instance::kMostGain / place.rest - least_value_);
      }
      if (own + way.base * InverseLevel(way.level, place.least) + place.most <= best) continue;
      const Instance::UavArc& whole = instance_.uav_arcs[At(way.arc)];
      for (std::int32_t g = place.begin; g < place.end; ++g) {
        const Group& group = groups_[At(g)];
        const double rest = own + way.base * InverseLevel(way.level, group.level);
        if (rest + group.most_on <= best) break;  // higher levels make it less still
        if (rest + group.most <= best) continue;
        if (instance_.Compatible(whole, instance_.partner_arcs[At(group.best)])) {
          best = rest + group.most;
          column = {way.site, way.arc, group.best, 0};
          continue;
        }
        for (std::int32_t j = group.begin; j < group.end; ++j) {
          const double value = rest + adds_[At(j)];
          if (value > best && instance_.Compatible(whole, instance_.partner_arcs[At(j)])) {
            best = value;
            column = {way.site, way.arc, j, 0};
          }
        }
      }
    }
    for (const Solo& solo : uav_solos(u)) {
      const double value = solo.weight - prices_.site[At(solo.site)];
      if (value > best) {
        best = value;
        column = {solo.site, solo.arc, -1, 0};
      }
    }
    best_value_[At(u)] = best;
    bound_value_[At(u)] = std::max(best, rest_best);
    best_column_[At(u)] = column;
  }
}

template <class Visit>
void Dual::PairsNear(std::int32_t uav, const double& most, Visit&& visit) const {
  const double best = best_value_[At(uav)];
  for (const Way& way : ways(uav)) {
    const Place& place = places_[At(way.site)];
    const double own = best - (way.gain - place.price);
    if (own - way.base * InverseLevel(way.level, place.least) - place.most > most) continue;
    for (std::int32_t g = place.begin; g < place.end; ++g) {
      const double regret = own - way.base * InverseLevel(way.level, groups_[At(g)].level);
      if (regret - groups_[At(g)].most_on > most) break;  // of higher levels even more so
      if (regret - groups_[At(g)].most <= most) visit(way, regret, g);
    }
  }
}

void Dual::ColumnsOf(std::int32_t uav, double most, std::vector<Column>* columns) const {
  const double best = best_value_[At(uav)];
  const double stay = best - instance_.uavs[At(uav)].stay;
  if (stay <= most) columns->push_back({-1, -1, -1, stay});
  for (const Solo& solo : uav_solos(uav)) {
    const double regret = best - (solo.weight - prices_.site[At(solo.site)]);
    if (regret <= most) columns->push_back({solo.site, solo.arc, -1, regret});
  }
  PairsNear(uav, most, [&](const Way& way, double regret, std::int32_t g) {
    for (std::int32_t j = groups_[At(g)].begin; j < groups_[At(g)].end; ++j) {
      const double whole = regret - adds_[At(j)];
      if (whole <= most &&
          instance_.Compatible(instance_.uav_arcs[At(way.arc)], instance_.partner_arcs[At(j)])) {
        columns->push_back({way.site, way.arc, j, whole});
      }
    }
  });
}

void Dual::RankPartners() {
  ranked_.resize(groups_.size());
  ParallelFor(groups_.size(), threads_, 20000, [&](std::size_t begin, std::size_t end) {
    for (std::size_t g = begin; g < end; ++g) {
      std::array<std::int32_t, kRanks>& ranks = ranked_[g];
      std::array<double, kRanks> values;
      std::size_t n = 0;
      // Equal partners rank differently at different sites, so that they are not all offered the
      // same few.
      const std::int32_t size = groups_[g].end - groups_[g].begin;
      if (size == 1) {
        ranks = {groups_[g].begin, -1, -1, -1};
        continue;
      }
      std::int32_t j =
          groups_[g].begin + static_cast<std::int32_t>(Mix(g) % static_cast<std::uint32_t>(size));
      for (std::int32_t k0 = 0; k0 < size; ++k0, ++j) {
        if (j == groups_[g].end) j = groups_[g].begin;
        const double value = adds_[At(j)];
        if (n == kRanks && value <= values[n - 1]) continue;
        std::size_t k = n < kRanks ? n++ : n - 1;
        for (; k > 0 && values[k - 1] < value; --k) {
          values[k] = values[k - 1];
          ranks[k] = ranks[k - 1];
        }
        values[k] = value;
        ranks[k] = j;
      }
      for (; n < kRanks; ++n) ranks[n] = -1;
    }
  });
  work_ += static_cast<std::int64_t>(gain_of_.size());
}

void Dual::TopColumns(std::int32_t uav, double most, std::vector<Column>* columns) const {
  const Column& best = best_column_[At(uav)];
  if (best.site >= 0) columns->push_back(best);
  PairsNear(uav, most, [&](const Way& way, double regret, std::int32_t g) {
    for (const std::int32_t j : ranked_[At(g)]) {
      if (j < 0) break;
      const double whole = regret - adds_[At(j)];
      if (whole > most) break;
      if (way.arc == best.uav_arc && j == best.partner_arc) continue;
      if (instance_.Compatible(instance_.uav_arcs[At(way.arc)], instance_.partner_arcs[At(j)])) {
        columns->push_back({way.site, way.arc, j, whole});
      }
    }
  });
}

Column Dual::BestFree(std::int32_t uav, std::span<const std::int32_t> free_places,
                      std::span<const char> partner_free) const {
  const double best = best_value_[At(uav)];
  Column found{-1, -1, -1, best - instance_.uavs[At(uav)].stay};
  for (const Solo& solo : uav_solos(uav)) {
    const double regret = best - (solo.weight - prices_.site[At(solo.site)]);
    if (free_places[At(solo.site)] > 0 && regret < found.regret) {
      found = {solo.site, solo.arc, -1, regret};
    }
  }
  PairsNear(uav, found.regret, [&](const Way& way, double regret, std::int32_t g) {
    if (free_places[At(way.site)] <= 0) return;
    for (std::int32_t j = groups_[At(g)].begin; j < groups_[At(g)].end; ++j) {
      const double whole = regret - adds_[At(j)];
      if (whole < found.regret && partner_free[At(partner_of_[At(j)])] &&
          instance_.Compatible(instance_.uav_arcs[At(way.arc)], instance_.partner_arcs[At(j)])) {
        found = {way.site, way.arc, j, whole};
      }
    }
  });
  return found;
}

}  // namespace muster::scheduler
