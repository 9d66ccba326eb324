#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/action.h"
#include "model/scenario.h"
#include "model/ways.h"

namespace muster {

/// A pair's sensing or charging, exact and known from the moment that both legs are.
struct Activity {
  using Kind = ActivityKind;
  Kind kind = Kind::kSensing;
  UavId uav;
  std::int32_t partner = -1;  ///< worker or vehicle
  std::int32_t site = -1;     ///< task or charging point
  TimeUs start_us = 0;        ///< the later arrival
  TimeUs end_us = 0;

  bool operator==(const Activity&) const = default;
};

inline AgentKind PartnerKind(Activity::Kind kind) {
  return kind == Activity::Kind::kSensing ? AgentKind::kWorker : AgentKind::kVehicle;
}

/// The world's word on one agent, which that agent cannot know by itself.
struct Ruling {
  using Kind = RulingKind;
  AgentKind agent_kind = AgentKind::kUav;
  std::int32_t agent = -1;
  Kind kind = Kind::kFailed;
  TimeUs at_us = 0;

  bool fails() const { return kind != Kind::kReleased; }
  bool operator==(const Ruling&) const = default;
};

/// What a measured agent (measured.h) has reported of its present leg.
struct Measured {
  /// Where, when and with what range it has reported to be.
  struct Seen {
    Point at;
    TimeUs at_us = 0;
    double range_m = 0;
  };
  Seen seen;              ///< the last report
  Seen anchor;            ///< the report when the leg began
  Point origin;           ///< of the leg
  TimeUs set_out_us = 0;  ///< when it set out on the leg, or came to stand still
  TimeUs planned_us = 0;  ///< arrival as planned then
  bool arrived = false;
  bool done = false;                         ///< with its sensing or charging
  bool overdue = false;                      ///< it should have been done by now
  std::optional<double> range_after_m = {};  ///< that it has then; none: as computed
};

/// An agent as a function of time: one leg, the way from `from` (left at depart_us) to `to`
/// (reached at arrive_us), then, for a pair action, an activity at `to`. All fields are exact;
/// where the agent is at a time follows from them and never from a tick's length.
struct AgentState {
  AgentKind kind = AgentKind::kUav;
  std::int32_t id = -1;
  double speed_m_s = 0;
  double range_full_m = 0;
  double charge_rate_m_s = 0;
  TimeUs online_from_us = 0;
  TimeUs online_until_us = 0;
  /// How it travels now, and how it does on its leg. The scenario's, which outlives the agent. A
  /// leg keeps the ways that it began with until a road on it is closed.
  const Ways* ways = &StraightWays();
  const Ways* leg_ways = ways;

  Point from, to;
  TimeUs depart_us = 0;
  TimeUs arrive_us = 0;
  double range_at_departure_m = 0;
  double range_per_m = 1;  ///< range spent per metre of this leg: 1, more in wind

  ActionKind action = ActionKind::kNone;  ///< under way; kNone when free
  std::int32_t target = -1;  ///< task or charging point of the action; of kGoTo: its numbered stop
  std::int32_t partner = -1;
  std::int32_t decision = -1;  ///< that commanded the last action
  /// kNever while a pair's activity is not known yet, and of an agent that is not ready.
  TimeUs busy_until_us = 0;
  std::optional<Activity> activity;  ///< of the action under way, once known
  bool failed = false;
  std::optional<Measured> measured;  ///< none: it does what is computed

  bool online(TimeUs t) const { return online_from_us <= t && t < online_until_us; }
  /// A place that an order may fill.
  bool is_vacant() const { return online_until_us == 0; }
  /// May be scheduled at t: online, not failed, nothing under way.
  bool idle(TimeUs t) const { return online(t) && !failed && busy_until_us <= t; }
  /// Its driver says that it cannot set out yet: nobody plans with it.
  bool not_ready() const {
    return action == ActionKind::kNone && busy_until_us == kNever && !failed;
  }
  /// The task or charging point of the action; -1: it has none.
  std::int32_t site() const { return action == ActionKind::kGoTo ? -1 : target; }
  WaysOf own_ways() const { return {ways, kind}; }
  /// Metres of its way between two places.
  double WayM(Point a, Point b) const { return ways->Length(kind, a, b); }
  /// Metres that it has made from one place to the other, where it is.
  double GoneM(Point a, Point b) const { return ways->Gone(kind, a, b); }
  /// Metres of the leg that it is on, by the ways that it set out by.
  double LegM() const { return leg_ways->Length(kind, from, to); }
};

/// A fresh agent at mission start.
AgentState StartOf(AgentKind kind, std::int32_t id, const AgentSpec& spec, const Ways& ways);

/// How long it stays at the place where its leg begins before it sets out. A computed UAV that
/// waits for its altitude has more time for its leg than its way takes.
TimeUs HoldUs(const AgentState& agent);

/// When it comes on its leg to what is closed by `now`, not before since_us; none: it does not.
std::optional<TimeUs> BarredAt(const AgentState& agent, TimeUs since_us, const Ways& now);

/// The ways have changed at t; those that are closed have been so since since_us, in the last tick.
/// An agent that is under way to what is closed goes round: from where it stands before it, or from
/// where it is at t. If no way is left, it stops there, free. A measured agent takes the new ways
/// in any case, for the rest of its leg from where it is at t.
void GoRound(AgentState* agent, TimeUs since_us, TimeUs t, const Ways& now);

/// Where the agent is at t (t >= depart_us).
Point PositionAt(const AgentState& agent, TimeUs t);

/// Range left at t on the leg, metres: what it had at departure less the way since. Never below 0.
double RangeOnWayAt(const AgentState& agent, TimeUs t);

/// Range left at t, metres; 0 for workers and vehicles. Falls linearly on the way and while sensing
/// (by the task's cost over the whole activity), rises linearly to full while charging. Never below
/// 0. `tasks` gives the sensing cost.
double RangeAt(const AgentState& agent, TimeUs t, std::span<const Task> tasks);

AgentStatus StatusAt(const AgentState& agent, TimeUs t);

/// Range may fall this far below zero by rounding on a plan that uses the last metre.
inline constexpr double kRangeSlack_m = 1e-6;

/// Time at which the UAV's range reaches 0 on its way; none when it arrives with range left or more
/// than -1e-6 m (a plan may use the last metre), and for a measured one, which says so itself.
std::optional<TimeUs> RunsDryAt(const AgentState& uav);

/// Time at which the UAV's range reaches 0 while it senses, as wind on its way can make it; none
/// when it suffices (to -1e-6 m). The UAV is on the leg that led it there.
std::optional<TimeUs> RunsDryAt(const AgentState& uav, const Activity& sensing,
                                std::span<const Task> tasks);

/// Sensing or charging of a pair whose legs are both known (exact, docs/reference/mission.md).
/// Source: constraints (2) and (4); it starts at the later arrival.
Activity PlanActivity(const AgentState& uav, const AgentState& partner,
                      std::span<const Task> tasks);

/// What the world has told about one tick, indexed by agent.
class Verdict {
 public:
  Verdict() = default;
  Verdict(std::vector<Activity> activities, std::vector<Ruling> rulings);

  /// In order of (UAV, start).
  const std::vector<Activity>& activities() const { return activities_; }
  /// In order of (agent kind, agent, failures first).
  const std::vector<Ruling>& rulings() const { return rulings_; }
  /// Those of one agent; O(log n).
  std::span<const Ruling> rulings_of(AgentKind kind, std::int32_t id) const;
  /// Calls visit(activity) for those of one agent; O(log n).
  template <class Visit>
  void ForEachActivityOf(AgentKind kind, std::int32_t id, Visit visit) const {
    const auto& order = orders_[kind];
    for (auto i = LowerBound(kind, id); i < order.size(); ++i) {
      const Activity& activity = activities_[order[i]];
      if (Member(activity, kind) != id) break;
      visit(activity);
    }
  }

 private:
  /// The id of the agent of that kind in the activity, or -1.
  static std::int32_t Member(const Activity& activity, AgentKind kind);
  std::size_t LowerBound(AgentKind kind, std::int32_t id) const;

  std::vector<Activity> activities_;
  std::vector<Ruling> rulings_;
  PerKind<std::vector<std::uint32_t>> orders_;  ///< by kind: activities by (member, start)
};

/// Brings an agent to the truth of one verdict, which holds at `t`: takes over its activity,
/// applies rulings, ends what has ended by `t` (the agent stands at its target with the range that
/// is left). Every process that holds agent states uses this one function: agents, world and
/// scheduler agree by construction.
void Settle(AgentState* agent, const Verdict& verdict, TimeUs t, std::span<const Task> tasks);

/// Starts `action` at `now` for one of its participants, which must be idle and settled. Draws the
/// way's wind and the communication cost as functions of (seed, UAV, decision). `hold_us`: a
/// computed agent sets out so much later.
void Begin(AgentState* agent, const Action& action, std::int32_t decision, TimeUs now,
           const Disturbances& disturbances, std::uint64_t seed, TimeUs hold_us = 0);

/// Range that a UAV spends per metre on the way of the action that `decision` commands: 1, or
/// 1 + a draw in wind.
double RangePerMetre(UavId uav, std::int32_t decision, const Disturbances& disturbances,
                     std::uint64_t seed);

/// Whether the pair of `action` fails to match in this decision (paper 5.3.4, "packet loss").
bool MatchFails(const Action& action, std::int32_t decision, const Disturbances& disturbances,
                std::uint64_t seed);

/// Whether the agent, online at this decision, fails for good at it (paper 5.3.4).
bool SuddenlyFails(AgentKind kind, std::int32_t id, std::int32_t decision,
                   const Disturbances& disturbances, std::uint64_t seed);

}  // namespace muster
