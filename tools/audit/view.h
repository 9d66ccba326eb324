#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "tools/audit/agent_model.h"
#include "tools/audit/findings.h"
#include "tools/audit/intake.h"
#include "tools/audit/values.h"

namespace muster::tools::audit {

using AgentKey = std::pair<int, int>;  ///< class and id

/// An activity that the world lists.
struct Tracked {
  Activity activity;
  bool is_new = false;
  bool aborted = false;
  bool meeting = false;  ///< began without a command
  std::int64_t aborted_us = kForever;
};

/// An agent's command between the decision and the next report, which shows whether its pair
/// matched.
struct Command {
  action_t action;
  std::int32_t decision = -1;
  std::int64_t at_us = 0;
  bool by_itself = false;  ///< nobody commanded it: it may do so, or stay
};

struct Failure {
  std::int64_t at_us = 0;
  bool is_new = false;
  bool lost = false;  ///< with its process
};

/// What a UAV has flown by its reports, and the last of them.
struct Flown {
  std::optional<Place> seen;
  double flown_m = 0;
  double range_m = 0;
  std::int64_t tick = -1;
};

/// One tick as all checks see it: what the log says of it, and the mission as the audit's own
/// arithmetic has it. A check that changes nothing takes it as const. Those that follow the mission
/// leave in it what later checks need.
struct View {
  View(const Scenario& scenario, Findings* findings);
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  // The tick.
  std::int64_t tick = 0, now_us = 0;
  std::int64_t before_us = -1;  ///< time of the tick before; -1: there is none
  std::int32_t due = -1;        ///< decision at this tick
  std::int32_t in_force = -1;   ///< last decision before it
  const TickFacts* said = nullptr;
  const schedule_t* schedule = nullptr;      ///< of the decision due, if it came into force
  const clearances_t* clearances = nullptr;  ///< that go with it, if UAVs are kept apart

  // The mission.
  Scenario scenario;  ///< with the tasks and agents that orders have added
  std::vector<AgentModel> agents[3];
  int n_tasks = 0, n_agents[3] = {};  ///< that are not vacant
  std::vector<std::int8_t> task_status;
  std::vector<Tracked> activities;
  std::int64_t n_activities = 0;
  std::map<AgentKey, Command> commands;
  std::map<AgentKey, Failure> failed;
  std::map<AgentKey, std::int64_t> released;  ///< at this tick
  std::set<AgentKey> said_failed;             ///< by themselves, at this tick
  std::vector<AuditOrder> orders;             ///< taken at this tick
  /// Roads that the tick's orders close or open: since when the closed ones have been so, in the
  /// last tick. None: they change no road.
  std::optional<std::int64_t> ways_since_us;
  std::vector<Flown> flown;  ///< [n_uavs]
  std::set<int>
      withheld;  ///< tasks for which somebody stays at this decision, for want of an altitude
  std::map<int, clearance_t> cleared;  ///< altitudes in force, by UAV
  /// How close two UAVs come as planned, in shares of the minima, and how far apart they are then.
  struct Closest {
    double share = std::numeric_limits<double>::infinity();
    double across_m = 0, above_m = 0;
    std::int64_t leftover = 0;  ///< pairs in conflict that no decision has planned
  };
  Closest closest;
  std::set<EventKey> expected;  ///< outcomes that must be said
  std::vector<std::tuple<AgentKey, std::int64_t, std::int64_t>> expected_back;  ///< after, until

  template <class... T>
  void Violate(std::string_view invariant, fmt::format_string<T...> text, T&&... values) const {
    findings->Add(now_us, invariant, text, std::forward<T>(values)...);
  }
  /// Whether nothing of the tick is wrong so far.
  bool Holds() const { return findings->count() == found_before; }
  AgentModel& Model(int kind, int id) { return agents[kind][static_cast<std::size_t>(id)]; }
  const Scenario::Task& TaskOf(int id) const {
    return scenario.tasks[static_cast<std::size_t>(id)];
  }
  /// The pair: UAV, then partner.
  std::array<AgentModel*, 2> MembersOf(const Activity& activity) {
    return {&Model(kUav, activity.uav), &Model(activity.partner_class(), activity.partner)};
  }
  /// Whether the task is done, expired or cancelled.
  bool IsOver(int task) const {
    const std::int8_t status = task_status[static_cast<std::size_t>(task)];
    return status == TaskStatus::kDone || status == TaskStatus::kExpired ||
           status == TaskStatus::kCancelled;
  }
  bool IsInside(Place at) const {
    return at.x_m >= 0 && at.y_m >= 0 && at.x_m <= scenario.width_m && at.y_m <= scenario.height_m;
  }
  Place SiteOf(const Activity& activity) const;
  /// How long its sensing or charging takes when the UAV begins with that range.
  std::int64_t DurationOf(const Activity& activity, double range_m);
  bool IsMeasured(const Activity& activity);
  /// Whether one of its pair has set out anew at this tick, or stopped, as its way was closed.
  bool GoesRound(const Activity& activity);
  /// When an agent must be free.
  std::int64_t LatestEnd(const AgentModel& model) const;
  std::int64_t NextTickUs() const;

  void Expect(std::int64_t at_us, EventKind kind, const Activity& activity);
  void Expect(std::int64_t at_us, EventKind kind, AgentKey agent);
  void ExpectOfTask(std::int64_t at_us, EventKind kind, std::size_t task);
  /// That the agent comes online and goes offline.
  void ExpectPresence(const AgentModel& model);

  Findings* findings;
  std::size_t found_before = 0;  ///< when the tick began
};

EventKey KeyOf(std::int64_t at_us, EventKind kind, AgentKey agent);

}  // namespace muster::tools::audit
