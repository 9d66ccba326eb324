#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "model/agent.h"
#include "model/directive.h"
#include "model/order_kinds.h"
#include "model/person.h"
#include "model/scenario.h"

namespace muster {

/// A request to a running mission (docs/guide/orders.md).
struct Order {
  std::string id, issuer;
  std::string signed_by;  ///< the person who answers for it; "": nobody
  TimeUs not_before_us = 0;
  OrderKind kind = OrderKind::kTaskAdd;

  Task task;  ///< to be added
  std::int32_t task_id = -1;
  /// Of the task, from when the order is taken on; none: as it is.
  std::optional<Priority> priority;
  std::optional<TimeUs> due_us, expires_us;
  /// The same, counted from when the order is taken.
  std::optional<TimeUs> due_in_us, expires_in_us;
  std::optional<std::string> name;  ///< or of a closure
  std::optional<std::string> note;

  AgentKind agent_kind = AgentKind::kUav;
  AgentSpec agent;  ///< that joins
  std::int32_t agent_id = -1;

  std::optional<RoadArea> area;        ///< of the roads to close or open
  std::optional<Zone> zone;            ///< to be added
  std::optional<Directive> directive;  ///< to be in force from now on
  std::optional<Person> person;        ///< who may order from now on, or no longer
  /// To end, instead: the id of the order that closed the roads, added the zone or gave the
  /// directive. Of kWithdraw: of the order that is not to be taken.
  std::string closure;
  /// The roads have been closed since then, though nobody knew: one who came to them stands there.
  std::optional<TimeUs> since_us;
  /// The roads are to be opened, or the zone to be lifted, then.
  std::optional<TimeUs> until_us, until_in_us;
  /// The same when the order is taken at t; kNever: not.
  TimeUs UntilUs(TimeUs t) const {
    return until_us ? *until_us : until_in_us ? t + *until_in_us : kNever;
  }
};

/// An order that the world has taken, with the task or the agent that it adds or is about.
struct TakenOrder {
  Order order;
  std::int32_t task_id = -1;
  std::int32_t agent_id = -1;
  bool joins(AgentKind kind, std::int32_t id) const {
    return order.kind == OrderKind::kAgentJoin && order.agent_kind == kind && agent_id == id;
  }
};

/// The one place where an order meets a scenario, at time t: what it adds fills the first vacant
/// place, what it changes is changed. Throws InputError where that cannot be (no room, no such
/// task, a place outside the area, times that contradict each other); then nothing is changed.
TakenOrder TakeInto(Scenario* scenario, const Order& order, TimeUs t);

/// What of the orders of a tick about roads and zones concerns an agent, before it reports tick
/// time t: it travels by the ways as they are now. One whose way is closed before it goes round
/// from where it is, or stops there, free, if there is no way. `scenario` contains the orders.
void FollowWays(AgentState* agent, std::span<const TakenOrder> taken, TimeUs t,
                const Scenario& scenario);

/// What of an order that was taken at t concerns an agent itself, once it is settled by that tick's
/// verdict: an agent that joins is there; one that leaves goes when what is under way is done.
void Obey(AgentState* agent, const TakenOrder& taken, TimeUs t, const Scenario& scenario);

/// Whether an order's id begins as those of the orders that the world gives by itself. Nobody
/// else's may: the world would take its own for given.
bool IsIdOfWorld(std::string_view id);

/// Reads an order, one JSON object. Throws InputError naming `where`, key, value and what was
/// expected.
Order ParseOrder(std::string_view json, const std::string& where);

}  // namespace muster
