#include "tools/bound/timetable.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/index.h"

namespace muster::tools {
namespace {

/// Range is added up in another order than in a mission.
constexpr double kRoundingM = 1e-3;

/// A list of visits that begins with this one.
struct Head {
  double worth = 0;  ///< of all
  Visit first;       ///< site -1: the list is empty
  int rest = 0;      ///< which of the two lists that can follow it
};

/// The two best lists that begin at different sites.
struct TwoBest {
  std::array<Head, 2> lists;

  void Offer(const Head& head) {
    if (head.worth > lists[0].worth) {
      if (head.first.site != lists[0].first.site) lists[1] = lists[0];
      lists[0] = head;
    } else if (head.first.site != lists[0].first.site && head.worth > lists[1].worth) {
      lists[1] = head;
    }
  }
};

/// From the last decision back to the first: what can follow a visit to each site.
class ListSearch {
 public:
  ListSearch(const Timetable& table, const AgentReach& agent, const Prices& prices)
      : table_(table),
        agent_(agent),
        prices_(prices),
        n_(table.sites()),
        end_(std::min(table.decisions - 1, table.DecisionAfter(agent.latest_us))),
        places_(table.between.size() / std::max<std::size_t>(1, n_)),
        follows_(places_ * At(table.decisions)),
        ending_(n_ * At(table.decisions + 1)) {
    for (std::int32_t e = end_; e > agent_.first; --e) {
      for (std::size_t p = 0; p < places_ && e <= agent_.last; ++p) FillFollowing(p, e);
      for (std::size_t x = 0; x < n_; ++x) FillEnding(x, e);
    }
  }

  /// What is worth most after the agent is free at that place at that decision, after its first.
  double Following(std::size_t place, std::int32_t e) const {
    return follows_[Index(place, e)].lists[0].worth;
  }

  BestList Best() const {
    BestList best;
    if (agent_.last < agent_.first) return best;
    TwoBest all;
    const TimeUs begin_us = agent_.first * table_.interval_us;
    for (std::size_t x = 0; x < n_; ++x) {
      const TimeUs us = agent_.from_start[x];
      if (us > agent_.latest_us - begin_us) continue;
      Take(x, std::max(table_.DecisionAfter(begin_us + us), agent_.first + 1), -1, &all);
    }
    best.worth = all.lists[0].worth;
    for (Head head = all.lists[0]; head.first.site >= 0;) {
      best.visits.push_back(head.first);
      head = follows_[Index(At(head.first.site), head.first.free_at)].lists[At(head.rest)];
    }
    return best;
  }

 private:
  /// Lists whose first visit is at that site; `after`, the site of the one before.
  struct Ending {
    double worth = 0;
    std::int32_t free_at = -1;
    std::int32_t next = -1;  ///< site of the second visit
    int rest = 0;
  };
  std::size_t Index(std::size_t place, std::int32_t decision) const {
    return place * At(table_.decisions) + At(decision);
  }

  /// Offers the best list whose first visit is at x and ends between `from` and the agent's end,
  /// and whose second is not at `after`.
  void Take(std::size_t x, std::int32_t from, std::int32_t after, TwoBest* best) const {
    from = std::max(from, table_.from[x]);
    if (from > end_) return;
    for (const Ending& ending : ending_[x * At(table_.decisions + 1) + At(from)]) {
      if (ending.free_at < 0 || (after >= 0 && ending.next == after)) continue;
      best->Offer({ending.worth, {static_cast<std::int32_t>(x), ending.free_at}, ending.rest});
      return;
    }
  }

  void FillFollowing(std::size_t x, std::int32_t e) {
    TwoBest best;
    const TimeUs left_us = agent_.latest_us - e * table_.interval_us;
    const TimeUs* const us = &table_.between_us[x * n_];
    const std::int32_t* const intervals = &table_.between[x * n_];
    for (std::size_t y = 0; y < n_; ++y) {
      if (us[y] > left_us || (y == x && !table_.again)) continue;
      Take(y, e + std::max(1, intervals[y]), table_.again ? -1 : static_cast<std::int32_t>(x),
           &best);
    }
    follows_[Index(x, e)] = best;
  }

  void FillEnding(std::size_t x, std::int32_t e) {
    std::array<Ending, 2> best = ending_[x * At(table_.decisions + 1) + At(e) + 1];
    const double price = prices_[Visit{static_cast<std::int32_t>(x), e}];
    const TwoBest& following = follows_[Index(x, e)];
    for (int i = 0; i < 2 && e <= table_.until[x]; ++i) {
      const Head& rest = following.lists[At(i)];
      if (i == 1 && following.lists[0].first.site < 0) break;
      const Ending ending{price + rest.worth, e, rest.first.site, i};
      if (ending.worth <= 0) continue;
      if (best[0].free_at < 0 || ending.worth > best[0].worth) {
        if (best[0].next != ending.next || best[0].free_at < 0) best[1] = best[0];
        best[0] = ending;
      } else if (ending.next != best[0].next &&
                 (best[1].free_at < 0 || ending.worth > best[1].worth)) {
        best[1] = ending;
      }
    }
    ending_[x * At(table_.decisions + 1) + At(e)] = best;
  }

  const Timetable& table_;
  const AgentReach& agent_;
  const Prices& prices_;
  const std::size_t n_;
  const std::int32_t end_;
  const std::size_t places_;
  std::vector<TwoBest> follows_;  ///< [places, decisions]
  /// [sites, decisions + 1] after whose first visit the agent is free at that decision or later
  std::vector<std::array<Ending, 2>> ending_;
};

/// Where a UAV can be, with what range, and what it has earned by then. What is worth most together
/// with all that could follow, had it range without end, is followed first (A*).
class FlightSearch {
 public:
  FlightSearch(const UavTable& table, const UavTimes& uav, const Prices& prices,
               const Prices& charges)
      : table_(table),
        uav_(uav),
        prices_(prices),
        charges_(charges),
        n_tasks_(table.tasks.sites()),
        n_places_(n_tasks_ + table.charging_points),
        endless_(table.tasks, uav.tasks, prices),
        end_(std::min(table.tasks.decisions - 1, table.tasks.DecisionAfter(uav.tasks.latest_us))),
        at_(n_places_ * At(table.tasks.decisions)) {}

  BestList Find() {
    if (uav_.tasks.last >= uav_.tasks.first) {
      Go(-1, uav_.range_m, 0, -1, uav_.tasks.first, uav_.tasks.from_start.data(), nullptr,
         uav_.start_m.data(), -1);
      while (!waiting_.empty() && waiting_.front().first > BestWorth()) {
        const std::int32_t i = waiting_.front().second;
        std::pop_heap(waiting_.begin(), waiting_.end());
        waiting_.pop_back();
        GoOn(i);
      }
    }
    BestList best;
    best.worth = BestWorth();
    for (std::int32_t i = best_; i >= 0; i = labels_[At(i)].before) {
      best.visits.push_back({labels_[At(i)].place, labels_[At(i)].free_at});
    }
    std::reverse(best.visits.begin(), best.visits.end());
    return best;
  }

 private:
  struct Label {
    double worth, range_m;
    std::int32_t place, free_at;
    std::int32_t before;        ///< label; -1: its start
    std::int32_t before_place;  ///< -1: its start
  };

  double BestWorth() const { return best_ < 0 ? 0 : labels_[At(best_)].worth; }

  /// Unless others there are worth as much with as much range: one that came from the same place,
  /// or two that came from different ones, as each may not go back to where it came from.
  void GoOn(std::int32_t i) {
    const Label label = labels_[At(i)];
    if (label.free_at > uav_.tasks.last) return;
    std::vector<std::int32_t>& here =
        at_[At(label.place) * At(table_.tasks.decisions) + At(label.free_at)];
    std::int32_t from = -2;
    for (const std::int32_t j : here) {
      const Label& other = labels_[At(j)];
      if (other.worth < label.worth || other.range_m < label.range_m) continue;
      if (other.before_place == label.before_place) return;
      if (from != -2 && from != other.before_place) return;
      from = other.before_place;
    }
    here.push_back(i);
    const auto place = At(label.place);
    Go(label.place, label.range_m, label.worth, i, label.free_at,
       &table_.tasks.between_us[place * n_tasks_], &table_.tasks.between[place * n_tasks_],
       &table_.way_m[place * n_places_], label.before_place);
  }

  /// From a place at a decision to all that it can reach. `us`, `intervals`: [tasks] to the end of
  /// sensing there (null: not given); `way_m`: [places].
  void Go(std::int32_t place, double range_m, double worth, std::int32_t before, std::int32_t e,
          const TimeUs* us, const std::int32_t* intervals, const double* way_m,
          std::int32_t not_to) {
    const TimeUs begin_us = e * table_.tasks.interval_us;
    const TimeUs left_us = uav_.tasks.latest_us - begin_us;
    for (std::size_t x = 0; x < n_tasks_; ++x) {
      const auto site = static_cast<std::int32_t>(x);
      if (us[x] > left_us || site == place || site == not_to) continue;
      const double rest_m = range_m - way_m[x] - table_.cost_m[x];
      if (rest_m + kRoundingM < table_.to_charge_m[x]) continue;
      std::int32_t end =
          intervals != nullptr ? e + intervals[x] : table_.tasks.DecisionAfter(begin_us + us[x]);
      end = std::max({end, e + 1, table_.tasks.from[x]});
      double most = 0;
      for (; end <= std::min(end_, table_.tasks.until[x]); ++end) {
        const double price = prices_[Visit{site, end}];
        if (price <= most) continue;
        most = price;
        Add({worth + price, rest_m, site, end, before, place});
      }
    }
    if (table_.most_charge_m_s <= 0) return;
    // As much as there is time for: a vehicle that fails ends a charge before the UAV is full.
    for (std::size_t c = 0; c < table_.charging_points; ++c) {
      const double flown_m = way_m[n_tasks_ + c];
      const auto to = static_cast<std::int32_t>(n_tasks_ + c);
      if (flown_m > range_m + kRoundingM || to == place) continue;
      const TimeUs there_us =
          begin_us + std::max<TimeUs>(0, DurationUs(flown_m, uav_.speed_m_s) - kRoundingUs);
      if (there_us > uav_.tasks.latest_us) continue;
      double least = kNoCharge, most_m = range_m - flown_m;
      for (std::int32_t end = std::max(e + 1, table_.tasks.DecisionAfter(there_us));
           end <= std::min(end_, uav_.tasks.last); ++end) {
        const double charge = charges_[Visit{static_cast<std::int32_t>(c), end}];
        const double after_m = std::min(
            uav_.range_full_m,
            range_m - flown_m +
                table_.most_charge_m_s * ToSeconds(end * table_.tasks.interval_us - there_us));
        if (charge >= least && after_m <= most_m) continue;
        least = std::min(least, charge);
        most_m = std::max(most_m, after_m);
        Add({worth - charge, after_m, to, end, before, place});
      }
    }
  }

  void Add(const Label& label) {
    const double most =
        label.worth +
        (label.free_at > uav_.tasks.last ? 0 : endless_.Following(At(label.place), label.free_at));
    if (most <= BestWorth()) return;
    const auto i = static_cast<std::int32_t>(labels_.size());
    labels_.push_back(label);
    if (label.worth > BestWorth()) best_ = i;
    waiting_.emplace_back(most, i);
    std::push_heap(waiting_.begin(), waiting_.end());
  }

  static constexpr double kNoCharge = 1e300;

  const UavTable& table_;
  const UavTimes& uav_;
  const Prices &prices_, &charges_;
  const std::size_t n_tasks_, n_places_;
  const ListSearch endless_;
  const std::int32_t end_;
  std::vector<std::vector<std::int32_t>> at_;  ///< [places, decisions] labels gone on from
  std::vector<Label> labels_;
  std::vector<std::pair<double, std::int32_t>> waiting_;  ///< a heap: most to expect, label
  std::int32_t best_ = -1;
};

}  // namespace

BestList BestListOf(const Timetable& table, const AgentReach& agent, const Prices& prices) {
  return ListSearch(table, agent, prices).Best();
}

BestList BestFlightsOf(const UavTable& table, const UavTimes& uav, const Prices& prices,
                       const Prices& charges) {
  return FlightSearch(table, uav, prices, charges).Find();
}

}  // namespace muster::tools
