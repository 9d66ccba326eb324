#pragma once

#include <cstdint>
#include <vector>

#include "model/scenario.h"
#include "scheduler/policies/rollout/forward_model.h"
#include "scheduler/policy.h"

namespace muster::learning {

/// A mission to learn from: the rule book alone (ForwardModel), to which agents come online at
/// their times. Without messages and disturbances, and so a hundred times as fast as a mission
/// between processes; the same situations and outcomes as that (practice_mission_test).
class PracticeMission {
 public:
  /// Throws InputError where tasks come later, or something disturbs the mission.
  explicit PracticeMission(const Scenario& scenario);

  const scheduler::Situation& situation() const { return model_.situation(); }
  bool over() const { return model_.over(); }
  /// Carries out the actions, which must pass CheckActions, and goes on to the next decision.
  void Step(const std::vector<Action>& actions);
  /// Tasks whose sensing has ended within the limit.
  std::size_t done() const { return model_.done().size(); }
  const std::vector<Activity>& sensed() const { return model_.done(); }

 private:
  void Join();

  std::vector<AgentState> to_come_;
  scheduler::ForwardModel model_;
};

/// Share of the tasks that a policy gets done.
double CompletionOf(const Scenario& scenario, scheduler::Policy* policy);

}  // namespace muster::learning
