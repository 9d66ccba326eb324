#pragma once

#include <string>
#include <vector>

#include "scheduler/policy.h"

namespace muster::scheduler {

/// What became of one directive at a decision.
struct DirectiveOutcome {
  enum class State : std::int8_t {
    kKept,    ///< its agents are sent, or stand where they are to wait
    kWaits,   ///< an agent of it is still under way, or no partner is free yet
    kUnkept,  ///< it cannot be kept now: the policy decides as if it were not there
    kOver,    ///< its agents are at it already, or there is nothing left to do
  };
  Directive directive;
  State state = State::kKept;
  std::string why;  ///< of kWaits and kUnkept
};

/// A situation, parted into what the commander's directives decide and what is left to the policy.
struct Directing {
  /// Agents of a directive are under way in it, or not in it at all; tasks that are kept for them
  /// are held. Its site has no directives but the forbidden pairs.
  Situation rest;
  std::vector<Action> actions;             ///< of directives, with the paper's weights
  std::vector<DirectiveOutcome> outcomes;  ///< one for each directive, in their order
};

/// Of one agent, charge_now comes before pins, pins in the order in which they were given, and
/// go_to last. An agent that a directive waits for goes on with what it does; the others of a pin
/// go ahead. A missing partner is the idle one whose pair has the highest weight, then the lowest
/// id. Source: ours.
Directing Direct(const Situation& situation);

/// Whether an action of Directing::actions is the directive's.
bool IsSentBy(const Action& action, const Directive& directive);

/// The policy's decision about the rest, and that of the directives, as one: the weights and bounds
/// add up. Free moves into an area that is forbidden to the agent's class are left out.
Decision Join(const Situation& situation, const Directing& directing, Decision rest);

/// What the policy decides where there are no directives, and both together where there are.
Decision DecideWithDirectives(const Situation& situation, Policy* policy);

}  // namespace muster::scheduler
