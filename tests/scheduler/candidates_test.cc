#include "scheduler/candidates.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "tests/model/manhattan_ways.h"
#include "tests/scheduler/reference_graph.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::ReferenceGraph;
using testing::SituationBuilder;

std::vector<std::string> Names(const Situation& situation) {
  const Candidates candidates = EnumerateCandidates(situation);
  std::vector<std::string> names;
  for (const Node& node : candidates.nodes) {
    names.push_back(ToString(candidates.ToAction(situation, node)));
  }
  return names;
}

bool Offers(const Situation& situation, const std::string& name) {
  const auto names = Names(situation);
  return std::find(names.begin(), names.end(), name) != names.end();
}

SituationBuilder Pair() {
  SituationBuilder builder;
  builder.Uav({0, 0}, 15e3)
      .Worker({3000, 0})
      .Vehicle({0, 6000})
      .Task({6000, 0})
      .Task({12000, 0})
      .Charge({0, 0});
  return builder;
}

TEST(Candidates, AllNineKindsInTheOrderOfAlgorithm1) {
  // T1 is out of the UAV's reach (constraint (6)).
  EXPECT_EQ(
      Names(Pair().Build()),
      (std::vector<std::string>{"Ui uav:0", "UiTx uav:0 task:0", "UiTxWj uav:0 worker:0 task:0",
                                "UiCy uav:0 charge:0", "UiCyVk uav:0 vehicle:0 charge:0",
                                "Wj worker:0", "WjTx worker:0 task:0", "WjTx worker:0 task:1",
                                "Vk vehicle:0", "VkCy vehicle:0 charge:0"}));
}

TEST(Candidates, ActionsNameTheirDestination) {
  const Situation situation = Pair().Build();
  const Candidates c = EnumerateCandidates(situation);
  EXPECT_EQ(c.ToAction(situation, c.nodes[0]).to, (Point{0, 0}));
  EXPECT_EQ(c.ToAction(situation, c.nodes[2]).to, (Point{6000, 0}));
  EXPECT_EQ(c.ToAction(situation, c.nodes[2]).weight, c.nodes[2].weight);
  EXPECT_EQ(c.ToAction(situation, c.nodes[4]).to, (Point{0, 0}));
  EXPECT_EQ(c.ToAction(situation, c.nodes[5]).to, (Point{3000, 0}));
  EXPECT_EQ(c.ToAction(situation, c.nodes[8]).to, (Point{0, 6000}));
}

TEST(Candidates, ASensingPairMustEndByBothDowntimes) {
  // Both arrive after 600 s; 3000 m of sensing at 10 m/s take 300 s: the end is at 900 s.
  const std::string name = "UiTxWj uav:0 worker:0 task:0";
  for (auto list : {&Scenario::uavs, &Scenario::workers}) {
    SituationBuilder builder = Pair();
    (builder.scenario().*list)[0].online_until_us = 900 * kSecondUs;
    EXPECT_TRUE(Offers(builder.Build(), name));
    (builder.scenario().*list)[0].online_until_us = 900 * kSecondUs - 1;
    EXPECT_FALSE(Offers(builder.Build(), name));
    builder.scenario().rules.availability = Availability::kOverrun;
    EXPECT_TRUE(Offers(builder.Build(), name));
  }
}

TEST(Candidates, NothingEndsAfterTheLimit) {
  SituationBuilder builder = Pair();
  builder.scenario().rules.limit_us = 899 * kSecondUs;
  EXPECT_FALSE(Offers(builder.Build(), "UiTxWj uav:0 worker:0 task:0"));
  EXPECT_TRUE(Offers(builder.Build(), "UiTx uav:0 task:0"));  // arrives at 600 s
}

TEST(Candidates, AChargingPairMustEndByBothDowntimes) {
  // The vehicle arrives after 600 s, 15 km at 100 m/s take 150 s: the end is at 750 s.
  const std::string name = "UiCyVk uav:0 vehicle:0 charge:0";
  for (auto list : {&Scenario::uavs, &Scenario::vehicles}) {
    SituationBuilder builder = Pair();
    (builder.scenario().*list)[0].online_until_us = 750 * kSecondUs;
    EXPECT_TRUE(Offers(builder.Build(), name));
    (builder.scenario().*list)[0].online_until_us = 750 * kSecondUs - 1;
    EXPECT_FALSE(Offers(builder.Build(), name));
  }
}

TEST(Candidates, SoloMovesMustArriveByTheDowntime) {
  SituationBuilder builder = Pair();
  builder.scenario().workers[0].online_until_us = 1800 * kSecondUs;  // T1 takes 1800 s
  builder.scenario().vehicles[0].online_until_us = 600 * kSecondUs;  // C0 takes 600 s
  EXPECT_TRUE(Offers(builder.Build(), "WjTx worker:0 task:1"));
  EXPECT_TRUE(Offers(builder.Build(), "VkCy vehicle:0 charge:0"));
  builder.scenario().workers[0].online_until_us -= 1;
  builder.scenario().vehicles[0].online_until_us -= 1;
  EXPECT_FALSE(Offers(builder.Build(), "WjTx worker:0 task:1"));
  EXPECT_FALSE(Offers(builder.Build(), "VkCy vehicle:0 charge:0"));
}

TEST(Candidates, FullUavsAreOfferedCharging) {
  EXPECT_TRUE(Offers(SituationBuilder().Uav({0, 0}).Vehicle({0, 0}).Charge({0, 0}).Build(),
                     "UiCyVk uav:0 vehicle:0 charge:0"));
}

TEST(Candidates, Constraint5LimitsChargingMoves) {
  EXPECT_TRUE(Offers(SituationBuilder().Uav({0, 0}, 5000).Charge({5000, 0}).Build(),
                     "UiCy uav:0 charge:0"));
  EXPECT_FALSE(Offers(SituationBuilder().Uav({0, 0}, 4999.9).Charge({5000, 0}).Build(),
                      "UiCy uav:0 charge:0"));
}

TEST(Candidates, AFullChargingPointIsNotOffered) {
  Situation situation = Pair().Build();
  situation.charging_load[0] = 1;
  EXPECT_EQ(Names(situation),
            (std::vector<std::string>{
                "Ui uav:0", "UiTx uav:0 task:0", "UiTxWj uav:0 worker:0 task:0", "Wj worker:0",
                "WjTx worker:0 task:0", "WjTx worker:0 task:1", "Vk vehicle:0"}));
}

/// The fast forms against the paper's, node by node.
class CandidatesAgainstReference : public ::testing::TestWithParam<std::string> {};

TEST_P(CandidatesAgainstReference, SameNodesSameWeights) {
  std::size_t pairs = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rules rules;
    const std::string variant = GetParam();
    if (variant == "overrun") rules.availability = Availability::kOverrun;
    rules.ceil_to_minutes = variant == "ceil_to_minutes";
    rules.mean_over_all = variant == "mean_over_all";
    const bool uniform = variant == "uniform";
    std::optional<muster::testing::InManhattan> bent;
    if (variant == "bent_ways") bent.emplace();
    testing::RandomSize size;
    size.times = variant == "expiring";
    const Situation situation = RandomSituation(seed, size, rules);
    const Candidates fast =
        EnumerateCandidates(situation, uniform ? Foundation::kUniform : Foundation::kHierarchical);
    const ReferenceGraph reference(situation, uniform);
    ASSERT_EQ(fast.nodes.size(), reference.nodes().size());
    for (std::size_t i = 0; i < fast.nodes.size(); ++i) {
      const Action action = fast.ToAction(situation, fast.nodes[i]);
      Action expected = reference.nodes()[i];
      EXPECT_NEAR(action.weight, expected.weight, 1e-9 * std::max(1.0, expected.weight))
          << ToString(action);
      expected.weight = action.weight;
      ASSERT_EQ(action, expected) << ToString(action) << " / " << ToString(expected);
      pairs += IsPair(action.kind);
    }
  }
  EXPECT_GT(pairs, 100u);  // the instances are not trivial
}

INSTANTIATE_TEST_SUITE_P(Rules, CandidatesAgainstReference,
                         ::testing::Values("strict", "overrun", "ceil_to_minutes", "mean_over_all",
                                           "uniform", "expiring", "bent_ways"),
                         [](const auto& variant) { return variant.param; });

}  // namespace
}  // namespace muster::scheduler
