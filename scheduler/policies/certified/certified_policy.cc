#include "scheduler/policies/certified/certified_policy.h"

#include <algorithm>

#include "scheduler/solver/actions.h"

namespace muster::scheduler {

namespace {
constexpr std::size_t kWorthThreads = 2000;  ///< agents and tasks
}

Decision DecideCertified(const Situation& situation, const SolverLimits& given,
                         CertifiedProfile* profile) {
  // Where there is little to do, a thread takes longer to start than it saves.
  const std::size_t size = situation.uavs.size() + situation.workers.size() +
                           situation.vehicles.size() + situation.task_status.size();
  SolverLimits limits = given;
  if (size < kWorthThreads) limits.threads = 1;
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
  SolverLimits limits = limits_;
  if (deadline_) limits.deadline = std::chrono::steady_clock::now() + *deadline_;
  return DecideCertified(situation, limits, nullptr);
}

}  // namespace muster::scheduler
