#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "model/action.h"
#include "scheduler/situation.h"

namespace muster::scheduler {

/// What a policy decides: at most one action per idle agent, none for the others. The actions are
/// sorted by (kind, uav, worker, vehicle, task, charge); an idle agent without one stays.
struct Decision {
  std::vector<Action> actions;
  double weight = 0;  ///< sum of the actions' weights
  /// Proven upper bound on the weight of any decision; NaN when the policy gives none.
  double bound = std::numeric_limits<double>::quiet_NaN();
  std::int64_t candidates = 0;  ///< feasible actions that the policy chose from
  /// Why an outside program's answer was refused and everybody stays instead; mostly empty.
  std::string refused = {};
  /// The commander's directives that could not be kept, each with the reason.
  std::vector<std::string> unkept = {};
  /// The altitudes of all UAVs from this decision on, by id. Empty: UAVs are not kept apart.
  std::vector<Clearance> clearances = {};
  /// Actions that were left out because no altitude is free for them.
  std::vector<Action> withheld = {};
};

/// The action of one idle agent, or of a UAV and its partner (a worker or a vehicle): it goes to
/// the task or the charging point that is given, or it stays. null: no such agent. Its weight is 0.
Action MakeAction(const Site& site, const AgentState* uav, const AgentState* partner, TaskId task,
                  ChargeId charge);
/// The agent stays.
Action MakeStay(const Site& site, const AgentState& agent);

/// In the order of a decision.
void SortActions(std::vector<Action>* actions);

/// A decision from its actions in any order: sorts them, sums their weights.
Decision MakeDecision(std::vector<Action> actions, std::int64_t candidates);

/// A way to decide. A decision is a function of the situation alone: a policy may keep buffers and
/// caches between calls, never anything that changes an answer.
class Policy {
 public:
  virtual ~Policy() = default;
  virtual Decision Decide(const Situation& situation) = 0;
  /// Throws InputError when it cannot decide for missions of that scenario, as a model that was
  /// trained for another shape of it.
  virtual void CheckScenario(const Scenario&) const {}
  /// For live use: Decide ends about that long after its start, with the best it has. An answer may
  /// then depend on the machine's speed. False when the policy has no such limit.
  virtual bool SetDeadline(std::chrono::steady_clock::duration) { return false; }
  /// Takes a setting that stands behind the policy's name (policies/registry.h). False when it has
  /// none of that key.
  virtual bool Set(std::string_view /*key*/, double /*value*/) { return false; }
};

}  // namespace muster::scheduler
