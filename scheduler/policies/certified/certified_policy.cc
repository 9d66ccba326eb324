#include "scheduler/policies/certified/certified_policy.h"

#include <algorithm>
#include <utility>

#include "scheduler/policies/baselines/kwta.h"
#include "scheduler/policies/paper/paper_policies.h"
#include "scheduler/solver/actions.h"

namespace muster::scheduler {

namespace {

constexpr std::size_t kWorthThreads = 2000;  ///< agents and tasks
/// Gap, relative, above which simple rules are asked too. They are never heavier than the bound, so
/// below it they could add next to nothing.
constexpr double kFloorGap = 2e-4;
/// With more nodes these rules, which list them (some 50 bytes each), are not asked.
constexpr std::int64_t kFloorNodes = 2'000'000;
constexpr int kFloorWinners = 3;
/// All of them hold every agent's way to every site, some 24 bytes each: with more they are not
/// asked. (Ten times Random_29 has 17 million, a hundred times 1.6 billion.)
constexpr std::size_t kFloorWays = 20'000'000;

std::size_t WaysIn(const Situation& situation) {
  const std::size_t uavs = situation.uavs.size();
  return (uavs + situation.workers.size()) * situation.site->tasks.size() +
         (uavs + situation.vehicles.size()) * situation.site->charging_points.size();
}

/// Makes the decision at least as heavy as what simple rules decide at once.
void RaiseToFloor(const Situation& situation, const SolverLimits& limits, Decision* decision) {
  const auto raise = [&](Policy&& policy) {
    const bool late = limits.deadline && std::chrono::steady_clock::now() >= *limits.deadline;
    if (late || decision->bound - decision->weight <= kFloorGap * decision->bound) return;
    Decision other = policy.Decide(situation);
    if (other.weight > decision->weight) {
      decision->actions = std::move(other.actions);
      decision->weight = other.weight;
    }
  };
  if (WaysIn(situation) > kFloorWays) return;
  raise(KwtaPolicy(kFloorWinners));
  if (decision->candidates > kFloorNodes) return;
  raise(IlsPolicy(0));
  raise(MpqPolicy(Foundation::kHierarchical, 0));
}

}  // namespace

Decision DecideCertified(const Situation& situation, const SolverLimits& given,
                         CertifiedProfile* profile) {
  // Where there is little to do, a thread takes longer to start than it saves.
  const std::size_t size = situation.uavs.size() + situation.workers.size() +
                           situation.vehicles.size() + situation.task_status.size();
  SolverLimits limits = given;
  if (size < kWorthThreads) limits.threads = 1;
  const BuiltInstance built = BuildInstance(situation, limits.threads);
  const SolverResult solution = Solve(built.instance, limits);
  Decision decision = MakeDecision(ActionsOf(built, solution.assignment, situation),
                                   CountNodes(built.instance, limits.threads));
  // The actions' weights are summed in another order than the solver's.
  decision.bound = std::max(solution.bound, decision.weight);
  RaiseToFloor(situation, limits, &decision);
  decision.bound = std::max(decision.bound, decision.weight);
  if (profile != nullptr) {
    *profile = {built.weights_s,   built.candidates_s, solution.bound_s,
                solution.search_s, solution.work,      solution.relaxation};
  }
  return decision;
}

Decision CertifiedPolicy::Decide(const Situation& situation) {
  SolverLimits limits = limits_;
  if (deadline_) limits.deadline = std::chrono::steady_clock::now() + *deadline_;
  return DecideCertified(situation, limits, nullptr);
}

}  // namespace muster::scheduler
