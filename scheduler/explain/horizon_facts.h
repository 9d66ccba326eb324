#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "model/action.h"
#include "scheduler/explain/deciding.h"
#include "scheduler/explain/explain.h"
#include "scheduler/explain/horizon_look.h"
#include "scheduler/solver/solver.h"

namespace muster::scheduler {

/// One logged decision of the `horizon` or `rollout` family. Not moved: the plan points into the
/// situation.
struct HorizonDecision {
  HorizonDecision(Situation of, std::vector<Action> actions, const Policy& policy);
  HorizonDecision(const HorizonDecision&) = delete;
  HorizonDecision& operator=(const HorizonDecision&) = delete;

  const Situation situation;
  const std::vector<Action> commanded;
  const Deciding deciding;
};

/// A pair of a matching, by its agents' ids.
struct PairPlan {
  bool charging = false;
  std::int32_t site = -1;  ///< task or charging point
  UavId uav;
  std::int32_t partner = -1;                           ///< worker or vehicle
  std::optional<TimeUs> uav_free_us, partner_free_us;  ///< from when on, unless they are idle
  double worth = 0;                                    ///< tasks
  TimeUs end_us = 0;
  bool second = false;  ///< of the matching after the first one's ends

  AgentKind partner_kind() const { return charging ? AgentKind::kVehicle : AgentKind::kWorker; }
  bool has(AgentKind kind, std::int32_t id) const {
    return kind == AgentKind::kUav ? uav.value == id : kind == partner_kind() && partner == id;
  }
};

/// All pairs of a plan: those of the first matching, by UAV, then those of the second.
std::vector<PairPlan> PairsOf(const Situation& situation, const HorizonPlan& plan);

/// What forcing a pair into the first matching changes.
struct HorizonForcing {
  double cost = 0;     ///< worth of the best matching less that of the best with it, tasks
  bool exact = false;  ///< both are proven; else the cost is between cost_low and cost_high
  double cost_low = 0, cost_high = 0;
  PairPlan pair;                             ///< that meets the demand in the best matching with it
  std::vector<TaskId> displaced;             ///< matched in the best one and not in the one with it
  std::optional<std::size_t> forecast_done;  ///< `rollout`: tasks done in the end, as forecast
};

/// A possible pair, and the pairs of the first matching that hold its members or its place.
struct HorizonOption {
  PairLook pair;
  bool charging = false;
  std::int32_t site = -1;
  std::vector<PairPlan> rivals;
};

/// What the first matching is worth, and what the decision leads to.
struct HorizonQuality {
  double worth = 0, bound = 0;               ///< tasks; bound: proven, none is worth more
  std::optional<std::size_t> forecast_done;  ///< `rollout`: tasks done in the end, as forecast
};

enum class HorizonVerdict {
  kDone,
  kUnderWay,
  kChosen,
  kPlanned,
  kOutbid,
  kWorthless,  ///< no pair that could serve it is worth more than nothing
  kImpossible,
  kUnreported,
  kExpired
};
/// "done", "under way", "chosen", "planned", "outbid", "worthless", "impossible", "unreported",
/// "expired"
std::string_view ToString(HorizonVerdict verdict);

/// One task at one decision, in horizon's terms.
struct HorizonTaskAnswer {
  HorizonVerdict verdict = HorizonVerdict::kImpossible;
  std::optional<Activity> activity;  ///< as TaskAnswer
  std::vector<Action> commanded;     ///< planned: to its members; else what names the task
  std::optional<PairPlan> plan;      ///< planned
  PlaceLook look;                    ///< unless done or under way
  /// Outbid, worthless, and planned by the second matching: the best pairs.
  std::vector<HorizonOption> options;
  std::optional<HorizonForcing> forcing;  ///< with options
  HorizonQuality quality;                 ///< with options
};

/// One agent at one decision, in horizon's terms.
struct HorizonAgentAnswer {
  AgentCondition condition = AgentCondition::kIdle;
  std::optional<AgentState> state;  ///< busy, idle
  std::optional<Action> did;        ///< idle: as commanded; a stay where nothing was
  std::optional<TimeUs> free_us;    ///< busy and taking part: when it will be free
  std::vector<PairPlan> plans;      ///< its pairs in the first and the second matching
  /// Taking part: its best pair at each place but that of its pair, as AgentAnswer.
  std::vector<HorizonOption> options;
  std::vector<std::optional<HorizonForcing>> forcings;  ///< [options]
  int places_feasible = 0;
  std::vector<AgentAnswer::Blocked> blocked;
  HorizonQuality quality;  ///< with options
};

/// Answers questions about one decision of the `horizon` or `rollout` family in its own terms.
/// Source: ours; pairs, worth and matchings are the policy's.
class HorizonExplainer {
 public:
  /// `decision` must outlive this.
  explicit HorizonExplainer(const HorizonDecision& decision);

  /// Costs up to two matchings, and for `rollout` two forecasts.
  HorizonTaskAnswer AboutTask(TaskId task) const;
  /// Costs up to kOptions + 1 matchings, and as many forecasts.
  HorizonAgentAnswer AboutAgent(AgentKind kind, std::int32_t id, const AgentSpec& spec) const;

 private:
  const Situation& situation() const { return decision_.situation; }
  const SolverResult& Best() const;
  HorizonQuality Quality() const;
  HorizonOption MakeOption(const PlaceLook& look, const PairLook& pair) const;
  std::optional<HorizonForcing> Force(bool charging, std::int32_t site,
                                      std::optional<AgentKind> kind, std::int32_t agent) const;
  std::size_t Forecast(const std::vector<Action>& actions) const;

  const HorizonDecision& decision_;
  HorizonLook look_;
  std::vector<PairPlan> plans_;
  mutable std::optional<SolverResult> best_;
  mutable std::optional<std::size_t> forecast_done_;
};

}  // namespace muster::scheduler
