#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "model/action.h"
#include "scheduler/explain/deciding.h"
#include "scheduler/explain/look.h"

namespace muster::scheduler {

/// In whose terms reasons are given, and how `muster explain --json` names them.
enum class Terms {
  kPaper,   ///< weights of Eq. 4-18 and 4-19, by exact decisions
  kHorizon  ///< worth in tasks, by horizon's first matching
};
/// "paper", "horizon"
std::string_view ToString(Terms terms);

/// A pair that a decision must hold: at that place, or with that agent, or both.
struct Demand {
  TaskId task;      ///< invalid: any place
  ChargeId charge;  ///< invalid: any place; only with an agent
  std::optional<AgentKind> agent_kind;
  std::int32_t agent = -1;
};

/// A heaviest decision under the paper's weights, or a heaviest matching of horizon.
struct Optimum {
  double weight = 0;
  double bound = 0;             ///< proven: none weighs more; at least weight
  std::vector<Action> actions;  ///< paper: stays included; horizon: none
  /// Whether nothing but rounding lies between them.
  bool proven() const { return bound - weight <= 1e-6; }
};

/// What forcing something into a decision, or a matching, changes about the highest weight.
struct Forcing {
  Optimum with;        ///< the best decision with it
  double cost = 0;     ///< highest weight without less with it, at least 0
  bool exact = false;  ///< both are proven; else the cost is between cost_low and cost_high
  double cost_low = 0, cost_high = 0;
  std::optional<Action> pair;    ///< paper: that meets the demand in the best decision with it
  std::optional<PairPlan> plan;  ///< horizon: the same
  /// Tasks that the best decision without senses and the one with it does not. Among equally good
  /// decisions which are compared is chance.
  std::vector<TaskId> displaced;
  std::optional<std::size_t> forecast_done;  ///< `rollout`: tasks done in the end, as forecast
};

/// A possible pair, and what stood against it.
struct Option {
  PairLook pair;
  bool charging = false;
  std::int32_t site = -1;
  // Paper: what its members were commanded, a stay where nothing was; and the pair that was
  // commanded to the same place.
  Action uav_did, partner_did;
  std::optional<Action> site_holder;
  /// Horizon: the pairs of the first matching that hold its members or its place.
  std::vector<PairPlan> rivals;
  std::optional<Forcing> forcing;  ///< of an agent's option: what the agent in a pair there costs
};

/// How a decision stands towards its optimum.
struct DecisionQuality {
  double weight = 0;  ///< paper: of what was commanded, stays included
  Optimum best;
  /// Whether the commanded weights are not the paper's: a policy may have weights of its own, or
  /// none.
  bool own_weights = false;
  std::optional<std::size_t> forecast_done;  ///< `rollout`: tasks done in the end, as forecast
};

enum class TaskVerdict {
  kDone,
  kUnderWay,
  kChosen,
  kPlanned,     ///< horizon: a matching has a pair for it that is not commanded yet
  kLost,        ///< paper: pairs could sense it, none was commanded
  kOutbid,      ///< horizon: pairs could serve it, the matching has none of them
  kWorthless,   ///< the same, and none is worth more than nothing
  kInfeasible,  ///< paper: no pair could sense it
  kImpossible,  ///< horizon: the same
  kUnreported,
  kExpired
};
/// "done", "under way", "chosen", "planned", "lost", "outbid", "worthless", "infeasible",
/// "impossible", "unreported", "expired"
std::string_view ToString(TaskVerdict verdict);

/// One task at one decision.
struct TaskAnswer {
  TaskVerdict verdict = TaskVerdict::kInfeasible;
  std::optional<Activity> activity;  ///< under way: its pair; start_us kNever: not known yet
  /// Actions that name the task: the pair, or moves alone. Planned: those of the plan's members.
  std::vector<Action> commanded;
  std::optional<PairPlan> plan;  ///< planned
  PlaceLook look;                ///< of an open task
  /// Lost, outbid, worthless, and planned by the second matching: the best of the pairs.
  std::vector<Option> options;
  /// Lost: the commanded actions, stays aside, that hold an agent of a feasible pair.
  std::vector<Action> rivals;
  std::optional<Forcing> forcing;  ///< with options
};

enum class AgentCondition { kNotYetOnline, kOffline, kFailed, kNotReady, kBusy, kIdle };
/// "not yet online", "offline", "failed", "not ready", "busy", "idle"
std::string_view ToString(AgentCondition condition);

/// One agent at one decision.
struct AgentAnswer {
  AgentCondition condition = AgentCondition::kIdle;
  std::optional<AgentState> state;  ///< busy, idle
  std::optional<Action> did;        ///< idle: as commanded; a stay where nothing was
  // The rest is of agents that take part.
  std::optional<TimeUs> free_us;  ///< busy: when it will be free
  std::vector<PairPlan> plans;    ///< horizon: its pairs in the first and the second matching
  /// Its best pair at each place that it was not commanded or matched to, heaviest first, at most
  /// kOptions.
  std::vector<Option> options;
  int places_feasible = 0;  ///< where it has a pair, the commanded one included
  /// Places where it has no pair, by obstacle, and of each the one that lacks least.
  struct Blocked {
    Obstacle obstacle = Obstacle::kNone;
    bool charging = false;
    int places = 0;
    PlaceLook nearest;
  };
  std::vector<Blocked> blocked;

  static constexpr std::size_t kOptions = 3;
};

/// Null: the agent is neither online nor under way.
const AgentState* FindAgent(const Situation& situation, AgentKind kind, std::int32_t id);

/// The pair that senses a task, or is on its way to it; start_us kNever: not known yet.
std::optional<Activity> UnderWayAt(const Situation& situation, TaskId task);

/// The terms of one decision: what pairs weigh, and what the best decision with or without a demand
/// is. PaperScore and HorizonScore make it.
class Score {
 public:
  virtual ~Score() = default;
  virtual Terms terms() const = 0;
  virtual const Look& look() const = 0;
  virtual const std::vector<Action>& commanded() const = 0;
  /// The matchings' pairs; in the paper's terms there are none.
  virtual std::vector<PairPlan> plans() const { return {}; }
  /// What was commanded to an idle agent; a stay where nothing was.
  virtual Action DoneBy(AgentKind kind, std::int32_t id) const;
  /// Adds what stood against the option.
  virtual void Oppose(Option* option) const = 0;
  /// None: no decision that meets the demand was found.
  virtual std::optional<Forcing> Force(const Demand& demand) const = 0;
  virtual DecisionQuality Quality() const = 0;

 protected:
  static Forcing ForcingOf(const Optimum& best, Optimum with);
};
std::unique_ptr<Score> PaperScore(const Situation& situation, std::vector<Action> commanded);
std::unique_ptr<Score> HorizonScore(const HorizonDecision& decision);

/// Answers questions about one decision from the situation that it rests on and what was commanded.
/// Source: ours.
class Explainer {
 public:
  /// In the paper's terms. `situation` must outlive this; `commanded` as in Decision::actions.
  Explainer(const Situation& situation, std::vector<Action> commanded)
      : Explainer(PaperScore(situation, std::move(commanded))) {}
  /// In horizon's terms. `decision` must outlive this.
  explicit Explainer(const HorizonDecision& decision) : Explainer(HorizonScore(decision)) {}

  /// Costs one more exact decision or matching where pairs were possible and none was chosen, and
  /// for `rollout` up to two forecasts.
  TaskAnswer AboutTask(TaskId task) const;
  /// Costs up to kOptions more exact decisions, or matchings and forecasts.
  AgentAnswer AboutAgent(AgentKind kind, std::int32_t id, const AgentSpec& spec) const;
  DecisionQuality Quality() const { return score_->Quality(); }

 private:
  explicit Explainer(std::unique_ptr<Score> score)
      : score_(std::move(score)), plans_(score_->plans()) {}
  const Situation& situation() const { return score_->look().situation(); }
  bool by_paper() const { return score_->terms() == Terms::kPaper; }
  /// Whether more is to be told: why the task has no pair now.
  bool TellPlan(TaskId task, TaskAnswer* answer) const;
  std::vector<Action> HoldersOf(TaskId task) const;
  Option MakeOption(const PlaceLook& look, const PairLook& pair) const;
  /// Adds the places that an agent was not sent to and has a pair at, heaviest first.
  void AddOptions(AgentKind kind, std::int32_t id, const std::vector<PlaceLook>& places,
                  AgentAnswer* answer) const;

  std::unique_ptr<Score> score_;
  std::vector<PairPlan> plans_;
};

}  // namespace muster::scheduler
