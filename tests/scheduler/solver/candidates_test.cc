#include "scheduler/solver/candidates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
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

/// Weight of the node of that name; NaN: it is not offered.
double WeightOf(const Situation& situation, const std::string& name,
                Foundation foundation = Foundation::kHierarchical) {
  const Candidates candidates = EnumerateCandidates(situation, foundation);
  for (const Node& node : candidates.nodes) {
    if (ToString(candidates.ToAction(situation, node)) == name) return node.weight;
  }
  return std::nan("");
}

/// One UAV with half its range, one worker, one vehicle, two tasks, one charging point:
///   interval 600 s, UAV and vehicle 6000 m an interval, worker 3000 m an interval
///   u0 (0, 0) 15 of 30 km; w0 (3000, 0); v0 (0, 6000); T0 (6000, 0); T1 (12000, 0); C0 (0, 0)
/// Constraint (6): T0 6 + 3 + 6 = 15 <= 15 holds; T1 12 + 3 + 12 = 27 does not.
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

TEST(Candidates, WeightsByHand) {
  const Situation situation = Pair().Build();
  // Du_tL = [1 / E_tL(0.5), none: 180 / 10] = [1.6065306597, 18]
  // Worker at its place: intervals 1, 3: p = 0.8807970780, 0.1192029220
  //   before 0.8807970780 * 1.6065306597 + 0.1192029220 * 18 = 3.5606801072
  // at T0: intervals 1, 2: p = 0.7310585786, 0.2689414214: after 6.0154136053
  //   Softplus((3.5606801072 - 6.0154136053) / 3.5606801072) = Softplus(-0.6894001776) / 1
  EXPECT_NEAR(WeightOf(situation, "WjTx worker:0 task:0"), 0.4067156697592846, 1e-14);
  // at T1: p the other way round: after 13.5911170544; Softplus(-2.8170003048) / 3
  EXPECT_NEAR(WeightOf(situation, "WjTx worker:0 task:1"), 0.019355355853445153, 1e-14);

  // Dw_tL = [1, 3]; the UAV at (0, 0): 0.7310585786 * 1 + 0.2689414214 * 3 = 1.5378828427,
  // at T0: intervals 1, 1: 2. Task part Softplus(-0.3004891819) = 0.5541470987.
  // One charging point: its expected cost is the same anywhere: charge part ln 2.
  // UiTx: 15 - 6 = 9 of 30 km left: 0.3 * 0.5541470987 + 0.7 * 0.6931471806
  EXPECT_NEAR(WeightOf(situation, "UiTx uav:0 task:0"), 0.65144715600272, 1e-14);
  // UiTxWj: 3 km less: 0.2 * 0.5541470987 + 0.8 * 0.6931471806 = 0.6653471642
  // 100 / max(1, 1) + 0.4067156698 + 0.6653471642
  EXPECT_NEAR(WeightOf(situation, "UiTxWj uav:0 worker:0 task:0"), 101.07206283394774, 1e-12);

  // The UAV is at C0 already: all gains 0, one interval.
  EXPECT_NEAR(WeightOf(situation, "UiCy uav:0 charge:0"), std::log(2.0), 1e-15);
  EXPECT_NEAR(WeightOf(situation, "VkCy vehicle:0 charge:0"), std::log(2.0), 1e-15);
  // Softplus(10 + e^0.5) / max(1, 1) + ln 2 + ln 2
  EXPECT_NEAR(WeightOf(situation, "UiCyVk uav:0 vehicle:0 charge:0"), 13.035024361990713, 1e-12);
  for (const char* stay : {"Ui uav:0", "Wj worker:0", "Vk vehicle:0"}) {
    EXPECT_NEAR(WeightOf(situation, stay), std::log(2.0), 1e-15);
  }
}

TEST(Candidates, UniformFoundationChangesOnlyThePairsOwnTerm) {
  const Situation situation = Pair().Build();
  for (const char* move : {"WjTx worker:0 task:0", "UiTx uav:0 task:0"}) {
    EXPECT_EQ(WeightOf(situation, move, Foundation::kUniform), WeightOf(situation, move));
  }
  // 1.3132616875 + 1.0720628339; 1.0417093878 + 2 ln 2
  EXPECT_NEAR(WeightOf(situation, "UiTxWj uav:0 worker:0 task:0", Foundation::kUniform),
              2.3853245214659, 1e-12);
  EXPECT_NEAR(WeightOf(situation, "UiCyVk uav:0 vehicle:0 charge:0", Foundation::kUniform),
              2.4280037489013, 1e-12);
}

TEST(Candidates, CeilToMinutesCountsMinutes) {
  SituationBuilder builder;
  builder.Uav({0, 0}).Task({6000, 0}).Charge({90, 0});
  builder.scenario().rules.ceil_to_minutes = true;
  // Nobody to match with: all gains 0.
  EXPECT_NEAR(WeightOf(builder.Build(), "UiTx uav:0 task:0"), std::log(2.0) / 10, 1e-15);  // 600 s
  EXPECT_NEAR(WeightOf(builder.Build(), "UiCy uav:0 charge:0"), std::log(2.0), 1e-15);     // 9 s
}

TEST(Candidates, MeanOverAllIsTheLiteralForm) {
  const std::string move = "WjTx worker:0 task:1";
  SituationBuilder builder;
  // Only the first UAV can sense (constraint (6): 0 + 3 + 0 <= 30; the second has 1 km).
  builder.Uav({0, 0}, 30e3)
      .Uav({0, 0}, 1e3)
      .Worker({0, 0})
      .Task({0, 0})
      .Task({12000, 0})
      .Charge({0, 0});
  const double feasible = WeightOf(builder.Build(), move);
  builder.scenario().rules.mean_over_all = true;
  // All of Du_tL halve: the relative gain, and so every weight, stays the same.
  EXPECT_NEAR(WeightOf(builder.Build(), move), feasible, 1e-14);
  // Once no UAV can sense at T1, the literal form says that it is matched at no cost, ours that it
  // takes the whole mission (18 intervals): going there looks better to one and worse to the other.
  builder.scenario().tasks[1].cost_m = 29e3;
  const double stay_over_4 = std::log(2.0) / 4;  // 12 km at 5 m/s: 4 intervals
  EXPECT_GT(WeightOf(builder.Build(), move), stay_over_4);
  builder.scenario().rules.mean_over_all = false;
  EXPECT_LT(WeightOf(builder.Build(), move), stay_over_4);
}

TEST(Candidates, OnlyIdleAgentsAndOpenTasksCount) {
  SituationBuilder builder = Pair();
  builder.scenario().uavs[0].range_m = 30e3;
  Situation situation = builder.Build();
  situation.task_status[0] = TaskStatus::kReserved;
  situation.workers[0].busy_until_us = 1;
  situation.vehicles[0].failed = true;
  EXPECT_EQ(Names(situation),
            (std::vector<std::string>{"Ui uav:0", "UiTx uav:0 task:1", "UiCy uav:0 charge:0"}));
  // Nobody to match with: all expected costs 0, gains 0 / 0 = 0, two intervals.
  EXPECT_NEAR(WeightOf(situation, "UiTx uav:0 task:1"), std::log(2.0) / 2, 1e-15);
}

TEST(Candidates, NobodyHasNone) {
  EXPECT_TRUE(EnumerateCandidates(SituationBuilder().Build()).nodes.empty());
}

TEST(Candidates, ElementsHaveNamesFullChargingPointsToo) {
  Situation situation = Pair().Charge({1000, 0}).Build();
  situation.charging_load[0] = 1;
  const Candidates candidates = EnumerateCandidates(situation);
  const char* names[] = {"uav:0",  "worker:0", "vehicle:0", "task:0",
                         "task:1", "charge:0", "charge:1"};
  ASSERT_EQ(candidates.elements.size(), 7);
  for (int e = 0; e < 7; ++e) EXPECT_EQ(candidates.NameOf(e), names[e]);
  EXPECT_EQ(candidates.elements.capacity, (std::vector<std::int32_t>{1, 1, 1, 1, 1, 0, 1}));
}

TEST(ActionWeights, AreThoseOfTheCandidatesAndNoOthers) {
  std::size_t offered = 0, others = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rules rules;
    if (seed % 3 == 1) rules.availability = Availability::kOverrun;
    testing::RandomSize size;
    size.times = seed % 4 == 3;
    const Situation situation = RandomSituation(seed, size, rules);
    const Candidates candidates = EnumerateCandidates(situation);
    std::map<std::string, double> weights;
    for (const Node& node : candidates.nodes) {
      weights[ToString(candidates.ToAction(situation, node))] = node.weight;
    }
    const ActionWeights of(situation);
    const auto check = [&](ActionKind kind, int uav, int worker, int vehicle, int task,
                           int charge) {
      Action action;
      action.kind = kind;
      action.uav = UavId(uav);
      action.worker = WorkerId(worker);
      action.vehicle = VehicleId(vehicle);
      action.task = TaskId(task);
      action.charge = ChargeId(charge);
      const auto found = weights.find(ToString(action));
      const auto weight = of.Of(action);
      ASSERT_EQ(weight.has_value(), found != weights.end()) << ToString(action);
      if (weight) {
        ASSERT_EQ(*weight, found->second);
      }
      ++(weight ? offered : others);
    };
    // One id beyond the last of each list, which nobody has.
    for (int u = 0; u <= size.uavs; ++u) {
      check(ActionKind::kUavStays, u, -1, -1, -1, -1);
      for (int x = 0; x < size.tasks; ++x) {
        check(ActionKind::kUavToTask, u, -1, -1, x, -1);
        for (int w = 0; w <= size.workers; ++w) check(ActionKind::kSense, u, w, -1, x, -1);
      }
      for (int y = 0; y < size.charging_points; ++y) {
        check(ActionKind::kUavToCharge, u, -1, -1, -1, y);
        for (int v = 0; v <= size.vehicles; ++v) check(ActionKind::kCharge, u, -1, v, -1, y);
      }
    }
    for (int w = 0; w <= size.workers; ++w) {
      check(ActionKind::kWorkerStays, -1, w, -1, -1, -1);
      for (int x = 0; x < size.tasks; ++x) check(ActionKind::kWorkerToTask, -1, w, -1, x, -1);
    }
    for (int v = 0; v <= size.vehicles; ++v) {
      check(ActionKind::kVehicleStays, -1, -1, v, -1, -1);
      for (int y = 0; y < size.charging_points; ++y) {
        check(ActionKind::kVehicleToCharge, -1, -1, v, -1, y);
      }
    }
    Action free_move;
    free_move.kind = ActionKind::kGoTo;
    free_move.uav = UavId(0);
    ASSERT_FALSE(of.Of(free_move));
  }
  EXPECT_GT(offered, 500u);
  EXPECT_GT(others, 500u);
}

/// The nodes read from the arcs against the paper's, node by node.
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
