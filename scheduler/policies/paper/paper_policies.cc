#include "scheduler/policies/paper/paper_policies.h"

#include <utility>

#include "scheduler/policies/paper/ils.h"
#include "scheduler/policies/paper/mpq.h"
#include "scheduler/solver/candidates.h"

namespace muster::scheduler {
namespace {

Decision DecisionOf(const Situation& situation, const Candidates& candidates,
                    const Solution& solution) {
  std::vector<Action> actions;
  for (const NodeId node : solution.nodes()) {
    actions.push_back(
        candidates.ToAction(situation, candidates.nodes[static_cast<std::size_t>(node)]));
  }
  return MakeDecision(std::move(actions), static_cast<std::int64_t>(candidates.nodes.size()));
}

}  // namespace

Decision IlsPolicy::Decide(const Situation& situation) {
  const Candidates candidates = EnumerateCandidates(situation);
  paper::WorkingGraph graph(candidates.elements, candidates.nodes);
  graph.AddAll();
  const Solution solution =
      paper::IteratedLocalSearch(graph, Solution(candidates.elements, candidates.nodes),
                                 Random(situation.site->seed, Stream::kPolicy, 0,
                                        static_cast<std::uint32_t>(situation.decision)),
                                 max_iterations_);
  return DecisionOf(situation, candidates, solution);
}

Decision MpqPolicy::Decide(const Situation& situation) {
  const Candidates candidates = EnumerateCandidates(situation, foundation_);
  const Solution solution =
      paper::MultiPriorityQueues(candidates.elements, candidates.nodes, situation.site->seed,
                                 situation.decision, max_iterations_);
  return DecisionOf(situation, candidates, solution);
}

}  // namespace muster::scheduler
