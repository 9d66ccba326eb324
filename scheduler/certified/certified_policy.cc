#include "scheduler/certified/certified_policy.h"

#include <algorithm>

#include "scheduler/certified/build.h"

namespace muster::scheduler {

Decision DecideCertified(const Situation& situation, const SolverLimits& limits,
                         CertifiedProfile* profile) {
  const BuiltInstance built = BuildInstance(situation, limits.threads);
  const Solution solution = Solve(built.instance, limits);
  Decision decision = MakeDecision(ActionsOf(built, solution.assignment, situation),
                                   CountNodes(built.instance, limits.threads));
  // The actions' weights are summed in another order than the solver's.
  decision.bound = std::max(solution.bound, decision.weight);
  if (profile != nullptr) {
    *profile = {built.weights_s, built.candidates_s, solution.bound_s, solution.search_s,
                solution.work};
  }
  return decision;
}

Decision CertifiedPolicy::Decide(const Situation& situation) {
  return DecideCertified(situation, limits_, nullptr);
}

}  // namespace muster::scheduler
