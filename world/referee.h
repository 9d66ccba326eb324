#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/agent.h"
#include "model/order.h"
#include "model/scenario.h"

namespace muster::world {

/// Something that happened, at its exact time.
struct Event {
  using Kind = EventKind;
  Kind kind = Kind::kAgentOnline;
  TimeUs at_us = 0;
  UavId uav;
  WorkerId worker;
  VehicleId vehicle;
  TaskId task;
  ChargeId charge;
  std::string detail;
  std::string by_fault;  ///< of an agent that fails or is back: the fault's id; "": not by a fault
};

/// Why an agent fails. Of two reasons at the same time the smaller counts.
struct FailureReason {
  enum class Cause : std::int8_t { kFault, kProcessLost, kOutOfRange, kSudden, kSaid };
  Cause cause = Cause::kFault;
  std::string by = {};  ///< the fault's id, the process's name, what the agent's driver says

  static FailureReason LossOf(std::string process) {
    return {Cause::kProcessLost, std::move(process)};
  }

  /// As in an event's detail.
  std::string Text() const;
  auto operator<=>(const FailureReason&) const = default;
};

/// An agent failure from outside, by a fault or with a process: holds in [from_us, until_us).
struct Outage {
  AgentKind kind = AgentKind::kUav;
  std::int32_t agent = -1;
  TimeUs from_us = 0;
  TimeUs until_us = kNever;
  FailureReason reason;
  bool goes_on = false;  ///< another outage begins where this one ends
  /// When it began itself, if it is joined to one before; from_us is then that one's.
  std::optional<TimeUs> joined_us = {};
};

/// Sensing or charging of a pair as it is known now. Its times are kNever if the UAV's range ends
/// on the way.
Activity ActivityOf(const AgentState& uav, const AgentState& partner, const Scenario& scenario);

/// The states of all agents of a scenario; the index is the id.
struct Agents : PerKind<std::vector<AgentState>> {
  AgentState& at(AgentKind kind, std::int32_t id) {
    return (*this)[kind][static_cast<std::size_t>(id)];
  }
};

/// Decides what truly happens: which activities take place and when exactly, who fails, which task
/// is done. Its verdict on a tick depends on the scenario, the reports and the previous verdict
/// alone, and the sequence of events does not depend on how long a tick is.
class Referee {
 public:
  explicit Referee(const Scenario& scenario);

  /// Judges time `t` of one tick. `agents` are the reports for t: the legs, and what earlier
  /// verdicts told the agents. `decision` is the one due at t, or -1. Afterwards the agents are
  /// settled by the new verdict.
  void Judge(TimeUs t, std::int32_t decision, Agents* agents);

  /// Takes a decision that was made at the last judged time: draws the match failures.
  void Take(std::int32_t decision, const std::vector<Action>& actions);

  /// Takes an order that the scenario contains already. It is in force from the next judged time
  /// on.
  void Take(const TakenOrder& order) { orders_.push_back(order); }

  void Add(const Outage& outage) { outages_.push_back(outage); }
  /// Ends the outages with that reason at t.
  void EndOutages(const FailureReason& reason, TimeUs t);

  /// Continues from an earlier verdict on time t, as a restarted world does: outages that were over
  /// by then are forgotten.
  void Restore(TimeUs t, std::vector<TaskStatus> task_status, const Verdict& verdict);

  /// Activities not ended before the previous judged time, rulings in force.
  const Verdict& verdict() const { return verdict_; }
  const std::vector<TaskStatus>& task_status() const { return task_status_; }
  /// By the previous verdict.
  bool has_failed(AgentKind kind, std::int32_t id) const { return failed_.contains({kind, id}); }
  int done() const;
  /// What has happened since the previous call, in order of time, kind, ids.
  std::vector<Event> TakeEvents();

 private:
  using AgentKey = std::pair<AgentKind, std::int32_t>;
  struct Failure {
    TimeUs at_us = 0;
    AgentKey agent;
    FailureReason reason;
    bool begins = false;  ///< an outage that was not in force before
    bool joins = false;   ///< it goes on where another one ends
    auto operator<=>(const Failure&) const = default;
  };
  struct Known {
    Activity activity;
    bool is_new = false;      ///< not in the previous verdict
    bool is_aborted = false;  ///< listed once more, so that what was done until then counts
  };

  void UpdateVerdict();
  /// Activities with measured agents begin when these have said that they are there, and end when
  /// they have said that they are done; those of agents that go round begin later.
  void MoveActivities(TimeUs t, Agents* agents);
  void PlanNewActivities(TimeUs t, Agents* agents);
  /// Finds the pairs that are given up by t because a measured agent is too late, or a closed road
  /// keeps one from its place.
  void FindLate(TimeUs t, Agents* agents);
  /// Whether the tick's orders close or open roads.
  bool WaysChange() const;
  /// Whether closed ways have stopped a member on its way to the activity.
  bool IsCutOff(const Activity& activity, const AgentState& member) const;
  /// Whether the range of a UAV that has just set out suffices for its way, its work and the way on
  /// to the nearest charging point.
  bool HasRangeFor(const Activity& activity, const AgentState& uav) const;
  /// Why the pair is given up at t after a change of roads; "": it is not.
  std::string BarredPair(const Activity& activity, const AgentState& uav, const AgentState& partner,
                         TimeUs t) const;
  void GiveUpUntil(TimeUs t);
  void JoinOutages(TimeUs t);
  void Return(TimeUs t, Agents* agents);
  void FindFailures(TimeUs t, std::int32_t decision, Agents* agents);
  void Fail(const Failure& failure, Agents* agents);
  /// Expires the tasks for which sensing has not begun and may not begin after `t`.
  void ExpireUntil(TimeUs t);
  /// The sensing at that task ends at `t` without effect.
  void CallOff(std::size_t task, TimeUs t);
  /// Ends one activity in this way and frees its agents, except `agent`.
  void Abort(Known* known, TimeUs t, const std::optional<AgentKey>& agent = {});
  /// The same for the activity that the agent takes part in, if any. An agent that fails is not
  /// freed.
  bool AbortActivityOf(const AgentState& agent, TimeUs t, bool fails);
  /// When tasks of the scenario are reported and expire, after `t`.
  void PlanTimes(TimeUs t);
  void PlanTimesOf(std::size_t task, TimeUs t);
  /// Orders' new tasks and agents, before time `t` is judged.
  void TakeIn(TimeUs t, Agents* agents);
  /// Carries out at `t` the orders that end or allow something.
  void Obey(TimeUs t, Agents* agents);
  void ObeyOfTask(const TakenOrder& taken, TimeUs t);
  void Recall(const TakenOrder& taken, TimeUs t, Agents* agents);
  /// A task that is no longer sensed at `t` expires if sensing may not begin at that time.
  void ExpireIfLate(std::size_t task, TimeUs t);
  void EmitReports(TimeUs t);
  /// Whether an order adds it at this tick.
  bool JoinsNow(AgentKey agent) const;
  bool IsOutBecauseOfAnother(const Failure& failure) const;
  void Meet(TimeUs t, Agents* agents);
  void EmitPresence(TimeUs t, Agents* agents);
  void EmitProgress(TimeUs t);
  void UpdateTasks(TimeUs t);
  void Emit(Event::Kind kind, TimeUs at_us, const Activity& activity, std::string detail = {});
  void Emit(Event::Kind kind, TimeUs at_us, TaskId task, std::string detail);
  void Emit(Event::Kind kind, TimeUs at_us, AgentKey agent,
            const std::optional<FailureReason>& reason = {});
  /// Of two orders with the same effect, only the first makes an event.
  void OnceATick();
  void EmitOrder(Event::Kind kind, TimeUs at_us, AgentKey agent, const Order& order);

  const Scenario& scenario_;
  TimeUs previous_us_ = -1;
  std::vector<TaskStatus> task_status_;
  std::vector<std::pair<TimeUs, std::size_t>> to_report_, to_expire_;  ///< tasks, latest first
  std::vector<Known> activities_;
  std::map<AgentKey, Ruling> failed_;
  std::vector<Ruling> released_;  ///< by the present verdict
  struct Late {
    TimeUs at_us = 0;
    std::size_t activity = 0;
    std::string why = {};
  };
  std::vector<Late> late_;  ///< pairs to be given up by the present verdict, latest first
  std::vector<Outage> outages_;
  std::vector<TakenOrder> orders_;  ///< for the next judged time
  std::vector<Event> events_;
  Verdict verdict_;
};

}  // namespace muster::world
