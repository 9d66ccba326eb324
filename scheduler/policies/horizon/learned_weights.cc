#include "scheduler/policies/horizon/learned_weights.h"

#include <algorithm>
#include <cmath>

namespace muster::scheduler {
namespace {

/// A weighting is at most e^this times, or one such part of, its default.
constexpr double kMostLog = 2;

}  // namespace

const WeightCoefficients kLearnedWeights = {{
    {-0.0293, -0.1551, -0.1161, -0.1920, 0.0030},   // patience
    {-0.1907, -0.3813, -0.1631, -0.2940, -0.0519},  // finish_weight
    {-0.0343, 0.0728, 0.0032, -0.1155, 0.4131},     // uav_way
    {-0.1720, -0.2772, -0.0985, -0.3700, -0.0391},  // partner_way
    {-0.1569, 0.0739, -0.0735, 0.0089, -0.3102},    // chain_worth
    {0.1144, 0.0536, -0.3443, -0.2252, -0.0131},    // charge_worth
    {0.0586, 0.2703, -0.1162, -0.1210, -0.1542},    // expected_way
}};

std::array<double, kSituationFeatures> SituationFeatures(const Situation& situation) {
  const auto limit = static_cast<double>(situation.site->rules.limit_us);
  double range = 0, online = 0, uavs = 0;
  for (const AgentState& uav : situation.uavs) {
    ++uavs;
    range += situation.range_m(uav) / uav.range_full_m;
    const TimeUs until = std::min(uav.online_until_us, situation.site->rules.limit_us);
    online += static_cast<double>(std::max<TimeUs>(0, until - situation.now_us)) / limit;
  }
  const auto open = static_cast<double>(
      std::count_if(situation.task_status.begin(), situation.task_status.end(), IsToDo));
  const double of = std::max(1.0, uavs);
  return {1, 1 - static_cast<double>(situation.now_us) / limit - 0.5,
          std::log((open + 1) / (uavs + 1)) / 2 - 0.7, range / of - 0.5, 3 * (online / of - 0.17)};
}

HorizonSettings WeightedFor(const Situation& situation, const WeightCoefficients& coefficients) {
  HorizonSettings settings;
  settings.steps = true;
  const auto features = SituationFeatures(situation);
  double* const weightings[] = {
      &settings.patience,    &settings.finish_weight, &settings.uav_way,     &settings.partner_way,
      &settings.chain_worth, &settings.charge_worth,  &settings.expected_way};
  static_assert(std::size(weightings) == kLearnedWeightings);
  for (std::size_t i = 0; i < kLearnedWeightings; ++i) {
    double log = 0;
    for (std::size_t j = 0; j < kSituationFeatures; ++j) log += coefficients[i][j] * features[j];
    *weightings[i] *= std::exp(std::clamp(log, -kMostLog, kMostLog));
  }
  return settings;
}

Decision LearnedHorizonPolicy::Decide(const Situation& situation) {
  return HorizonPolicy(WeightedFor(situation, coefficients_)).Decide(situation);
}

Deciding LearnedHorizonPolicy::Explain(const Situation& situation,
                                       const std::vector<Action>& commanded) const {
  return HorizonPolicy(WeightedFor(situation, coefficients_)).Explain(situation, commanded);
}

LearnedRolloutPolicy::LearnedRolloutPolicy() { settings_.rounds = 3; }

RolloutPolicy LearnedRolloutPolicy::PolicyFor(const Situation& situation) const {
  RolloutSettings settings = settings_;
  settings.variants = {WeightedFor(situation, kLearnedWeights)};
  return RolloutPolicy(settings);
}

Decision LearnedRolloutPolicy::Decide(const Situation& situation) {
  return PolicyFor(situation).Decide(situation);
}

Deciding LearnedRolloutPolicy::Explain(const Situation& situation,
                                       const std::vector<Action>& commanded) const {
  return PolicyFor(situation).Explain(situation, commanded);
}

}  // namespace muster::scheduler
