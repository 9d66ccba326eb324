#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/audit/view.h"

namespace muster::tools::audit {

// The checks of a tick, in their order.

/// What each agent reports, against its command and the audit's own arithmetic.
class ReportCheck {
 public:
  explicit ReportCheck(const View& view);
  /// Reports of ticks before, which came too late for the world.
  void TakeLate(View& view, const std::vector<Report>& reports);
  void Check(View& view);

 private:
  /// An agent as last listed, and until when nothing has changed since.
  struct Told {
    agent_t agent;
    std::int64_t at_us = 0;
    std::int64_t tick = -1;
  };
  /// What the report says of its agent; none: of one that is not listed nothing is known.
  std::optional<agent_t> Read(const View& view, const Report& report);
  void NoteUav(View& view, std::int64_t tick, const agent_t& a);
  void CheckReport(View& view, AgentModel* model, const agent_t& a, std::int32_t applied_decision);

  std::vector<Told> told_[3];
  std::set<std::pair<std::int64_t, int>> failing_;  ///< by tick: UAVs that fail at it
};

/// The orders that the world says it took or refused.
class OrderCheck {
 public:
  /// Those about roads, which are in force before the agents report.
  void CheckWays(View& view);
  void Check(View& view);

 private:
  /// Whether it withdraws what can be, or is withdrawn itself.
  void CheckWithdrawal(const View& view, const AuditOrder& order, bool is_of_world);

  std::set<std::string> answered_;  ///< ids
  /// By the id of the order withdrawn: who has withdrawn it.
  std::map<std::string, std::set<std::string>> withdrawn_;
};

/// Who gave the orders that were taken, where the mission knows its persons.
class SignatureCheck {
 public:
  void Check(View& view);

 private:
  struct Person {
    int rank = 0;     ///< of the role, from 0 (none) to 3 (control)
    std::string key;  ///< public
  };
  /// "": nothing.
  std::string WrongOf(const taken_order_t& taken, std::int64_t run_id);

  std::map<std::string, Person> persons_;  ///< by name
};

void ReadRulings(View& view);
/// A measured agent that says it has failed must be ruled so.
void CheckSaidFailed(View& view);
/// Sensing and charging as the world lists them.
void CheckActivities(View& view);
void AbortActivities(View& view);
void SettleAgents(View& view);
/// Of pairs that began without a command.
void CheckMeetings(View& view);
/// What tasks are by now, and what the tick's orders do to them and to agents.
void CheckTasks(View& view);
void ExpectEvents(View& view);
/// The decision due, where it came into force.
void CheckDecision(View& view);
/// The altitudes that go with it: whether UAVs are kept apart, as far as is planned.
void CheckSeparation(View& view);

// Once, at the end.

/// Whether the log's events up to that time are those that must be said.
void CheckEvents(const View& view, const std::vector<event_t>& events, std::int64_t until_us);

/// What UAVs may do by themselves, as the decision that is due is not in force: with less than half
/// their range, go to the nearest charging point.
void AllowOwnActions(View& view);

/// Whether each decision of several schedulers is one of their proposals, and is said to be
/// disputed where it is.
void CheckProposals(const View& view, const Heard& heard);

// Parts of the above about measured agents (check_measured.cc).

/// Takes what its report tells into the model, if it can be. The report as its motion is to be
/// checked.
agent_t SeeTold(View& view, AgentModel* model, agent_t report);
/// The ways have changed under a measured agent on its way: whether it goes round, or stops, it
/// says.
void FollowWaysAsTold(const View& view, AgentModel* model, const agent_t& report);
/// What the world took of a measured agent whose process was started again, and told the tick
/// twice. null: nothing was told.
const Report* TakenReport(View& view, int kind, int id);
/// Of a pair of which an agent is measured: whether it is listed as its agents say.
void CheckMoved(View& view, Tracked* tracked, const Activity& listed);
/// When such a pair is given up, because one is too late; kForever: it is not.
std::int64_t GivenUpAt(View& view, const Activity& activity);

// Parts about the commander's directives (check_directives.cc).

/// Why the order cannot give or end a directive; "": it can.
std::string WrongDirective(const View& view, const AuditOrder& order);
void TakeDirective(const AuditOrder& order, Scenario* scenario);
/// Whether the decision keeps the directives that can be kept.
void CheckDirectives(View& view);

// Parts about orders (check_orders.cc).

/// When an order of this tick ends that activity; kForever: none does.
std::int64_t OrderedEnd(const View& view, const Activity& activity);
bool IsRecalled(const View& view, int kind, int id);
/// What the tick's orders do to tasks and agents, once these are settled.
void FollowOrders(View& view);

}  // namespace muster::tools::audit
