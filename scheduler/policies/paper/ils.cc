#include "scheduler/policies/paper/ils.h"

#include <algorithm>

#include "scheduler/policies/paper/perturbation.h"

namespace muster::scheduler::paper {

void ExtendGreedily(const WorkingGraph& graph, Solution* solution) {
  std::vector<NodeId> open;
  for (const NodeId node : graph.members()) {
    if (solution->Fits(node)) open.push_back(node);
  }
  std::sort(open.begin(), open.end(), [&graph](NodeId a, NodeId b) {
    const Node &x = graph.node(a), &y = graph.node(b);
    if (Level(x.kind) != Level(y.kind)) return Level(x.kind) > Level(y.kind);
    if (x.weight != y.weight) return x.weight > y.weight;
    return a < b;
  });
  for (const NodeId node : open) {
    if (solution->Fits(node)) solution->Add(node);
  }
}

int PerturbStrength(int no_improvement, std::size_t solution_size) {
  const int most = std::max(1, static_cast<int>(solution_size * 3 / 10));
  return std::min(1 + no_improvement / 10, most);
}

Solution IteratedLocalSearch(const WorkingGraph& graph, const Solution& initial, Random random,
                             int max_iterations) {
  Solution current = initial;
  ExtendGreedily(graph, &current);
  SigmaQueue queue(graph);
  queue.Rebuild(current);
  LocalSearch(graph, &current, &queue);

  double current_weight = current.weight();
  Solution best = current;
  double best_weight = current_weight;
  int no_improvement = 0;
  double accept_threshold = 0.95;
  for (int iteration = 1; iteration <= max_iterations; ++iteration) {
    Solution next = current;
    SigmaQueue next_queue = queue;
    const int strength = PerturbStrength(no_improvement, current.size());
    next_queue.Update(next, Perturb(graph, iteration, strength, &random, &next));
    LocalSearch(graph, &next, &next_queue);

    ++no_improvement;
    const double next_weight = next.weight();
    if (next_weight >= accept_threshold * current_weight) {
      current = std::move(next);
      queue = std::move(next_queue);
      current_weight = next_weight;
      if (current_weight > best_weight + kLeastGain) {
        best = current;
        best_weight = current_weight;
        no_improvement = 0;
      }
    }
    if (no_improvement > max_iterations / 4) accept_threshold *= 0.99;
  }
  return best;
}

}  // namespace muster::scheduler::paper
