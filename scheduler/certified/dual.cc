#include "scheduler/certified/dual.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scheduler/certified/parallel.h"

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
  const auto n_sites = At(instance.n_sites());
  group_begin_.push_back(0);
  site_of_arc_.resize(instance.uav_arcs.size());
  std::int32_t highest = 1;
  for (std::size_t s = 0; s < n_sites; ++s) {
    for (std::int32_t j = instance.partner_begin[s]; j < instance.partner_begin[s + 1]; ++j) {
      const std::int32_t level = instance.partner_arcs[At(j)].level;
      if (j == instance.partner_begin[s] || groups_.back().level != level) {
        groups_.push_back({j, j, level});
      }
      groups_.back().end = j + 1;
      highest = std::max(highest, level);
    }
    group_begin_.push_back(static_cast<std::int32_t>(groups_.size()));
    for (std::int32_t i = instance.uav_begin[s]; i < instance.uav_begin[s + 1]; ++i) {
      site_of_arc_[At(i)] = static_cast<std::int32_t>(s);
    }
  }
  arc_begin_.assign(instance.uavs.size() + 1, 0);
  hot_.reserve(instance.uav_arcs.size());
  for (std::size_t i = 0; i < instance.uav_arcs.size(); ++i) {
    const Instance::UavArc& arc = instance.uav_arcs[i];
    hot_.push_back({arc.uav, arc.level, arc.base, arc.pair_gain});
    ++arc_begin_[At(arc.uav) + 1];
    highest = std::max(highest, arc.level);
    if (arc.solo > instance.uavs[At(arc.uav)].stay) {
      uav_solos_.push_back(static_cast<std::int32_t>(i));
    }
  }
  for (std::size_t u = 0; u < instance.uavs.size(); ++u) arc_begin_[u + 1] += arc_begin_[u];
  arc_of_uav_.resize(instance.uav_arcs.size());
  std::vector<std::int32_t> next(arc_begin_.begin(), arc_begin_.end() - 1);
  for (std::size_t i = 0; i < instance.uav_arcs.size(); ++i) {
    arc_of_uav_[At(next[At(hot_[i].uav)]++)] = static_cast<std::int32_t>(i);
  }

  solo_begin_.assign(instance.partners.size() + 1, 0);
  const auto is_solo = [&](const Instance::PartnerArc& arc) {
    return arc.solo && arc.gain > instance.partners[At(arc.partner)].stay;
  };
  for (const Instance::PartnerArc& arc : instance.partner_arcs) {
    partner_of_.push_back(arc.partner);
    gain_of_.push_back(arc.gain);
    if (is_solo(arc)) ++solo_begin_[At(arc.partner) + 1];
    most_gain_ = std::max(most_gain_, arc.gain - instance.partners[At(arc.partner)].stay);
  }
  for (std::size_t p = 0; p < instance.partners.size(); ++p) solo_begin_[p + 1] += solo_begin_[p];
  solos_.resize(At(solo_begin_.back()));
  next.assign(solo_begin_.begin(), solo_begin_.end() - 1);
  for (std::size_t s = 0; s < n_sites; ++s) {
    for (std::int32_t j = instance.partner_begin[s]; j < instance.partner_begin[s + 1]; ++j) {
      const Instance::PartnerArc& arc = instance.partner_arcs[At(j)];
      if (is_solo(arc)) {
        solos_[At(next[At(arc.partner)]++)] = {static_cast<std::int32_t>(s), j, arc.gain};
      }
    }
  }

  for (std::int32_t level = 0; level <= std::min(highest, 4096); ++level) {
    inverse_.push_back(1.0 / std::max(level, 1));
  }
  prices_.site.assign(n_sites, 0);
  for (const Instance::Partner& partner : instance.partners) {
    prices_.partner.push_back(partner.stay);
  }
  value_.resize(instance.partners.size());
  best_value_.resize(instance.uavs.size());
  best_column_.resize(instance.uavs.size());
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

  for (std::size_t u = 0; u < best_value_.size(); ++u) {
    best_value_[u] = instance_.uavs[u].stay;
    best_column_[u] = Column{};
  }
  const auto n_sites = instance_.n_sites();
  const auto arcs = hot_.size() + gain_of_.size();
  if (threads_ > 1 && arcs > 100000) {
    // The halves keep their own best columns; equal values go to the lower site as in one pass.
    other_value_ = best_value_;
    other_column_ = best_column_;
    ParallelFor(2, 2, 2, [&](std::size_t begin, std::size_t) {
      if (begin == 0) {
        PriceSites(0, n_sites / 2, &best_value_, &best_column_);
      } else {
        PriceSites(n_sites / 2, n_sites, &other_value_, &other_column_);
      }
    });
    for (std::size_t u = 0; u < best_value_.size(); ++u) {
      if (other_value_[u] > best_value_[u]) {
        best_value_[u] = other_value_[u];
        best_column_[u] = other_column_[u];
      }
    }
  } else {
    PriceSites(0, n_sites, &best_value_, &best_column_);
  }
  for (const std::int32_t i : uav_solos_) {
    const auto u = At(hot_[At(i)].uav);
    const double value = instance_.uav_arcs[At(i)].solo - prices_.site[At(site_of_arc_[At(i)])];
    if (value > best_value_[u]) {
      best_value_[u] = value;
      best_column_[u] = {site_of_arc_[At(i)], i, -1, 0};
    }
  }
  for (const double value : best_value_) sum.Add(value);
  work_ += static_cast<std::int64_t>(arcs + solos_.size() + prices_.site.size());
  // The sum is good to two roundings; each term is made of at most a dozen operations.
  slack_ = 32 * std::numeric_limits<double>::epsilon() * sum.magnitude();
  return sum.value() + slack_;
}

void Dual::PriceSites(std::int32_t begin, std::int32_t end, std::vector<double>* best_value,
                      std::vector<Column>* best_column) const {
  struct Top {
    double value;
    std::int32_t arc;
  };
  std::vector<Top> tops;
  for (std::int32_t s = begin; s < end; ++s) {
    const std::int32_t uav_begin = instance_.uav_begin[At(s)];
    const std::int32_t uav_end = instance_.uav_begin[At(s) + 1];
    const std::span<const Group> groups(groups_.data() + group_begin_[At(s)],
                                        At(group_begin_[At(s) + 1] - group_begin_[At(s)]));
    if (uav_begin == uav_end || groups.empty()) continue;
    tops.clear();
    double highest = -std::numeric_limits<double>::infinity();
    for (const Group& group : groups) {
      Top top{-std::numeric_limits<double>::infinity(), -1};
      for (std::int32_t j = group.begin; j < group.end; ++j) {
        const double value = gain_of_[At(j)] - value_[At(partner_of_[At(j)])];
        if (value > top.value) top = {value, j};
      }
      tops.push_back(top);
      highest = std::max(highest, top.value);
    }
    const double price = prices_.site[At(s)];
    const std::int32_t least = groups.front().level;
    for (std::int32_t i = uav_begin; i < uav_end; ++i) {
      const HotUavArc& arc = hot_[At(i)];
      double best = (*best_value)[At(arc.uav)];
      const double own = arc.gain - price;
      if (own + arc.base * InverseLevel(arc.level, least) + highest <= best) continue;
      const Instance::UavArc& whole = instance_.uav_arcs[At(i)];
      std::int32_t partner_arc = -1;
      for (std::size_t g = 0; g < groups.size(); ++g) {
        const double rest = own + arc.base * InverseLevel(arc.level, groups[g].level);
        if (rest + tops[g].value <= best) continue;
        if (instance_.Compatible(whole, instance_.partner_arcs[At(tops[g].arc)])) {
          best = rest + tops[g].value;
          partner_arc = tops[g].arc;
          continue;
        }
        for (std::int32_t j = groups[g].begin; j < groups[g].end; ++j) {
          const double value = rest + (gain_of_[At(j)] - value_[At(partner_of_[At(j)])]);
          if (value > best && instance_.Compatible(whole, instance_.partner_arcs[At(j)])) {
            best = value;
            partner_arc = j;
          }
        }
      }
      if (partner_arc < 0) continue;
      (*best_value)[At(arc.uav)] = best;
      (*best_column)[At(arc.uav)] = {s, i, partner_arc, 0};
    }
  }
}

void Dual::ColumnsOf(std::int32_t uav, double most, std::vector<Column>* columns) const {
  const double best = best_value_[At(uav)];
  const double stay = best - instance_.uavs[At(uav)].stay;
  if (stay <= most) columns->push_back({-1, -1, -1, stay});
  for (const std::int32_t i : arcs(uav)) {
    const Instance::UavArc& arc = instance_.uav_arcs[At(i)];
    const std::int32_t s = site_of_arc_[At(i)];
    const double price = prices_.site[At(s)];
    if (arc.solo > instance_.uavs[At(uav)].stay && best - (arc.solo - price) <= most) {
      columns->push_back({s, i, -1, best - (arc.solo - price)});
    }
    if (arc.pair_gain == Instance::kNone) continue;
    for (std::int32_t g = group_begin_[At(s)]; g < group_begin_[At(s) + 1]; ++g) {
      const Group& group = groups_[At(g)];
      const double regret =
          best - (arc.pair_gain - price + arc.base * InverseLevel(arc.level, group.level));
      if (regret - most_gain_ > most) continue;
      for (std::int32_t j = group.begin; j < group.end; ++j) {
        const double whole = regret - (gain_of_[At(j)] - value_[At(partner_of_[At(j)])]);
        if (whole <= most && instance_.Compatible(arc, instance_.partner_arcs[At(j)])) {
          columns->push_back({s, i, j, whole});
        }
      }
    }
  }
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
      const auto first = static_cast<std::int32_t>(Mix(g) % static_cast<std::uint32_t>(size));
      for (std::int32_t k0 = 0; k0 < size; ++k0) {
        const std::int32_t j = groups_[g].begin + (first + k0) % size;
        const double value = gain_of_[At(j)] - value_[At(partner_of_[At(j)])];
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
  const double best = best_value_[At(uav)];
  if (best_column_[At(uav)].site >= 0) columns->push_back(best_column_[At(uav)]);
  for (const std::int32_t i : arcs(uav)) {
    const Instance::UavArc& arc = instance_.uav_arcs[At(i)];
    if (arc.pair_gain == Instance::kNone) continue;
    const std::int32_t s = site_of_arc_[At(i)];
    const double own = best - (arc.pair_gain - prices_.site[At(s)]);
    for (std::int32_t g = group_begin_[At(s)]; g < group_begin_[At(s) + 1]; ++g) {
      const double regret = own - arc.base * InverseLevel(arc.level, groups_[At(g)].level);
      if (regret - most_gain_ > most) continue;
      for (const std::int32_t j : ranked_[At(g)]) {
        if (j < 0) break;
        const double whole = regret - (gain_of_[At(j)] - value_[At(partner_of_[At(j)])]);
        if (whole > most) break;
        if (i == best_column_[At(uav)].uav_arc && j == best_column_[At(uav)].partner_arc) continue;
        if (instance_.Compatible(arc, instance_.partner_arcs[At(j)])) {
          columns->push_back({s, i, j, whole});
        }
      }
    }
  }
}

Column Dual::BestFree(std::int32_t uav, std::span<const std::int32_t> free_places,
                      std::span<const char> partner_free) const {
  const double best = best_value_[At(uav)];
  Column found{-1, -1, -1, best - instance_.uavs[At(uav)].stay};
  for (const std::int32_t i : arcs(uav)) {
    const Instance::UavArc& arc = instance_.uav_arcs[At(i)];
    const std::int32_t s = site_of_arc_[At(i)];
    if (free_places[At(s)] <= 0) continue;
    const double price = prices_.site[At(s)];
    if (arc.solo != Instance::kNone && best - (arc.solo - price) < found.regret) {
      found = {s, i, -1, best - (arc.solo - price)};
    }
    if (arc.pair_gain == Instance::kNone) continue;
    for (std::int32_t g = group_begin_[At(s)]; g < group_begin_[At(s) + 1]; ++g) {
      const Group& group = groups_[At(g)];
      const double regret =
          best - (arc.pair_gain - price + arc.base * InverseLevel(arc.level, group.level));
      if (regret - most_gain_ >= found.regret) continue;
      for (std::int32_t j = group.begin; j < group.end; ++j) {
        const auto p = At(partner_of_[At(j)]);
        const double whole = regret - (gain_of_[At(j)] - value_[p]);
        if (whole < found.regret && partner_free[p] &&
            instance_.Compatible(arc, instance_.partner_arcs[At(j)])) {
          found = {s, i, j, whole};
        }
      }
    }
  }
  return found;
}

}  // namespace muster::scheduler
