#pragma once

#include <array>

#include "scheduler/policies/horizon/settings.h"
#include "scheduler/policies/rollout/rollout.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

inline constexpr std::size_t kLearnedWeightings = 7;
inline constexpr std::size_t kSituationFeatures = 5;

/// Coefficients of a node's value: each weighting of HorizonSettings (patience, finish_weight,
/// uav_way, partner_way, chain_worth, charge_worth, expected_way) is its default times the
/// exponential of these times the features of the situation. All 0: the hand-set ones.
using WeightCoefficients = std::array<std::array<double, kSituationFeatures>, kLearnedWeightings>;

/// Found on simulated missions of Random_1, 3, 8 and 10 (docs/results/learned.md#a-learned-value).
extern const WeightCoefficients kLearnedWeights;

/// 1; share of the mission's time that is left; tasks for each UAV, on a scale of logarithms; mean
/// share of range of the UAVs; mean share of the mission that they are still online. Each but the
/// first is about 0 in the middle of a mission of Random_1.
std::array<double, kSituationFeatures> SituationFeatures(const Situation& situation);

/// The weightings for that situation.
HorizonSettings WeightedFor(const Situation& situation, const WeightCoefficients& coefficients);

/// horizon-steps with a learned value of nodes in the place of the hand-set weightings. Source:
/// ours; the paper's future work (2).
class LearnedHorizonPolicy : public MatchingPolicy {
 public:
  explicit LearnedHorizonPolicy(const WeightCoefficients& coefficients = kLearnedWeights)
      : coefficients_(coefficients) {}
  Decision Decide(const Situation& situation) override;
  Deciding Explain(const Situation& situation, const std::vector<Action>& commanded) const override;

 private:
  WeightCoefficients coefficients_;
};

/// rollout-steps that follows the one learned value instead of a dozen hand-set weightings, and
/// decisions near it.
class LearnedRolloutPolicy : public MatchingPolicy {
 public:
  LearnedRolloutPolicy();
  Decision Decide(const Situation& situation) override;
  Deciding Explain(const Situation& situation, const std::vector<Action>& commanded) const override;
  bool SetDeadline(std::chrono::steady_clock::duration deadline) override {
    settings_.deadline = deadline;
    return true;
  }

 private:
  RolloutPolicy PolicyFor(const Situation& situation) const;

  RolloutSettings settings_;
};

}  // namespace muster::scheduler
