#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/policies/horizon/horizon.h"

namespace muster::scheduler {

/// One logged decision of a policy that decides by horizon's matchings. Not moved: the plan points
/// into the situation.
struct HorizonDecision {
  HorizonDecision(Situation of, std::vector<Action> actions, const MatchingPolicy& policy)
      : situation(std::move(of)),
        commanded(std::move(actions)),
        deciding(policy.Explain(situation, commanded)) {}
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
  bool at(bool charge, std::int32_t id) const { return charging == charge && site == id; }
};

PairPlan PlanOf(const Situation& situation, const Participants& participants, const Match& match,
                bool second);

/// All pairs of a plan: those of the first matching, by UAV, then those of the second.
std::vector<PairPlan> PairsOf(const Situation& situation, const HorizonPlan& plan);

/// What tells the settings from horizon's own: "patience 0.6"; empty when nothing does. Chance is
/// left out.
std::string Difference(const HorizonSettings& settings);

/// Tasks that are done when the situation is carried forward (ForwardModel) with these actions
/// first and the decisions of `follow` after them, to the end of the known agents' time.
std::size_t ForecastDone(const Situation& situation, const std::vector<Action>& actions,
                         const HorizonSettings& follow);

}  // namespace muster::scheduler
