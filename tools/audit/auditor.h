#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/interval_set.h"
#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/codec.h"
#include "tools/audit/agent_model.h"
#include "tools/audit/audit_scenario.h"

namespace muster::tools::audit {

/// One thing that a log shows and that must not be.
struct Violation {
  std::int64_t at_us = 0;  ///< mission time
  std::string invariant;   ///< a row of docs/reference/audit.md
  std::string text;        ///< ids and values
};

/// An outcome as in event_t: at_us, kind, uav, worker, vehicle, task, charge.
using EventKey = std::tuple<std::int64_t, int, int, int, int, int, int>;
EventKey KeyOf(const event_t& event);
std::string Name(const EventKey& key);

/// What the log shows, for comparison with what was reported.
struct Facts {
  std::string sha256;
  std::uint64_t seed = 0;
  std::map<std::int32_t, schedule_t> schedules;
  std::vector<event_t> events;  ///< sorted, without repeats
  std::vector<std::int8_t> task_status;
  std::vector<double> flown_m, final_range_m;  ///< [n_uavs]
  std::int64_t messages = 0;
  std::int64_t interval_us = 0;
};

/// Checks a mission's log, packet by packet, against every invariant of docs/reference/audit.md. It
/// follows the agents by its own arithmetic from what was commanded and ruled, one tick after the
/// other, and compares each report, activity, status and event with that. Memory grows with agents,
/// decisions, events and gaps; a tick is dropped when it has been checked.
///
/// Checking of ticks stops at the first one that breaks an invariant: what follows would follow
/// from that.
class Auditor {
 public:
  void Add(const Packet& packet);
  /// To call once, after the last packet. Violations by mission time; empty: all holds.
  const std::vector<Violation>& Finish();

  /// After Finish(): none when the log broke an invariant before its end.
  const std::optional<Facts>& facts() const { return facts_; }
  std::int64_t messages() const { return messages_; }
  std::int64_t duplicates() const { return duplicates_; }
  /// Packets on our channels that are no valid message: not a violation, unless a seq is missing.
  std::int64_t undecodable() const { return undecodable_; }
  std::int64_t ticks() const { return next_tick_; }
  std::int64_t decisions() const { return static_cast<std::int64_t>(schedules_.size()); }
  std::int64_t activities() const { return n_activities_; }

 private:
  struct Report {
    agent_t agent;                ///< not listed: nothing but its id
    std::int64_t base_tick = -1;  ///< not listed: it goes on as told for that; -1: listed
    std::int32_t applied_decision = -1;
    std::string sender;
    std::int64_t boot_id = 0;
  };
  /// An agent as last listed, and until when nothing has changed since.
  struct Told {
    agent_t agent;
    std::int64_t at_us = 0;
    std::int64_t tick = -1;
  };
  struct TickData {
    std::optional<clock_t> clock;
    std::optional<world_state_t> world;
    std::optional<rulings_t> rulings;
    std::optional<orders_t> orders;  ///< of the latest start of the world
    std::vector<std::optional<Report>> reports[3];
    bool repeated = false;
    std::string repeated_text;
  };
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
  };
  struct Failure {
    std::int64_t at_us = 0;
    bool is_new = false;
    bool lost = false;  ///< with its process
  };
  using AgentKey = std::pair<int, int>;
  struct Sender {
    IntervalSet seqs;
    std::int64_t last_sim_us = 0;
  };

  void Violate(std::int64_t at_us, std::string invariant, std::string text);
  template <class Message>
  std::optional<Message> Admit(const Packet& packet);
  void Take(const Packet& packet);
  void TakeScenario(const scenario_t& message);
  void TakeStates(const agent_states_t& message, int kind);
  void TakeChanges(const agent_changes_t& message, int kind);
  /// Whether a report of that class and tick can be, on the channel of class `kind`.
  bool CanReport(int said, int kind, std::int64_t tick, TickData** data);
  void TakeReport(std::int64_t tick, int kind, const Report& report, TickData* data);
  void TakeSchedule(const schedule_t& message);
  TickData* DataOf(std::int64_t tick);
  bool Complete(std::int64_t tick, const TickData& data) const;
  /// Whether the next tick's clock requires the decision due at `tick`; none: that clock is not
  /// here yet. A decision that the scheduler, lost, did not make in time is not required.
  std::optional<bool> InForce(std::int64_t tick) const;
  void CheckSkipped();
  std::string WhatIsMissing(std::int64_t tick) const;
  void Advance();

  void TakeOrders(orders_t orders);
  void ExpectPresence(const AgentModel& model);

  // One tick, in this order.
  void CheckTick(std::int64_t tick, const TickData& data);
  void CheckClock(const clock_t& clock);
  void CheckReports(const TickData& data);
  void NoteUav(std::int64_t tick, const agent_t& a);
  /// What the report says of its agent; none: of who is not listed nothing is known.
  std::optional<agent_t> Read(int kind, const Report& report, std::int64_t tick);
  void CheckReport(AgentModel* model, const agent_t& a, std::int32_t applied_decision);
  void CheckSpec(const AgentModel& model, const agent_t& report);
  void CheckMotion(const AgentModel& model, const agent_t& report);
  void ResolveCommand(AgentModel* model, const agent_t& report);
  void SeeWay(AgentModel* model, const agent_t& report);
  /// Of a measured agent: takes what its report tells into the model, if it can be. The report as
  /// CheckMotion is to look at it.
  agent_t SeeTold(AgentModel* model, agent_t report);
  void SeeStanding(AgentModel* model, const agent_t& report);
  void SeeLeg(AgentModel* model, const agent_t& report);
  void Arrive(AgentModel* model, const agent_t& report);
  void SeeWind(AgentModel* model, const agent_t& report);
  void SeeEnd(AgentModel* model, const agent_t& report);
  void CheckWay(const AgentModel& model, Place from, Place to, double seconds);
  /// Whether it can be there then, with that range.
  void CheckFromAnchor(const AgentModel& model, Place at, std::int64_t at_us, double range_m);
  void CheckRangeTold(const AgentModel& model, double range_m, double most_m);
  void CheckSaidFailed();
  bool IsMeasured(const Activity& activity);
  /// Of a pair of which an agent is measured: whether it is listed as its agents say.
  void CheckMoved(Tracked* tracked, const Activity& listed);
  /// When such a pair is given up, because one is too late; kForever: it is not.
  std::int64_t GivenUpAt(const Activity& activity);
  std::int64_t NextTickUs() const;
  void CheckOrders(const orders_t& orders);
  bool CheckOrder(const taken_order_t& taken, const AuditOrder& order);
  void TakeOrder(const AuditOrder& order);
  void ReadRulings(const rulings_t& rulings);
  void CheckActivities(const world_state_t& world);
  /// Whether it begins without a command.
  bool CheckNewActivity(const Activity& activity);
  void CheckMeeting(const Activity& activity);
  void AbortActivities();
  void SettleAgents();
  void CheckRangeLeft(const AgentModel& model);
  void CheckTasks(const world_state_t& world);
  void ExpireTasks();
  /// When an order of this tick ends that activity; kForever: none does.
  std::int64_t OrderedEnd(const Activity& activity) const;
  bool IsRecalled(int kind, int id) const;
  /// What the tick's orders do to tasks and agents, once these are settled.
  void FollowOrders();
  void CheckDecision(const schedule_t& schedule);
  bool CheckShape(const action_t& action, const std::string& name);
  void CheckAction(const action_t& action, const std::string& name);
  void ExpectEvents();
  void Expect(std::int64_t at_us, EventKind kind, const Activity& activity);
  void Expect(std::int64_t at_us, EventKind kind, AgentKey agent);
  void CompareEvents();

  AgentModel& Model(int kind, int id) { return models_[kind][static_cast<std::size_t>(id)]; }
  std::int64_t LatestEnd(const AgentModel& model) const;

  /// Whether the tick being checked has broken nothing so far.
  bool TickHolds() const { return n_violations_ == n_before_tick_; }

  std::vector<Violation> violations_;
  std::size_t n_violations_ = 0, n_before_tick_ = 0;
  std::vector<Packet> held_back_;
  std::optional<Scenario> scenario_;
  std::string sha256_;
  std::optional<std::int64_t> run_id_;
  std::int64_t messages_ = 0, duplicates_ = 0, undecodable_ = 0, n_activities_ = 0;
  std::map<std::pair<std::string, std::int64_t>, Sender> senders_;
  std::map<std::tuple<std::string, std::int64_t, std::int64_t>, std::size_t> recent_;
  std::deque<std::tuple<std::string, std::int64_t, std::int64_t>> recent_order_;

  int n_tasks_ = 0, n_agents_[3] = {};  // that are not vacant
  std::set<std::string> order_ids_;     // answered so far
  std::vector<AuditOrder> taken_;       // at the tick that is checked

  std::map<std::int64_t, TickData> pending_;
  std::int64_t next_tick_ = 0;
  bool stopped_ = false;
  bool ended_ = false;
  std::string clock_sender_;
  std::map<std::int32_t, schedule_t> schedules_;
  std::vector<event_t> events_;
  std::set<std::int32_t> skipped_;  // decisions that never were in force

  // The state after tick next_tick_ - 1; while a tick is checked, of that tick.
  std::int64_t now_us_ = 0, before_us_ = -1;
  std::int32_t due_ = -1;       // decision at this tick
  std::int32_t in_force_ = -1;  // last decision before this tick
  std::vector<AgentModel> models_[3];
  std::vector<std::optional<Place>> last_seen_[3];      // as reported
  std::vector<std::pair<Place, std::int64_t>> was_[3];  // where it truly was, and when
  std::vector<Told> told_[3];
  std::map<AgentKey, Command> commands_;
  std::map<AgentKey, Failure> failed_;
  std::set<std::pair<std::int64_t, int>> failing_;  // by tick: UAVs that fail at it
  std::map<AgentKey, std::int64_t> released_;
  std::set<AgentKey> said_failed_;  // by themselves, at this tick
  std::vector<Tracked> activities_;
  std::vector<std::int8_t> task_status_;
  std::vector<double> flown_m_;
  std::vector<double> final_range_m_;           // as last reported
  std::vector<std::int64_t> final_range_tick_;  // and when
  std::set<EventKey> expected_;
  std::vector<std::tuple<AgentKey, std::int64_t, std::int64_t>> expected_back_;
  std::optional<Facts> facts_;
};

}  // namespace muster::tools::audit
