#include "scheduler/policies/paper/local_search.h"

#include <gtest/gtest.h>

#include <string>

#include "scheduler/solver/candidates.h"
#include "tests/scheduler/policies/paper/hand_graph.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler::paper {
namespace {

using scheduler::testing::RandomSituation;
using testing::HandGraph;

/// Alg. 3 by scanning all nodes at every step.
void PlainLocalSearch(std::size_t n, Solution* solution) {
  while (true) {
    NodeId best = kNoNode;
    for (std::size_t i = 0; i < n; ++i) {
      const auto node = static_cast<NodeId>(i);
      if (best == kNoNode || solution->Sigma(node) > solution->Sigma(best)) best = node;
    }
    if (best == kNoNode || solution->Sigma(best) <= kLeastGain) return;
    for (const NodeId other : solution->Conflicts(best)) solution->Remove(other);
    solution->Add(best);
  }
}

TEST(LocalSearch, TakesTheLargestSigmaFirst) {
  const HandGraph hand(false);
  WorkingGraph graph(hand.elements, hand.nodes);
  graph.AddAll();
  Solution solution(hand.elements, hand.nodes);
  SigmaQueue queue(graph);
  queue.Rebuild(solution);
  EXPECT_EQ(queue.top().node, 1);
  EXPECT_EQ(queue.top().sigma, 100);
  LocalSearch(graph, &solution, &queue);
  // 1 first; then sigma(2) = -0.5, sigma(4) = -10, the stays of U1 and W1 0.7 each.
  EXPECT_EQ(solution.nodes(), (std::vector<NodeId>{1, 3, 6}));
  EXPECT_EQ(queue.top().node, kNoNode);
}

TEST(LocalSearch, RemovesAllConflictsOfTheNewcomer) {
  const HandGraph hand(false);
  WorkingGraph graph(hand.elements, hand.nodes);
  graph.AddAll();
  Solution solution(hand.elements, hand.nodes);
  for (const NodeId node : {0, 3, 5, 6}) solution.Add(node);
  SigmaQueue queue(graph);
  queue.Rebuild(solution);
  // sigma: 1: 100 - 0.7 - 0.7 = 98.6; 2: 99.5 - 1.4 = 98.1; 4: 90 - 1.4 = 88.6
  EXPECT_EQ(queue.top().node, 1);
  EXPECT_NEAR(queue.top().sigma, 98.6, 1e-12);
  LocalSearch(graph, &solution, &queue);
  EXPECT_EQ(solution.nodes(), (std::vector<NodeId>{1, 3, 6}));
}

TEST(LocalSearch, EqualsThePlainFormFromAnyStart) {
  std::size_t steps = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {6, 8, 5, 9, 3, 12});
    const Candidates c = EnumerateCandidates(situation);
    WorkingGraph graph(c.elements, c.nodes);
    graph.AddAll();
    Solution solution(c.elements, c.nodes);
    SigmaQueue queue(graph);
    queue.Rebuild(solution);
    Random random(seed, Stream::kTest, 3);
    for (int round = 0; round < 10 && !c.nodes.empty(); ++round) {
      // Disturb the solution at random, keeping the queue up to date by Update alone.
      std::vector<int> changed;
      for (int i = 0; i < 6; ++i) {
        const auto node =
            static_cast<NodeId>(random.Below(static_cast<std::uint32_t>(c.nodes.size())));
        const auto touch = [&](NodeId id) {
          for (const int e : ElementsOf(graph.node(id), c.elements)) changed.push_back(e);
        };
        if (solution.contains(node)) {
          solution.Remove(node);
        } else {
          for (const NodeId other : solution.Conflicts(node)) {
            touch(other);
            solution.Remove(other);
          }
          solution.Add(node);
        }
        touch(node);
      }
      queue.Update(solution, changed);
      Solution plain = solution;
      PlainLocalSearch(c.nodes.size(), &plain);
      LocalSearch(graph, &solution, &queue);
      ASSERT_EQ(solution.nodes(), plain.nodes());
      steps += solution.size();
    }
  }
  EXPECT_GT(steps, 1000u);
}

}  // namespace
}  // namespace muster::scheduler::paper
