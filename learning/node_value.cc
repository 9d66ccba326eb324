#include "learning/node_value.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/index.h"
#include "base/random.h"
#include "learning/practice_mission.h"

namespace muster::learning {

using scheduler::kLearnedWeightings;
using scheduler::kSituationFeatures;
using scheduler::WeightCoefficients;

namespace {

constexpr std::uint64_t kFirstSeed = 800'000'000;
/// Below this a coefficient stops being looked for.
constexpr double kLeastSpread = 0.03;

/// Normal, by Box and Muller.
double Normal(Random* random) {
  const double radius = std::sqrt(-2 * std::log(1 - random->Uniform()));
  return radius * std::cos(2 * 3.14159265358979323846 * random->Uniform());
}

}  // namespace

double ScoreOf(const Scenario& scenario, scheduler::Policy* policy, double early) {
  PracticeMission mission(scenario);
  double score = 0;
  while (!mission.over()) mission.Step(policy->Decide(mission.situation()).actions);
  for (const Activity& sensing : mission.sensed()) {
    score += 1 + early * (1 - static_cast<double>(sensing.end_us) /
                                  static_cast<double>(scenario.rules.limit_us));
  }
  return score / static_cast<double>(scenario.tasks.size());
}

WeightCoefficients LearnNodeValue(const NodeValueSettings& settings,
                                  const std::function<void(const NodeValueProgress&)>& say) {
  WeightCoefficients mean = {}, spread;
  for (auto& row : spread) row.fill(settings.spread);
  std::uint64_t next_seed = kFirstSeed + settings.seed * 1'000'000;
  for (int generation = 0; generation < settings.generations; ++generation) {
    std::vector<Scenario> missions;
    for (const GeneratorSettings& scenario : settings.scenarios) {
      for (int i = 0; i < settings.missions; ++i) {
        missions.push_back(Generate(scenario, next_seed++));
      }
    }
    std::vector<WeightCoefficients> candidates;
    std::vector<double> scores;
    for (int c = 0; c < settings.candidates; ++c) {
      Random random(settings.seed, Stream::kTraining, At(generation), static_cast<unsigned>(c));
      WeightCoefficients candidate = mean;
      for (std::size_t i = 0; i < kLearnedWeightings; ++i) {
        for (std::size_t j = 0; j < kSituationFeatures; ++j) {
          candidate[i][j] += spread[i][j] * Normal(&random);
        }
      }
      double score = 0;
      scheduler::LearnedHorizonPolicy policy(candidate);
      for (const Scenario& mission : missions) score += ScoreOf(mission, &policy, settings.early);
      candidates.push_back(candidate);
      scores.push_back(score / static_cast<double>(missions.size()));
    }
    std::vector<std::size_t> order(candidates.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
    double all_spreads = 0;
    for (std::size_t i = 0; i < kLearnedWeightings; ++i) {
      for (std::size_t j = 0; j < kSituationFeatures; ++j) {
        double sum = 0, squares = 0;
        for (int b = 0; b < settings.best; ++b) {
          const double value = candidates[order[At(b)]][i][j];
          sum += value;
          squares += value * value;
        }
        const double middle = sum / settings.best;
        const double wide = std::sqrt(std::max(0.0, squares / settings.best - middle * middle));
        // Half the way: five candidates are few.
        mean[i][j] += 0.5 * (middle - mean[i][j]);
        spread[i][j] = std::max(kLeastSpread, 0.7 * spread[i][j] + 0.3 * wide);
        all_spreads += spread[i][j];
      }
    }
    say({generation + 1, std::accumulate(scores.begin(), scores.end(), 0.0) / settings.candidates,
         scores[order.front()],
         all_spreads / static_cast<double>(kLearnedWeightings * kSituationFeatures)});
  }
  return mean;
}

}  // namespace muster::learning
