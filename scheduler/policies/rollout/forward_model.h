#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "model/action.h"
#include "scheduler/situation.h"

namespace muster::scheduler {

/// The action, which must pass CheckActions, has begun: its agents are under way, its task is
/// reserved, its place at a charging point is taken.
void CarryOut(const Action& action, Situation* situation);

/// A situation, and what a forecast knows or imagines of what is still to come.
struct Future {
  Situation situation;
  /// The last so many tasks are known once their time of report has come. Of the others those that
  /// are not reported yet stay unknown: when they will be is not for a decision to know.
  std::size_t expected = 0;
  /// Agents that come online later, by the time when they do, each standing where it starts; null:
  /// nobody comes.
  std::shared_ptr<const std::vector<AgentState>> coming = nullptr;

  /// Whether the task is to be done, or will be when it is reported.
  bool MayBeDone(std::size_t task) const;
};

/// The agents of the shift plan that come online after the situation's time (Site::shifts).
std::shared_ptr<const std::vector<AgentState>> ComingAgents(const Situation& situation);

/// The known situation carried forward without messages, on the mission's rule book
/// (model/agent.h): the agents of the situation with their own online times, and without
/// disturbances. Outcomes are those of the mission as long as that is
/// all there is (forward_model_mission_test). Meetings without a command (Rules::start_on_meeting)
/// are left out.
class ForwardModel {
 public:
  explicit ForwardModel(Future future);
  /// Nobody comes, and nothing is reported.
  explicit ForwardModel(const Situation& situation) : ForwardModel(Future{situation}) {}

  /// The situation of the decision that is due.
  const Situation& situation() const { return future_.situation; }
  /// Whether the limit is reached: nothing is due any more.
  bool over() const { return situation().now_us >= situation().site->rules.limit_us; }
  /// Whether an agent can still be commanded, now or later, or is under way or still to come.
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
  bool anybody_comes() const { return future_.coming && come_ < future_.coming->size(); }

  Future future_;
  std::size_t come_ = 0;  ///< so many of those that were to come are online
  std::vector<Activity> done_;
};

}  // namespace muster::scheduler
