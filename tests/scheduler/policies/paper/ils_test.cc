#include "scheduler/policies/paper/ils.h"

#include <gtest/gtest.h>

#include <iostream>
#include <string>

#include "scheduler/policies/paper/mpq.h"
#include "scheduler/solver/candidates.h"
#include "tests/scheduler/policies/paper/hand_graph.h"
#include "tests/scheduler/reference_graph.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler::paper {
namespace {

using scheduler::testing::RandomSituation;
using scheduler::testing::ReferenceGraph;
using testing::HandGraph;

Solution SolveByIls(const Elements& elements, const std::vector<Node>& nodes, std::uint64_t seed,
                    int iterations = kMaxIterations) {
  WorkingGraph graph(elements, nodes);
  graph.AddAll();
  return IteratedLocalSearch(graph, Solution(elements, nodes), Random(seed, Stream::kTest),
                             iterations);
}

TEST(ExtendGreedily, GoesByLabelThenWeightThenId) {
  Elements elements;
  elements.n_uavs = 2;
  elements.n_workers = elements.n_vehicles = elements.n_tasks = 1;
  elements.capacity.assign(6, 1);
  // U0's charging weighs more than its sensing, but sensing has the higher label.
  const std::vector<Node> nodes = {
      {0.9, 0, -1, -1, ActionKind::kUavStays},   {13, 0, 0, 0, ActionKind::kCharge},
      {9, 0, 0, 0, ActionKind::kSense},          {0.7, 1, -1, -1, ActionKind::kUavStays},
      {0.7, 1, -1, 0, ActionKind::kUavToCharge}, {0.8, -1, 0, -1, ActionKind::kVehicleStays}};
  WorkingGraph graph(elements, nodes);
  graph.AddAll();
  Solution solution(elements, nodes);
  ExtendGreedily(graph, &solution);
  EXPECT_EQ(solution.nodes(), (std::vector<NodeId>{2, 3, 5}));  // 3 before 4: equal weight
  // What is given stays.
  Solution given(elements, nodes);
  given.Add(1);
  ExtendGreedily(graph, &given);
  EXPECT_EQ(given.nodes(), (std::vector<NodeId>{1, 3}));
}

TEST(PerturbStrength, GrowsWithTheWaitUpToAShareOfTheSolution) {
  EXPECT_EQ(PerturbStrength(0, 100), 1);
  EXPECT_EQ(PerturbStrength(9, 100), 1);
  EXPECT_EQ(PerturbStrength(10, 100), 2);
  EXPECT_EQ(PerturbStrength(95, 100), 10);
  EXPECT_EQ(PerturbStrength(95, 20), 6);  // 30 % of 20
  EXPECT_EQ(PerturbStrength(95, 2), 1);
}

TEST(IteratedLocalSearch, WithoutABarrierItReturnsToTheTrap) {
  // Removing 1 lets U0 and W0 stay (0.7 each), so sigma(1) = 98.6 > sigma(2) = 98.1: back to 1.
  const HandGraph hand(false);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Solution solution = SolveByIls(hand.elements, hand.nodes, seed);
    EXPECT_EQ(solution.nodes(), (std::vector<NodeId>{1, 3, 6}));
    EXPECT_NEAR(solution.weight(), 101.4, 1e-12);
  }
}

TEST(IteratedLocalSearch, ABarrierLeadsToTheBestSet) {
  // When W0 T0 (1.3) takes W0's place, sigma(1) = 100 - 0.7 - 1.3 = 98.0 < sigma(2) = 98.1: 2 comes
  // in, then 4: 189.5. Each of the 33 perturbations of label 2 does so with probability 1/2.
  const HandGraph hand(true);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Solution solution = SolveByIls(hand.elements, hand.nodes, seed);
    EXPECT_EQ(solution.nodes(), (std::vector<NodeId>{2, 4}));
    EXPECT_NEAR(solution.weight(), 189.5, 1e-12);
  }
}

TEST(IteratedLocalSearch, NoIterationsAreGreedyAndLocalSearch) {
  const HandGraph hand(true);
  EXPECT_NEAR(SolveByIls(hand.elements, hand.nodes, 1, 0).weight(), 101.4, 1e-12);
}

TEST(MultiPriorityQueues, GrowsTheGraphUntilEveryAgentHasANode) {
  // Round 1, K = 1: nodes 1, 4, 7, 6. {1, 6}: 100.7; U1 has none.
  // Round 2, K = 1: and 2, 3, 5. The search finds {2, 4}, 189.5; all four agents have a node.
  HandGraph hand(true);
  Candidates candidates;
  candidates.elements = hand.elements;
  candidates.nodes = hand.nodes;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Solution solution = MultiPriorityQueues(candidates.elements, candidates.nodes, seed, 0);
    EXPECT_EQ(solution.nodes(), (std::vector<NodeId>{2, 4}));
  }
  // Without iterations: {1, 6}, then U1's stay joins and all agents have a node: 101.4.
  EXPECT_NEAR(MultiPriorityQueues(candidates.elements, candidates.nodes, 1, 0, 0).weight(), 101.4,
              1e-12);
}

TEST(MultiPriorityQueues, EmptyGraph) {
  EXPECT_EQ(MultiPriorityQueues(Candidates{}.elements, {}, 1, 0).size(), 0u);
}

TEST(PaperSolvers, AreNearTheBestSetOfSmallInstances) {
  double best_sum = 0, ils_sum = 0, mpq_sum = 0;
  int ils_best = 0, mpq_best = 0, n = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {3, 3, 2, 4, 2, 8});
    const Candidates c = EnumerateCandidates(situation);
    const double best = ReferenceGraph(situation).BestWeight();
    const double ils = SolveByIls(c.elements, c.nodes, seed).weight();
    const double mpq = MultiPriorityQueues(c.elements, c.nodes, seed, situation.decision).weight();
    ASSERT_LE(ils, best + 1e-9);
    ASSERT_LE(mpq, best + 1e-9);
    // A local optimum of LSOA weighs at least a third of the best: a node of the best weighs no
    // more than its conflicts, and a node conflicts with at most 3 of the best.
    ASSERT_GE(ils, best / 3);
    best_sum += best;
    ils_sum += ils;
    mpq_sum += mpq;
    ils_best += ils > best - 1e-9;
    mpq_best += mpq > best - 1e-9;
    ++n;
  }
  std::cout << "of " << n << " instances solved to the best: ils " << ils_best << ", mpq "
            << mpq_best << "; weight: ils " << ils_sum / best_sum << ", mpq " << mpq_sum / best_sum
            << " of the best\n";
  EXPECT_GT(ils_sum, 0.95 * best_sum);
  EXPECT_GT(mpq_sum, 0.95 * best_sum);
}

}  // namespace
}  // namespace muster::scheduler::paper
