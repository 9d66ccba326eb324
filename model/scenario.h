#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "base/ids.h"
#include "base/moment.h"
#include "base/units.h"
#include "model/clearance.h"
#include "model/directive.h"
#include "model/per_kind.h"
#include "model/person.h"
#include "model/road_area.h"
#include "model/road_ways.h"
#include "model/ways.h"
#include "model/zone.h"

namespace muster {

/// What the scenario says of one agent. Online in [online_from_us, online_until_us).
/// range_* only for UAVs (distance in metres, as in the paper), charge_rate_m_s only for vehicles
/// (metres of range given per second).
struct AgentSpec {
  Point at;
  double speed_m_s = 0;
  double range_full_m = 0;
  double range_m = 0;
  double charge_rate_m_s = 0;
  TimeUs online_from_us = 0;
  TimeUs online_until_us = 0;
  bool measured = false;  ///< its reports count, in the place of computation (measured.h)
};

/// How much a task matters. docs/reference/scenario-format.md has what each is worth.
enum class Priority : std::int8_t { kLow = 0, kNormal = 1, kHigh = 2, kEmergency = 3 };
inline constexpr std::size_t kPriorities = 4;

inline constexpr std::size_t kMostNote = 2000;

struct Task {
  Point at;
  double cost_m = 0;           ///< range that sensing takes (T_costPow)
  TimeUs reported_us = 0;      ///< the mission knows of the task from then on
  TimeUs due_us = kNever;      ///< sensing should have begun by then; later is late, not undone
  TimeUs expires_us = kNever;  ///< sensing must begin before; after that it cannot be done
  TimeUs revisit_us = kNever;  ///< time from when it was done until it is to be sensed again
  Priority priority = Priority::kNormal;
  std::string name = {}, external_id = {}, source = {};  ///< as people call it; "": not given
  std::string note = {};  ///< what people should know of it, at most kMostNote bytes; "": nothing

  /// Whether it has a place and a cost alone, as all tasks of version 1 of the file.
  bool IsPlain() const;
  /// Whether sensing that begins at that time counts.
  bool AllowsStart(TimeUs start_us) const { return start_us < expires_us; }
};

/// How much orders may still add to a mission: so many tasks and agents at the ends of the
/// scenario's lists are vacant. Nobody reports a vacant task, and a vacant agent is never online.
struct Room {
  std::size_t tasks = 0;
  PerKind<std::size_t> agents = {};
  bool any() const { return tasks + agents.uavs + agents.workers + agents.vehicles > 0; }
};
inline constexpr std::int64_t kMostRoom = 1'000'000;  ///< of each

struct ChargingPoint {
  Point at;
  std::optional<int> capacity = 1;  ///< UAVs at a time; none: unlimited
};

/// strict: an action is offered only if it can end before every participant's downtime and before
/// the limit. overrun: it may end later.
enum class Availability { kStrict, kOverrun };

/// Rules of one mission that are not places or agents.
struct Rules {
  TimeUs interval_us = 10 * kMinuteUs;
  TimeUs limit_us = 180 * kMinuteUs;
  TimeUs tick_us = 30 * kSecondUs;  ///< divides interval_us
  Availability availability = Availability::kStrict;
  /// Eq. 4-5 to 4-19 count decision intervals (false) or minutes (true, to compare).
  bool ceil_to_minutes = false;
  /// Eq. 4-5 and 4-7 divide by all idle UAVs, as printed (true), or by the feasible ones (false).
  bool mean_over_all = false;
  /// Same cell, both idle: sensing and charging start without a pair action (for policies that move
  /// by cells).
  bool start_on_meeting = false;
  /// What a task of each priority is worth that is begun in time; one begun late is worth
  /// late_worth of that. Ours.
  std::array<double, kPriorities> priority_worth = {0.5, 1, 2, 4};
  double late_worth = 0.5;
  /// A pair is given up if a measured agent of it has not arrived this long after both should have.
  /// Ours.
  TimeUs patience_us = 10 * kMinuteUs;
  /// A decision is made in the tick in which an emergency opens, too. Ours.
  bool emergencies_at_once = false;
  /// Ticks of decisions between whole intervals, ascending: those that orders have asked for so
  /// far.
  std::vector<std::int64_t> extra_decisions;

  /// Ticks are 0 to last_tick(), whose time is the limit.
  std::int64_t last_tick() const { return (limit_us + tick_us - 1) / tick_us; }
  TimeUs TimeOf(std::int64_t tick) const { return tick < last_tick() ? tick * tick_us : limit_us; }
  /// The tick at that time, or the last before it.
  std::int64_t TickOf(TimeUs t) const { return t / tick_us; }
  /// Time of the tick after t; after the last one as if the mission went on.
  TimeUs TickAfter(TimeUs t) const { return t < limit_us ? TimeOf(TickOf(t) + 1) : t + tick_us; }
  /// Whether a decision is made at that tick whatever is ordered: at a whole interval.
  bool AlwaysDecides(std::int64_t tick) const {
    return TimeOf(tick) < limit_us && TimeOf(tick) % interval_us == 0;
  }
  /// The decision of that tick; -1: none. Decisions are numbered in the order of their ticks.
  std::int32_t DecisionAt(std::int64_t tick) const;
  /// Whether the tick may have that decision, if orders that are not known yet may ask for some.
  bool MayDecide(std::int64_t tick, std::int32_t decision) const;
  /// Of one after the last: when it would be, if the mission went on.
  TimeUs TimeOfDecision(std::int32_t decision) const;
  /// The last decision that is made before t; -1: none.
  std::int32_t LastDecisionBefore(TimeUs t) const;
  /// Of the next decision after t that is made whatever is ordered; also beyond the limit.
  TimeUs NextDecisionUs(TimeUs t) const { return (t / interval_us + 1) * interval_us; }
  /// From now on that tick has a decision, if it is before the limit.
  void DecideAt(std::int64_t tick);

  bool operator==(const Rules&) const = default;
};

/// What that task is worth when its sensing begins at that time, in tasks of normal priority.
/// Source: ours.
double WorthOf(const Task& task, TimeUs start_us, const Rules& rules);

/// Disturbances of the paper's section 5.3.4. Off when the interval's upper end is 0.
struct Disturbances {
  struct Interval {
    double low = 0;
    double high = 0;
    bool on() const { return high > 0; }
    bool operator==(const Interval&) const = default;
  };
  Interval wind;             ///< extra range per metre on a UAV's way, drawn per action
  Interval communication_m;  ///< range that an action costs a UAV at its start, drawn per action
  Interval agent_failure;    ///< probability at each decision while online, drawn once per agent
  Interval match_failure;    ///< probability that a pair's match fails, drawn once per mission

  bool operator==(const Disturbances&) const = default;
};

struct Origin {
  double latitude_deg = 0;
  double longitude_deg = 0;
};

/// Roads that are to be closed for a time that is known before the mission begins.
struct PlannedClosure {
  RoadArea area;
  std::string name;  ///< as people call it; "": not given
  TimeUs from_us = 0;
  TimeUs until_us = kNever;
};

/// Roads that an order has closed, or a zone that it has added.
struct Closure {
  std::string order;  ///< its id
  std::string name;   ///< as people call it; "": not given
  TimeUs since_us = 0;
  std::vector<std::int32_t> roads;             ///< indices, ascending
  std::shared_ptr<const Zone> zone = nullptr;  ///< null: it is about roads
};

/// The road network that workers and vehicles of a scenario travel by.
struct ScenarioRoads {
  std::string file;  ///< name of the road file, which stands beside the scenario's
  std::string text;  ///< of that file
  /// By agent class, off the road.
  PerKind<OpenGround> open_ground = {{}, {50, 1000}, {25, 1000}};
  std::vector<PlannedClosure> closures;
  std::shared_ptr<const Roads> network;
  std::shared_ptr<const RoadWays> ways;  ///< while no road is closed
};

/// A zone that is known before the mission begins.
struct PlannedZone {
  Zone zone;
  TimeUs from_us = 0;
  TimeUs until_us = kNever;
  double lower_m = 0;  ///< above the ground, where it begins
};

class AirWaysStore;

/// The airspace that UAVs of a scenario fly in.
struct ScenarioAir {
  double margin_m = 30;  ///< they stay so far away from a zone
  /// By how much they are kept apart from each other; none: they are not.
  std::optional<Separation> separation = Separation();
  std::vector<PlannedZone> zones;
  std::shared_ptr<const AirWaysStore> ways;  ///< around each set of zones that there has been
};

/// A mission: who, where, when. Ids are indices. SI units; see scenario_json.h for the file.
struct Scenario {
  std::string name;
  std::uint64_t seed = 0;
  double width_m = 0;            ///< extent of the area to the east
  double height_m = 0;           ///< extent of the area to the north
  std::optional<Origin> origin;  ///< WGS84 of the south-west corner
  std::optional<Moment> start;   ///< mission time 0, for people: nothing in the mission asks
  Rules rules;
  Disturbances disturbances;
  std::vector<AgentSpec> uavs, workers, vehicles;
  std::vector<Task> tasks;
  std::vector<ChargingPoint> charging_points;
  std::shared_ptr<const ScenarioRoads> roads;  ///< null: nobody needs any
  std::shared_ptr<const ScenarioAir> air;  ///< null: UAVs fly straight, and zones cannot be added
  /// How its agents travel: by the roads and around the zones that there are after all orders so
  /// far.
  std::shared_ptr<const Ways> ways = DefaultWays();
  std::vector<Closure> closures;  ///< of roads and air, in force, in the order in which they came
  struct WaysSince {
    TimeUs at_us;
    std::shared_ptr<const Ways> ways;
    std::vector<Closure> closures;  ///< in force from then on
  };
  std::vector<WaysSince> changed_ways;  ///< each change so far; first what held before

  std::vector<Directive> directives;  ///< of the commander, in force, in the order they came in
  std::vector<Person> persons;  ///< who may order, as orders have said; empty: everybody who can

  Room room;              ///< the vacant ends of these lists
  bool had_room = false;  ///< also when orders have filled it

  /// Those that are not vacant.
  std::size_t n_tasks() const { return tasks.size() - room.tasks; }
  std::size_t n_agents(AgentKind kind) const { return agents(kind).size() - room.agents[kind]; }
  const std::vector<AgentSpec>& agents(AgentKind kind) const {
    return ByKind(kind, uavs, workers, vehicles);
  }
  /// The ways at that time, with the orders of its tick.
  const Ways& WaysAt(TimeUs t) const;
  /// By how much UAVs are kept apart; null: they are not.
  const Separation* separation() const {
    return air && air->separation ? &*air->separation : nullptr;
  }
  /// Whether orders may come.
  bool takes_orders() const {
    return had_room || roads != nullptr || air != nullptr || rules.emergencies_at_once;
  }
  AgentRow row() const { return AgentRow({uavs.size(), workers.size(), vehicles.size()}); }
  /// Whether it needs version 2 of the file: a task has more than a place and a cost, or a rule of
  /// such tasks is not the usual one.
  bool IsOpen() const;
  /// Number of decisions: at n * interval < limit, and those that orders have asked for so far.
  int decisions() const {
    return static_cast<int>(Intervals(rules.limit_us, rules.interval_us)) +
           static_cast<int>(rules.extra_decisions.size());
  }
};

/// Sends workers and vehicles by these roads. Their network is read from the text; errors name
/// `file`.
void UseRoads(ScenarioRoads roads, const std::string& file, Scenario* scenario);

/// Sends UAVs around zones. After UseRoads().
void UseAir(ScenarioAir air, Scenario* scenario);

/// After a change of the closures at t: the ways follow.
void ChangeWays(TimeUs t, Scenario* scenario);

/// Adds so many vacant tasks and agents.
void AddRoom(const Room& room, Scenario* scenario);

}  // namespace muster
