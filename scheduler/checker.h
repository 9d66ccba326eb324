#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/action.h"
#include "scheduler/situation.h"

namespace muster::scheduler {

/// What an action may break.
enum class Rule {
  kIds,           ///< an id that its kind does not have or lacks, or out of the site's range
  kUnknownAgent,  ///< neither online nor under way
  kNotIdle,       ///< offline, failed or busy
  kAgentTwice,    ///< an agent in two actions
  kTaskNotOpen,   ///< done, reserved or being sensed
  kExpiry,        ///< not there before the task expires
  kTaskTwice,     ///< a task in two actions
  kConstraint5,   ///< range for the way to the charging point
  kConstraint6,   ///< range for the way, the sensing and the way to the nearest charging point
  kRange,         ///< range for the way of a free move
  kCapacity,      ///< more nodes at a charging point than it has free places
  kAvailability,  ///< ends after a participant's downtime or the limit (mode strict)
  kDestination,   ///< does not go where its kind says, or leaves the area
  kForbidden,     ///< the commander has forbidden the agent that task
  kWeight,        ///< not a finite number
};

/// "constraint (6)", "charging point over capacity", ...
std::string_view ToString(Rule rule);

struct Violation {
  Rule rule = Rule::kIds;
  std::size_t action = 0;  ///< index in the checked list
  std::string message;     ///< the rule, the action, ids and values, in one line
};

/// Checks a list of actions against the situation's rules, every action and every rule. Empty when
/// they may be carried out. Shares no code with the solvers: it rests on the mission's rule book
/// (`model/`) alone.
[[nodiscard]] std::vector<Violation> CheckActions(const Situation& situation,
                                                  std::span<const Action> actions);

}  // namespace muster::scheduler
