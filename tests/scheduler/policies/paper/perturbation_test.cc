#include "scheduler/policies/paper/perturbation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "scheduler/policies/paper/ils.h"
#include "scheduler/solver/candidates.h"
#include "tests/scheduler/policies/paper/hand_graph.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler::paper {
namespace {

using scheduler::testing::RandomSituation;
using testing::HandGraph;

TEST(Perturb, PutsBarriersInPlaceOfWhatItRemoves) {
  const HandGraph hand(true);
  WorkingGraph graph(hand.elements, hand.nodes);
  graph.AddAll();
  std::set<std::vector<NodeId>> seen;
  for (std::uint32_t draw = 0; draw < 40; ++draw) {
    Solution solution(hand.elements, hand.nodes);
    for (const NodeId node : {1, 3, 6}) solution.Add(node);
    Random random(5, Stream::kTest, 0, draw);
    // Iteration 2: label 2, of which there is node 1 alone. Its neighbours of another label that
    // fit: 0 (U0), 5 (W0), 7 (W0 T0); 5 and 7 share W0, so one of them comes too late.
    std::vector<int> changed = Perturb(graph, 2, 1, &random, &solution);
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    EXPECT_EQ(changed, (std::vector<int>{0, 2, 4}));  // U0, W0, T0
    seen.insert(solution.nodes());
  }
  EXPECT_EQ(seen, (std::set<std::vector<NodeId>>{{0, 3, 5, 6}, {0, 3, 6, 7}}));
}

TEST(Perturb, AnEmptyStratumChangesNothing) {
  const HandGraph hand(true);
  WorkingGraph graph(hand.elements, hand.nodes);
  graph.AddAll();
  Solution solution(hand.elements, hand.nodes);
  for (const NodeId node : {1, 3, 6}) solution.Add(node);
  Random random(5, Stream::kTest);
  EXPECT_TRUE(Perturb(graph, 1, 3, &random, &solution).empty());  // label 1: no UiCyVk
  EXPECT_EQ(solution.nodes(), (std::vector<NodeId>{1, 3, 6}));
}

TEST(Perturb, KeepsTheConstraintsOfTheBarrier) {
  std::size_t barriers = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Situation situation = RandomSituation(seed, {6, 8, 5, 9, 3, 12});
    const Candidates c = EnumerateCandidates(situation);
    WorkingGraph graph(c.elements, c.nodes);
    graph.AddAll();
    Solution before(c.elements, c.nodes);
    ExtendGreedily(graph, &before);
    for (int iteration = 1; iteration <= 3; ++iteration) {
      const int label = iteration % 3;
      const int strength = 3;
      Solution after = before;
      Random random(seed, Stream::kTest, 9, static_cast<std::uint32_t>(iteration));
      Perturb(graph, iteration, strength, &random, &after);
      std::vector<NodeId> removed, added;
      for (const NodeId node : before.nodes()) {
        if (!after.contains(node)) removed.push_back(node);
      }
      for (const NodeId node : after.nodes()) {
        if (!before.contains(node)) added.push_back(node);
      }
      std::size_t of_label = 0;
      for (const NodeId node : before.nodes()) of_label += Level(graph.node(node).kind) == label;
      EXPECT_EQ(removed.size(), std::min<std::size_t>(of_label, label == 2 ? 1 : 3));
      for (const NodeId node : removed) EXPECT_EQ(Level(graph.node(node).kind), label);
      for (const NodeId node : added) {
        EXPECT_NE(Level(graph.node(node).kind), label);
        const NodeElements own = ElementsOf(graph.node(node), c.elements);
        EXPECT_TRUE(std::any_of(removed.begin(), removed.end(), [&](NodeId other) {
          const NodeElements its = ElementsOf(graph.node(other), c.elements);
          return std::find_first_of(own.begin(), own.end(), its.begin(), its.end()) != own.end();
        }));
        ++barriers;
      }
    }
  }
  EXPECT_GT(barriers, 50u);
}

}  // namespace
}  // namespace muster::scheduler::paper
