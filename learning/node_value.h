#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "model/generator.h"
#include "scheduler/policies/horizon/learned_weights.h"

namespace muster::learning {

/// How the coefficients of a node's value are found: by the cross-entropy method (Rubinstein 1999).
/// A generation draws candidates around the mean, plays the same missions with each, and moves mean
/// and spread towards those that got most done. Missions are of other seeds in every generation.
struct NodeValueSettings {
  std::vector<GeneratorSettings> scenarios;
  std::uint64_t seed = 1;
  int generations = 40;
  int candidates = 20;
  int best = 5;
  int missions = 2;     ///< of each scenario, a candidate
  double spread = 0.3;  ///< at the start
  double early = 0.1;   ///< worth of having done all at once, above doing it at the limit
};

struct NodeValueProgress {
  int generation = 0;
  double mean = 0;    ///< of the candidates' scores
  double best = 0;    ///< the best candidate's
  double spread = 0;  ///< mean of the coefficients' spreads
};

/// Tasks done, of one, and a little for doing them early.
double ScoreOf(const Scenario& scenario, scheduler::Policy* policy, double early);

scheduler::WeightCoefficients LearnNodeValue(
    const NodeValueSettings& settings, const std::function<void(const NodeValueProgress&)>& say);

}  // namespace muster::learning
