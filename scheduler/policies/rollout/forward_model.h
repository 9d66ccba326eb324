#pragma once

#include <cstddef>
#include <vector>

#include "model/action.h"
#include "scheduler/situation.h"

namespace muster::scheduler {

/// The action, which must pass CheckActions, has begun: its agents are under way, its task is
/// reserved, its place at a charging point is taken.
void CarryOut(const Action& action, Situation* situation);

/// The known situation carried forward without messages, on the mission's rule book
/// (model/agent.h): the agents of the situation with their own online times, without agents that
/// come online later and without disturbances. Outcomes are those of the mission as long as that is
/// all there is (forward_model_mission_test). Meetings without a command (Rules::start_on_meeting)
/// are left out.
class ForwardModel {
 public:
  /// The last `expected` tasks of the situation are known once their time of report has come. Of
  /// the others those that are not reported yet stay unknown: when they will be is not for a
  /// decision to know.
  explicit ForwardModel(const Situation& situation, std::size_t expected = 0);

  /// The situation of the decision that is due.
  const Situation& situation() const { return situation_; }
  /// Whether the limit is reached: nothing is due any more.
  bool over() const { return situation_.now_us >= situation_.site->rules.limit_us; }
  /// Whether an agent can still be commanded, now or later, or is under way.
  bool anybody() const;

  /// An agent that comes online now, standing where it starts.
  void Add(const AgentState& agent);

  /// Carries out the actions, which must pass CheckActions, and goes on to the next decision, or to
  /// the limit.
  void Step(const std::vector<Action>& actions);

  /// The sensing that has ended within the limit, in the order of the decisions.
  const std::vector<Activity>& done() const { return done_; }

 private:
  void AdvanceTo(TimeUs t);

  Situation situation_;
  std::size_t expected_;
  std::vector<Activity> done_;
};

}  // namespace muster::scheduler
