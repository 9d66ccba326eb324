#pragma once

#include <functional>
#include <map>
#include <memory>
#include <muster/event_t.hpp>
#include <muster/schedule_t.hpp>
#include <muster/world_state_t.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "model/scenario.h"
#include "protocol/order_book.h"
#include "scheduler/policies/registry.h"
#include "scheduler/situation.h"
#include "tools/log/log_source.h"

namespace muster::tools {

/// What a log holds of one decision.
struct LoggedDecision {
  std::int32_t decision = -1;
  TimeUs at_us = 0;
  std::optional<Packet> clock;  ///< the one that calls for the decision
  /// Of its tick: states of the agents, the world's state and rulings, in the log's order, each
  /// message once.
  std::vector<Packet> told;
  /// Whether the next tick's clock requires it. A decision that a lost scheduler did not make in
  /// time is not required, and no agent follows it.
  bool in_force = true;
  /// The altitudes that go with it; none: UAVs are not kept apart, or the log lacks them.
  std::optional<Packet> clearances;
  /// As published. More than one where a scheduler that was started again made it again.
  std::vector<schedule_t> schedules;
};

/// A mission's log as far as decisions and their outcomes go.
struct DecisionLog {
  std::int64_t run_id = 0;
  Scenario scenario;  ///< with all orders
  std::shared_ptr<const OrderBook> orders;
  std::vector<Packet> scenario_packets;              ///< it, and its roads if any
  std::map<std::int32_t, LoggedDecision> decisions;  ///< those that the log holds anything of
  std::vector<event_t> events;                       ///< each once, by time
  std::optional<world_state_t> last_world;           ///< of the highest tick
};

/// Called with how many decisions are done, of how many.
using DecisionProgress = std::function<void(std::size_t done, std::size_t of)>;

/// Reads a run's log. Order, repeats and restarts of processes do not matter. Memory grows with
/// agents times decisions and with events, not with the log. Throws InputError when it has no
/// scenario.
DecisionLog ReadDecisionLog(MessageSource* source);

/// What a decision's messages lack, in words: "clock_t, states of worker:3 and 2 more workers";
/// empty when they are whole.
std::string WhatIsMissing(const LoggedDecision& decision, const DecisionLog& log);

/// The altitudes that are in force before the decision; null: there are none, or the log lacks
/// them.
const Packet* ClearancesBefore(const LoggedDecision& decision, const DecisionLog& log);

/// The situation that the decision rests on, as the scheduler fuses it; none when its messages are
/// not whole.
std::optional<scheduler::Situation> SituationOf(const LoggedDecision& decision,
                                                const DecisionLog& log);

/// What the decision commanded; nothing where it is not in force.
std::vector<Action> CommandsOf(const LoggedDecision& decision, const Scenario& scenario);

/// The policy of the log's first schedule.
struct PolicyOfLog {
  std::string name;                           ///< "": the log has no schedule
  std::unique_ptr<scheduler::Policy> policy;  ///< null: it is none of ours
};
PolicyOfLog LoggedPolicy(const DecisionLog& log);

}  // namespace muster::tools
