#include "model/road_search.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <set>

#include <gtest/gtest.h>

#include "base/index.h"
#include "base/random.h"

namespace muster {
namespace {

struct DrawnArc {
  std::int32_t from, to;
  std::uint32_t cost_mm;
};

std::int32_t Draw(std::int32_t below, Random* random) {
  return static_cast<std::int32_t>(random->Below(static_cast<std::uint32_t>(below)));
}

std::vector<DrawnArc> DrawArcs(std::int32_t n_nodes, Random* random) {
  std::vector<DrawnArc> arcs(3 * At(n_nodes));
  for (DrawnArc& arc : arcs) {
    arc.from = Draw(n_nodes, random);
    // Mostly to nodes nearby, as roads lead; some of no length.
    const std::int32_t step = Draw(9, random) - 4;
    arc.to = std::clamp(arc.from + step, 0, n_nodes - 1);
    arc.cost_mm = random->Below(1000);
  }
  return arcs;
}

RoadGraph GraphOf(std::int32_t n_nodes, const std::vector<DrawnArc>& arcs) {
  RoadGraph graph;
  for (std::int32_t node = 0; node < n_nodes; ++node) {
    graph.arcs_of.push_back(graph.arcs.size());
    for (const DrawnArc& arc : arcs) {
      if (arc.to == node) graph.arcs.push_back({arc.from, arc.cost_mm});
    }
  }
  graph.arcs_of.push_back(graph.arcs.size());
  return graph;
}

/// Bellman and Ford's: every arc again and again, until nothing becomes shorter.
std::vector<std::uint32_t> CostsByRelaxation(std::int32_t n_nodes,
                                             const std::vector<DrawnArc>& arcs, std::int32_t goal,
                                             std::uint32_t goal_mm) {
  std::vector<std::uint32_t> costs(At(n_nodes), RoadSearch::kUnreached);
  costs[At(goal)] = goal_mm;
  for (bool changed = true; changed;) {
    changed = false;
    for (const DrawnArc& arc : arcs) {
      if (costs[At(arc.to)] == RoadSearch::kUnreached) continue;
      const std::uint32_t by_it = costs[At(arc.to)] + arc.cost_mm;
      if (by_it >= costs[At(arc.from)]) continue;
      costs[At(arc.from)] = by_it;
      changed = true;
    }
  }
  return costs;
}

TEST(CostQueue, GivesTheLeastCost) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed, Stream::kTest);
    CostQueue queue;
    std::multiset<CostQueue::Entry> expected;
    for (std::int32_t i = 0; i < 2000; ++i) {
      if (!expected.empty() && random.Below(5) < 2) {
        const CostQueue::Entry top = queue.top();
        ASSERT_EQ(top.first, expected.begin()->first);
        const auto same = expected.find(top);
        ASSERT_NE(same, expected.end()) << "never came in";
        expected.erase(same);
        queue.pop();
      } else {
        // Now and then less than what has been taken, or as much as there can be.
        const std::uint32_t least = expected.empty() ? 0 : expected.begin()->first;
        const std::uint32_t from = random.Below(50) == 0 ? 0 : least;
        const std::uint32_t cost = random.Below(100) == 0
                                       ? std::numeric_limits<std::uint32_t>::max()
                                       : from + random.Below(3000);
        queue.push({cost, i});
        expected.emplace(cost, i);
      }
      ASSERT_EQ(queue.empty(), expected.empty());
    }
  }
}

TEST(RoadSearch, FindsTheCostsOfRelaxationWhateverIsAskedFirst) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed, Stream::kTest);
    const std::int32_t n_nodes = 2 + Draw(seed < 16 ? 60 : 3000, &random);
    const std::vector<DrawnArc> arcs = DrawArcs(n_nodes, &random);
    const RoadGraph graph = GraphOf(n_nodes, arcs);
    const std::int32_t goal =
        static_cast<std::int32_t>(random.Below(static_cast<std::uint64_t>(n_nodes)));
    const std::vector<std::uint32_t> expected = CostsByRelaxation(n_nodes, arcs, goal, 17);
    const auto bytes = std::make_shared<std::atomic<std::size_t>>(0);
    for (const bool far : {false, true}) {
      RoadSearch search(graph, far, bytes);
      search.BeginAt(goal, 17);
      for (std::int32_t i = 0; i < 3 * n_nodes; ++i) {
        const auto node =
            static_cast<std::int32_t>(random.Below(static_cast<std::uint64_t>(n_nodes)));
        ASSERT_EQ(search.CostFrom(node), expected[At(node)]) << "node " << node << ", far " << far;
      }
    }
    EXPECT_EQ(*bytes, 0U);
  }
}

TEST(RoadSearch, OfAFewNodesHoldsLittle) {
  RoadGraph line;  // each node leads to the one before it
  constexpr std::int32_t kNodes = 100'000;
  for (std::int32_t node = 0; node < kNodes; ++node) {
    line.arcs_of.push_back(line.arcs.size());
    if (node + 1 < kNodes) line.arcs.push_back({node + 1, 1000});
  }
  line.arcs_of.push_back(line.arcs.size());
  const auto bytes = std::make_shared<std::atomic<std::size_t>>(0);
  RoadSearch search(line, false, bytes);
  search.BeginAt(50'000, 0);
  EXPECT_EQ(search.CostFrom(50'100), 100'000U);
  EXPECT_LT(*bytes, 10'000U);
  EXPECT_EQ(search.CostFrom(49'999), RoadSearch::kUnreached);
  EXPECT_EQ(search.CostFrom(99'999), 49'999'000U);
  EXPECT_EQ(*bytes, 4U * kNodes);
}

}  // namespace
}  // namespace muster
