#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/words.h"
#include "tools/audit/air_ways.h"
#include "tools/audit/road_ways.h"

namespace muster::tools::audit {

// The audit shares the wire's words with the world and the scheduler, and no rule: it reads the
// scenario with its own parser and computes with its own types. SI units, microseconds.

inline constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();

/// Classes of agents, as indices.
enum Class : int {
  kUav = NumberOf(AgentKind::kUav),
  kWorker = NumberOf(AgentKind::kWorker),
  kVehicle = NumberOf(AgentKind::kVehicle)
};

inline constexpr Class kClasses[] = {kUav, kWorker, kVehicle};

struct Interval {
  double low = 0;
  double high = 0;
};

struct Scenario {
  struct Agent {
    Place at;
    double speed_m_s = 0;
    double range_full_m = 0;
    double range_m = 0;
    double charge_rate_m_s = 0;
    std::int64_t online_from_us = 0;
    std::int64_t online_until_us = 0;
    bool measured = false;  ///< what it reports is told, not computed
  };
  struct Task {
    Place at;
    double cost_m = 0;
    double to_charge_m = 0;  ///< way to the nearest charging point, infinity without one
    std::int64_t reported_us = 0;
    std::int64_t expires_us = kForever;
    int priority = 1;  ///< 3: an emergency
    bool is_emergency() const { return priority == 3; }
  };
  struct Charge {
    Place at;
    std::int64_t capacity = 1;  ///< kForever: unlimited
  };
  std::uint64_t seed = 0;
  std::int64_t interval_us = 0, limit_us = 0, tick_us = 0;
  std::int64_t patience_us = 0;
  bool strict = true;
  bool start_on_meeting = false;
  bool emergencies_at_once = false;
  std::set<std::int64_t> extra_ticks;  ///< at which an order asks for a decision
  Interval wind, communication_m, agent_failure, match_failure;
  double width_m = 0, height_m = 0;
  std::vector<Agent> agents[3];  ///< by class
  std::vector<Task> tasks;
  std::vector<Charge> charges;
  std::shared_ptr<const Ways> ways = DefaultWays();  ///< after all orders so far
  std::shared_ptr<const RoadWays> roads;             ///< while none is closed; null: there are none
  struct Closed {
    std::string order;
    std::int64_t until_us = kForever;
    std::set<int> roads;
    Rings zone = {};  ///< empty: it is about roads
  };
  std::vector<Closed> closed;  ///< by orders, in force
  /// UAVs are kept apart by that much, in layers that begin at the lowest altitude.
  struct Separation {
    double across_m = 50, above_m = 10, lowest_m = 30, ceiling_m = 120;
  };
  std::optional<Separation> separation;
  /// A zone that UAVs fly below, until that time.
  struct HighZone {
    Rings rings;
    double highest_m;
    std::int64_t until_us;
  };
  std::vector<HighZone> high_zones;
  std::optional<double> margin_m;  ///< from zones; none: zones cannot be added
  /// When ways have changed, and what held from then on; first what held before.
  std::vector<std::pair<std::int64_t, std::shared_ptr<const Ways>>> changes;
  struct Planned {
    std::int64_t from_us = 0;
  };
  std::vector<Planned> closures, zones;  ///< that the scenario itself names
  const Ways& WaysAt(std::int64_t t) const;
  std::set<int> ClosedRoads() const;
  /// The ways are those of what is closed now, and with them UAVs' ways to charging points.
  void TakeWays();
  /// How many of each list are vacant, for orders to fill.
  int room_tasks = 0, room_agents[3] = {};
  bool takes_orders() const {
    return roads != nullptr || margin_m || emergencies_at_once ||
           room_tasks + room_agents[kUav] + room_agents[kWorker] + room_agents[kVehicle] > 0;
  }

  /// What the commander has decided, in force (the orders' names are the kinds).
  struct Directive {
    std::string what, order;
    int agents[3] = {-1, -1, -1};  ///< by class; -1: not named
    int task = -1, charge = -1;
    Place place;
    int of_class = -1;  ///< that does nothing in `area`
    Rings area;
  };
  std::vector<Directive> directives;

  std::int64_t last_tick() const { return (limit_us + tick_us - 1) / tick_us; }
  std::int64_t TimeOf(std::int64_t tick) const;
  /// Decision due at that tick; -1: none.
  std::int32_t DecisionAt(std::int64_t tick) const;
  std::int64_t TimeOfDecision(std::int32_t decision) const;
};

/// Throws std::exception when the text is no scenario of version 1 or 2.
/// `roads`: of the road file, if it names one (names_roads).
Scenario ParseScenario(const std::string& json, const std::string& roads = "");
bool NamesRoads(const std::string& json);

/// An order that was taken, as far as the audit looks at it.
struct AuditOrder {
  std::string what;  ///< "task_add", ...
  Scenario::Task new_task;
  Scenario::Agent new_agent;
  std::optional<std::int64_t> expires_us;  ///< of a change
  std::optional<int> priority;             ///< of a change
  int task = -1, kind = kUav, agent = -1;
  std::string id, closure;  ///< its own, and that of what it ends or withdraws
  std::string by;           ///< the person who has signed it; "": nobody
  std::set<int> roads;      ///< to be closed or opened
  Rings zone;               ///< to be added
  std::int64_t since_us = kForever, until_us = kForever;  ///< of a closure
  Scenario::Directive directive;

  bool is_add() const { return what == "task_add"; }
  bool is_join() const { return what == "agent_join"; }
  bool is_roads() const { return what.starts_with("road_"); }
  bool is_zone() const { return what.starts_with("zone_"); }
  bool changes_ways() const { return is_roads() || is_zone(); }
  bool is_person() const { return what == "person"; }
  bool is_withdrawal() const { return what == "withdraw"; }
  bool asks_for_decision() const { return what == "decide_now"; }
  /// Whether it gives a directive, or ends one.
  bool is_directive() const {
    return what == "pin" || what == "forbid" || what == "charge_now" || what == "go_to" ||
           ends_directive();
  }
  bool ends_directive() const { return what == "unpin" || what == "release"; }
  bool is_agents() const { return what.starts_with("agent_"); }
};

/// Of what was taken at `now_us`; which task or agent it is about, the message says. Throws
/// std::exception when the text is no order.
AuditOrder ParseAuditOrder(const std::string& json, std::int64_t now_us, const Scenario& scenario);

/// SHA-256 as 64 lower-case hexadecimal digits.
std::string Sha256Of(const std::string& bytes);

}  // namespace muster::tools::audit
