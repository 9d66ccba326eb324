#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/scenario.h"

namespace muster::tools {

/// Ways are rounded to microseconds, leg by leg: a way in a thousand legs may be this much shorter.
inline constexpr TimeUs kRoundingUs = 1000;

/// What an agent and a partner do together at a place: the sensing of a task, or charging.
struct Visit {
  std::int32_t site = -1;
  std::int32_t free_at = -1;  ///< the first decision that is not before its end
};

/// What one more visit is worth to an agent: [sites, decisions].
class Prices {
 public:
  Prices(std::size_t sites, std::int32_t decisions, double each)
      : decisions_(static_cast<std::size_t>(decisions)), of_(sites * decisions_, each) {}

  std::size_t size() const { return of_.size(); }
  std::size_t IndexOf(Visit visit) const {
    return static_cast<std::size_t>(visit.site) * decisions_ +
           static_cast<std::size_t>(visit.free_at);
  }
  double& operator[](std::size_t i) { return of_[i]; }
  double operator[](std::size_t i) const { return of_[i]; }
  double operator[](Visit visit) const { return of_[IndexOf(visit)]; }

 private:
  std::size_t decisions_;
  std::vector<double> of_;
};

/// When one agent can be where, at the earliest.
struct AgentReach {
  std::int32_t first = 0;          ///< its first decision
  std::int32_t last = -1;          ///< its last one; before `first`: none
  TimeUs latest_us = 0;            ///< its visits have ended
  std::vector<TimeUs> from_start;  ///< [sites] from when it sets out to the end of a visit
};

/// What agents of one kind and speed take between places, and when visits can end. The first places
/// are the sites.
struct Timetable {
  TimeUs interval_us = 0;
  std::int32_t decisions = 0;      ///< at which an agent can be free again
  bool again = false;              ///< an agent may visit a site twice in a row
  std::vector<TimeUs> between_us;  ///< [places, sites] from one place to a visit's end at the other
  std::vector<std::int32_t> between;  ///< the same in intervals, rounded up
  std::vector<std::int32_t> from;     ///< [sites] the first decision that a visit can end before
  std::vector<std::int32_t> until;    ///< [sites] the last one

  std::size_t sites() const { return from.size(); }
  /// The first decision at or after that time.
  std::int32_t DecisionAfter(TimeUs us) const {
    return static_cast<std::int32_t>((us + interval_us - 1) / interval_us);
  }
};

/// The visits of one agent that are worth most together, and what they are worth. Every list of
/// visits that the agent can make in a mission is among those that are searched, and some that it
/// cannot: those that return to a site after another one. Source: longest ways in a graph without
/// cycles (sites by decisions), cycles of two sites left out (Houck, Picard, Queyranne and
/// Vemuganti 1980).
struct BestList {
  double worth = 0;
  std::vector<Visit> visits;
};
BestList BestListOf(const Timetable& table, const AgentReach& agent, const Prices& prices);

/// A UAV, which has a range. Its places are the tasks, then the charging points.
struct UavTimes {
  AgentReach tasks;             ///< `from_start`: [tasks]
  std::vector<double> start_m;  ///< [places] its way from where it starts
  double speed_m_s = 0;
  double range_m = 0, range_full_m = 0;
};
struct UavTable {
  Timetable tasks;                  ///< `between`: [places, tasks]
  std::vector<double> way_m;        ///< [places, places]
  std::vector<double> cost_m;       ///< [tasks]
  std::vector<double> to_charge_m;  ///< [tasks]
  double most_charge_m_s = 0;       ///< of the fastest vehicle; 0: there is none
  std::size_t charging_points = 0;
};
/// The same of a UAV: sites are places. `charges`: what it pays for charging, by charging point.
BestList BestFlightsOf(const UavTable& table, const UavTimes& uav, const Prices& prices,
                       const Prices& charges);

}  // namespace muster::tools
