#include "scheduler/solution.h"

#include <gtest/gtest.h>

#include <string>

#include "scheduler/solver/candidates.h"
#include "tests/scheduler/reference_graph.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::ReferenceGraph;

Node Make(ActionKind kind, int uav, int partner, int site, double weight) {
  return {weight, uav, partner, site, kind};
}

/// Four UAVs, each with a vehicle, at one charging point.
struct ChargingRow {
  explicit ChargingRow(std::int32_t places) {
    elements.n_uavs = elements.n_vehicles = 4;
    elements.capacity.assign(8, 1);
    elements.capacity.push_back(places);
    for (int i = 0; i < 4; ++i) {
      nodes.push_back(Make(ActionKind::kCharge, i, i, 0, i == 3 ? 15 : 10 + i));  // 10 11 12 15
    }
    nodes.push_back(Make(ActionKind::kUavToCharge, 0, -1, 0, 0.5));
  }
  Elements elements;
  std::vector<Node> nodes;
};

std::vector<NodeId> List(const Solution::Conflict& conflict) {
  return {conflict.begin(), conflict.end()};
}

TEST(Solution, APlaceAdmitsOne) {
  const ChargingRow row(1);
  Solution solution(row.elements, row.nodes);
  EXPECT_TRUE(solution.Fits(0));
  solution.Add(0);
  EXPECT_TRUE(solution.contains(0));
  EXPECT_FALSE(solution.Fits(0));
  EXPECT_TRUE(solution.full(8));
  EXPECT_EQ(List(solution.Conflicts(1)), std::vector<NodeId>{0});
  EXPECT_EQ(List(solution.Conflicts(4)), std::vector<NodeId>{0});  // shares UAV and place: once
  EXPECT_EQ(solution.Sigma(1), 11.0 - 10.0);
  EXPECT_EQ(solution.Sigma(4), 0.5 - 10.0);
  solution.Remove(0);
  EXPECT_TRUE(solution.Fits(1));
  EXPECT_EQ(solution.size(), 0u);
}

TEST(Solution, CPlacesAdmitCAndTheLightestGoes) {
  const ChargingRow row(2);
  Solution solution(row.elements, row.nodes);
  solution.Add(1);
  EXPECT_TRUE(solution.Fits(0));
  EXPECT_FALSE(solution.full(8));
  solution.Add(0);
  EXPECT_TRUE(solution.full(8));
  EXPECT_EQ(solution.weight(), 21.0);
  EXPECT_EQ(List(solution.Conflicts(3)), std::vector<NodeId>{0});
  EXPECT_EQ(solution.Sigma(3), 15.0 - 10.0);
  // Node 4 shares node 0's UAV: when 0 has left, a place is free and 1 may stay.
  EXPECT_EQ(List(solution.Conflicts(4)), std::vector<NodeId>{0});
  EXPECT_EQ(solution.nodes(), (std::vector<NodeId>{0, 1}));
}

TEST(Solution, OfEquallyLightTheLastGoes) {
  ChargingRow row(3);
  for (int i = 0; i < 3; ++i) row.nodes[static_cast<std::size_t>(i)].weight = 10;
  for (const std::vector<NodeId>& order : {std::vector<NodeId>{0, 1, 2}, {2, 1, 0}, {1, 2, 0}}) {
    Solution solution(row.elements, row.nodes);
    for (const NodeId node : order) solution.Add(node);
    EXPECT_EQ(List(solution.Conflicts(3)), std::vector<NodeId>{2});
  }
}

TEST(Solution, UnlimitedPlacesNeverConflict) {
  const ChargingRow row(std::numeric_limits<std::int32_t>::max());
  Solution solution(row.elements, row.nodes);
  for (NodeId node = 0; node < 4; ++node) solution.Add(node);
  EXPECT_FALSE(solution.full(8));
  EXPECT_EQ(solution.weight(), 48.0);
  EXPECT_EQ(List(solution.Conflicts(4)), std::vector<NodeId>{0});
}

TEST(SolutionDeathTest, AddingAConflictAborts) {
  const ChargingRow row(1);
  Solution solution(row.elements, row.nodes);
  solution.Add(0);
  EXPECT_DEATH(solution.Add(1), "Fits");
  EXPECT_DEATH(solution.Remove(1), "contains");
}

TEST(Solution, ConflictsAreTheEdgesOfTheExplicitGraph) {
  std::size_t edges = 0, pairs = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed);
    const Candidates candidates = EnumerateCandidates(situation);
    const ReferenceGraph reference(situation);
    const auto n = static_cast<NodeId>(candidates.nodes.size());
    ASSERT_EQ(candidates.nodes.size(), reference.nodes().size());
    for (NodeId a = 0; a < n; ++a) {
      Solution solution(candidates.elements, candidates.nodes);
      solution.Add(a);
      for (NodeId b = 0; b < n; ++b) {
        if (a == b) continue;
        const bool edge = reference.Conflict(reference.nodes()[static_cast<std::size_t>(a)],
                                             reference.nodes()[static_cast<std::size_t>(b)]);
        ASSERT_EQ(!solution.Fits(b), edge) << a << " " << b;
        ASSERT_EQ(List(solution.Conflicts(b)),
                  edge ? std::vector<NodeId>{a} : std::vector<NodeId>{});
        edges += edge;
        ++pairs;
      }
    }
  }
  EXPECT_GT(edges, 1000u);
  EXPECT_GT(pairs - edges, 1000u);
}

TEST(Solution, StaysIndependentThroughRandomMoves) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {6, 8, 5, 8, 3, 12});
    const Candidates candidates = EnumerateCandidates(situation);
    if (candidates.nodes.empty()) continue;
    const ReferenceGraph reference(situation);
    Solution solution(candidates.elements, candidates.nodes);
    Random random(seed, Stream::kTest, 7);
    for (int step = 0; step < 200; ++step) {
      const auto node =
          static_cast<NodeId>(random.Below(static_cast<std::uint32_t>(candidates.nodes.size())));
      if (solution.contains(node)) {
        solution.Remove(node);
        continue;
      }
      const double before = solution.weight();
      const double sigma = solution.Sigma(node);
      for (const NodeId other : solution.Conflicts(node)) solution.Remove(other);
      ASSERT_TRUE(solution.Fits(node));
      solution.Add(node);
      ASSERT_NEAR(solution.weight(), before + sigma, 1e-9);
      std::vector<Action> actions;
      for (const NodeId id : solution.nodes()) {
        actions.push_back(reference.nodes()[static_cast<std::size_t>(id)]);
      }
      ASSERT_EQ(actions.size(), solution.size());
      ASSERT_TRUE(reference.Independent(actions));
    }
  }
}

}  // namespace
}  // namespace muster::scheduler
