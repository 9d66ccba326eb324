#include "model/road_hierarchy.h"

#include <algorithm>
#include <memory>
#include <set>

#include <gtest/gtest.h>

#include "base/index.h"
#include "base/random.h"

namespace muster {
namespace {

using Arcs = std::vector<RoadCosts::Arc>;
using Ends = std::vector<RoadCosts::End>;

std::int32_t Draw(std::int32_t below, Random* random) {
  return static_cast<std::int32_t>(random->Below(static_cast<std::uint32_t>(below)));
}

/// Mostly to nodes nearby, as roads lead; some of no length, from a node to itself, or twice.
Arcs DrawArcs(std::int32_t n_nodes, Random* random) {
  Arcs arcs(3 * At(n_nodes));
  for (auto& arc : arcs) {
    arc.from = Draw(n_nodes, random);
    arc.to = std::clamp(arc.from + Draw(9, random) - 4, 0, n_nodes - 1);
    arc.cost_mm = random->Below(1000);
  }
  return arcs;
}

std::shared_ptr<const RoadHierarchy> HierarchyOf(std::int32_t n_nodes, const Arcs& arcs) {
  std::vector<RoadHierarchy::Edge> edges;
  for (const auto& arc : arcs) edges.push_back({arc.from, arc.to});
  return std::make_shared<const RoadHierarchy>(At(n_nodes), edges);
}

/// Bellman and Ford's: every arc again and again, until nothing becomes shorter.
std::vector<std::uint64_t> CostsByRelaxation(std::int32_t n_nodes, const Arcs& arcs,
                                             const Ends& goal) {
  constexpr std::uint64_t kNone = RoadCosts::kUnreached;
  std::vector<std::uint64_t> costs(At(n_nodes), kNone);
  for (const auto& end : goal) {
    std::uint64_t& cost = costs[At(end.node)];
    cost = std::min(cost, static_cast<std::uint64_t>(end.cost_mm));
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& arc : arcs) {
      const std::uint64_t by_it = costs[At(arc.to)] + arc.cost_mm;
      if (by_it >= costs[At(arc.from)]) continue;
      costs[At(arc.from)] = by_it;
      changed = true;
    }
  }
  return costs;
}

/// A place on a road, or at a node.
Ends DrawEnds(std::int32_t n_nodes, const Arcs& arcs, Random* random) {
  if (random->Below(2) == 0) return {{Draw(n_nodes, random), 17}};
  const auto& road = arcs[At(Draw(static_cast<std::int32_t>(arcs.size()), random))];
  return {{road.from, Draw(500, random)}, {road.to, Draw(500, random)}};
}

TEST(RoadHierarchy, CostsAreThoseOfRelaxation) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed, Stream::kTest);
    const std::int32_t n_nodes = 1 + Draw(seed < 26 ? 60 : 1500, &random);
    const Arcs all = DrawArcs(n_nodes, &random);
    const auto hierarchy = HierarchyOf(n_nodes, all);
    // With all arcs, and with two thirds of them on the same hierarchy.
    for (const bool closed : {false, true}) {
      Arcs arcs = all;
      if (closed) std::erase_if(arcs, [&](const auto&) { return random.Below(3) == 0; });
      const RoadCosts costs(hierarchy, arcs);
      const Ends goal = DrawEnds(n_nodes, all, &random);
      const auto expected = CostsByRelaxation(n_nodes, arcs, goal);
      const RoadCosts::Label to = costs.LabelTo(goal, RoadCosts::kUnreached);
      const std::uint32_t until_mm = random.Below(3000);
      const RoadCosts::Label near = costs.LabelTo(goal, until_mm);
      RoadSearch search(costs, to), near_search(costs, near);
      for (std::int32_t i = 0; i < 2 * n_nodes; ++i) {
        const std::int32_t node = Draw(n_nodes, &random);
        ASSERT_EQ(search.CostFrom(node), expected[At(node)]) << "node " << node;
        if (expected[At(node)] <= until_mm) {
          ASSERT_EQ(near_search.CostFrom(node), expected[At(node)]) << "near, node " << node;
        } else {
          ASSERT_GE(near_search.CostFrom(node), expected[At(node)]) << "near, node " << node;
        }
        const Ends begin = DrawEnds(n_nodes, all, &random);
        std::uint64_t least = RoadCosts::kUnreached;
        for (const auto& end : begin) {
          least = std::min(least, static_cast<std::uint64_t>(end.cost_mm) + expected[At(end.node)]);
        }
        ASSERT_EQ(costs.Between(costs.LabelFrom(begin, RoadCosts::kUnreached), to), least)
            << "from " << begin[0].node;
        const std::uint32_t found = costs.Between(costs.LabelFrom(begin, until_mm), near);
        ASSERT_TRUE(found == least || (found > least && least > until_mm))
            << "from " << begin[0].node << ": " << found << ", until " << until_mm << ": " << least;
      }
    }
  }
}

TEST(RoadHierarchy, CostsOnAGridAreThoseOfRelaxation) {
  // Its last ranks all lead to each other, so costs are looked at in long runs.
  constexpr std::int32_t kSide = 24;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed, Stream::kTest);
    Arcs arcs;
    for (std::int32_t node = 0; node < kSide * kSide; ++node) {
      for (const std::int32_t step : {1, kSide}) {
        const bool is_last = step == 1 ? node % kSide == kSide - 1 : node / kSide == kSide - 1;
        if (is_last) continue;
        arcs.push_back({node, node + step, 1000 + random.Below(1000)});
        arcs.push_back({node + step, node, 1000 + random.Below(1000)});
      }
    }
    const auto hierarchy = HierarchyOf(kSide * kSide, arcs);
    std::size_t longest = 0;
    for (std::size_t edge = 0; edge < hierarchy->n_edges(); ++edge) {
      longest = std::max(longest, hierarchy->RunFrom(edge));
    }
    EXPECT_GT(longest, 16U);
    const RoadCosts costs(hierarchy, arcs);
    const Ends goal{{Draw(kSide * kSide, &random), 0}};
    const auto expected = CostsByRelaxation(kSide * kSide, arcs, goal);
    const RoadCosts::Label to = costs.LabelTo(goal, RoadCosts::kUnreached);
    RoadSearch search(costs, to);
    for (std::int32_t node = 0; node < kSide * kSide; ++node) {
      ASSERT_EQ(search.CostFrom(node), expected[At(node)]) << "node " << node;
      const Ends begin{{node, 0}};
      ASSERT_EQ(costs.Between(costs.LabelFrom(begin, RoadCosts::kUnreached), to),
                expected[At(node)])
          << "node " << node;
    }
  }
}

TEST(RoadHierarchy, RanksShareTheAncestorsThatBothHave) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed, Stream::kTest);
    const std::int32_t n_nodes = 1 + Draw(200, &random);
    Arcs arcs = DrawArcs(n_nodes, &random);
    arcs.resize(arcs.size() / 2);  // into several parts
    const auto made = HierarchyOf(n_nodes, arcs);
    const RoadHierarchy& tree = *made;
    const auto ancestors = [&](std::int32_t rank) {
      std::set<std::int32_t> found;
      for (; rank >= 0; rank = tree.InTree(rank).parent) found.insert(rank);
      return found;
    };
    for (int i = 0; i < 500; ++i) {
      const std::int32_t a = Draw(n_nodes, &random), b = Draw(n_nodes, &random);
      const auto of_a = ancestors(a), of_b = ancestors(b);
      EXPECT_EQ(of_a.size(), At(tree.InTree(a).depth) + 1);
      std::vector<std::int32_t> shared;
      std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                            std::back_inserter(shared));
      EXPECT_EQ(tree.NumShared(a, b), shared.size()) << a << " and " << b;
    }
  }
}

TEST(RoadHierarchy, AWayTooLongToCountIsNone) {
  // Three nodes in a row. 2^31 - 2 mm can be counted, one more cannot.
  constexpr std::uint32_t kHalf = RoadCosts::kUnreached / 2;
  const Arcs arcs{{0, 1, kHalf}, {1, 2, kHalf}, {2, 1, kHalf + 1}, {1, 0, kHalf}};
  const RoadCosts costs(HierarchyOf(3, arcs), arcs);
  const auto between = [&](std::int32_t from, std::int32_t to) {
    const Ends begin{{from, 0}}, end{{to, 0}};
    const RoadCosts::Label label = costs.LabelTo(end, RoadCosts::kUnreached);
    const std::uint32_t cost_mm =
        costs.Between(costs.LabelFrom(begin, RoadCosts::kUnreached), label);
    EXPECT_EQ(RoadSearch(costs, label).CostFrom(from), cost_mm);
    return cost_mm;
  };
  EXPECT_EQ(between(0, 2), 2 * kHalf);
  EXPECT_EQ(between(2, 0), RoadCosts::kUnreached);
  const Ends far{{0, std::int64_t{1} << 40}};
  EXPECT_EQ(costs.Between(costs.LabelFrom(far, RoadCosts::kUnreached),
                          costs.LabelTo(far, RoadCosts::kUnreached)),
            RoadCosts::kUnreached);
}

}  // namespace
}  // namespace muster
