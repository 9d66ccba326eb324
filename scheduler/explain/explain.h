#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "model/action.h"
#include "scheduler/explain/exact.h"
#include "scheduler/explain/look.h"

namespace muster::scheduler {

/// What forcing something into a decision changes about the highest weight.
struct Forcing {
  Optimum with;        ///< the best decision with it
  double cost = 0;     ///< highest weight without less with it, at least 0
  bool exact = false;  ///< both are proven; else the cost is between cost_low and cost_high
  double cost_low = 0, cost_high = 0;
  std::optional<Action> pair;  ///< that meets the demand in `with`
  /// Tasks that the best decision without senses and `with` does not. Among equally good decisions
  /// which are compared is chance.
  std::vector<TaskId> displaced;
};

/// A pair that could have acted, and what its members were commanded instead.
struct Option {
  PairLook pair;
  bool charging = false;
  std::int32_t site = -1;
  Action uav_did, partner_did;        ///< a stay where nothing was commanded
  std::optional<Action> site_holder;  ///< the pair that was commanded to the same place
};

/// How a decision stands towards its optimum under the paper's weights.
struct DecisionQuality {
  double weight = 0;  ///< of what was commanded, stays included
  Optimum best;
  /// Whether the commanded weights are the paper's: a policy may have weights of its own, or none.
  bool own_weights = false;
};

enum class TaskVerdict { kDone, kUnderWay, kChosen, kLost, kInfeasible, kUnreported, kExpired };
/// "done", "under way", "chosen", "lost", "infeasible", "unreported", "expired"
std::string_view ToString(TaskVerdict verdict);

/// One task at one decision.
struct TaskAnswer {
  TaskVerdict verdict = TaskVerdict::kInfeasible;
  std::optional<Activity> activity;  ///< under way: its pair; start_us kNever: not known yet
  std::vector<Action> commanded;     ///< actions that name the task: the pair, or moves alone
  PlaceLook look;                    ///< chosen, lost, infeasible
  std::vector<Option> options;       ///< lost: the best of the pairs
  /// Lost: the commanded actions, stays aside, that hold an agent of a feasible pair.
  std::vector<Action> rivals;
  std::optional<Forcing> forcing;  ///< lost
};

enum class AgentCondition { kNotYetOnline, kOffline, kFailed, kBusy, kIdle };
/// "not yet online", "offline", "failed", "busy", "idle"
std::string_view ToString(AgentCondition condition);

/// One agent at one decision.
struct AgentAnswer {
  AgentCondition condition = AgentCondition::kIdle;
  std::optional<AgentState> state;  ///< busy, idle
  std::optional<Action> did;        ///< idle: as commanded; a stay where nothing was
  /// Idle: its best pair at each place that it was not commanded to, heaviest first, at most
  /// kOptions; with what forcing the agent into a pair there would have cost.
  std::vector<Option> options;
  std::vector<std::optional<Forcing>> forcings;  ///< [options]
  int places_feasible = 0;  ///< where it has a pair, the commanded one included
  /// Idle: places where it has no pair, by obstacle, and of each the one that lacks least.
  struct Blocked {
    Obstacle obstacle = Obstacle::kNone;
    bool charging = false;
    int places = 0;
    PlaceLook nearest;
  };
  std::vector<Blocked> blocked;

  static constexpr std::size_t kOptions = 3;
};

/// Who senses a task that is reserved or being sensed; start_us kNever: not known yet.
std::optional<Activity> UnderWayAt(const Situation& situation, TaskId task);

/// An agent's state, if it is online or under way, and its condition.
AgentCondition ConditionOf(const Situation& situation, AgentKind kind, std::int32_t id,
                           const AgentSpec& spec, std::optional<AgentState>* state);

/// What was commanded to an idle agent; a stay where nothing was.
Action CommandTo(const Situation& situation, const std::vector<Action>& commanded, AgentKind kind,
                 std::int32_t id);

/// Groups the places where an agent has no pair, by obstacle and kind of place.
std::vector<AgentAnswer::Blocked> BlockedOf(const std::vector<PlaceLook>& places);

/// Answers questions about one decision from the situation that it rests on and what was commanded.
/// Source: ours; feasibility and weights are EnumerateCandidates', costs those of exact decisions.
class Explainer {
 public:
  /// `situation` must outlive this. `commanded` as in Decision::actions.
  Explainer(const Situation& situation, std::vector<Action> commanded);

  /// Costs one more exact decision when the task lost.
  TaskAnswer AboutTask(TaskId task) const;
  /// Costs up to kOptions more exact decisions.
  AgentAnswer AboutAgent(AgentKind kind, std::int32_t id, const AgentSpec& spec) const;
  DecisionQuality Quality() const;

 private:
  Action DoneBy(AgentKind kind, std::int32_t id) const;
  Option MakeOption(const PlaceLook& look, const PairLook& pair) const;
  std::optional<Forcing> Force(const Demand& demand) const;

  const Situation& situation_;
  std::vector<Action> commanded_;
  Look look_;
  ExactDecisions exact_;
};

}  // namespace muster::scheduler
