#include "scheduler/solver/build.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "model/place_index.h"
#include "scheduler/solver/actions.h"
#include "scheduler/solver/levels.h"
#include "tests/model/manhattan_ways.h"
#include "tests/scheduler/reference_graph.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;

using Key =
    std::tuple<ActionKind, std::int32_t, std::int32_t, std::int32_t, std::int32_t, std::int32_t>;
Key KeyOf(const Action& a) {
  return {a.kind, a.uav.value, a.worker.value, a.vehicle.value, a.task.value, a.charge.value};
}

/// Every node of the built instance, as actions.
std::map<Key, double> NodesOf(const BuiltInstance& built, const Situation& situation) {
  const Instance& instance = built.instance;
  std::map<Key, double> nodes;
  const auto add = [&](const Assignment& assignment, auto&& is_it) {
    for (const Action& action : ActionsOf(built, assignment, situation)) {
      if (is_it(action)) nodes[KeyOf(action)] = action.weight;
    }
  };
  Assignment idle;
  idle.uavs.resize(instance.uavs.size());
  idle.partner_solo.assign(instance.partners.size(), -1);
  add(idle, [](const Action&) { return true; });
  for (std::int32_t s = 0; s < instance.n_sites(); ++s) {
    const auto at = static_cast<std::size_t>(s);
    for (auto i = instance.uav_begin[at]; i < instance.uav_begin[at + 1]; ++i) {
      const auto& uav = instance.uav_arcs[static_cast<std::size_t>(i)];
      Assignment one = idle;
      one.uavs[static_cast<std::size_t>(uav.uav)] = {s, i, -1};
      const auto moves = [](const Action& a) { return !IsStay(a.kind); };
      if (uav.solo != Instance::kNone) add(one, moves);
      for (auto j = instance.partner_begin[at]; j < instance.partner_begin[at + 1]; ++j) {
        if (uav.pair_gain == Instance::kNone ||
            !instance.Compatible(uav, instance.partner_arcs[static_cast<std::size_t>(j)])) {
          continue;
        }
        one.uavs[static_cast<std::size_t>(uav.uav)] = {s, i, j};
        add(one, moves);
      }
    }
    for (auto j = instance.partner_begin[at]; j < instance.partner_begin[at + 1]; ++j) {
      Assignment one = idle;
      one.partner_solo[static_cast<std::size_t>(
          instance.partner_arcs[static_cast<std::size_t>(j)].partner)] = j;
      add(one, [](const Action& a) { return !IsStay(a.kind); });
    }
  }
  return nodes;
}

TEST(BuildInstance, HasTheNodesAndWeightsOfTheExplicitGraph) {
  std::size_t total = 0;
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rules rules;
    if (seed % 3 == 1) rules.availability = Availability::kOverrun;
    if (seed % 5 == 1) rules.ceil_to_minutes = true;
    if (seed % 7 == 1) rules.mean_over_all = true;
    std::optional<muster::testing::InManhattan> bent;
    if (seed % 2 == 1) bent.emplace();
    const Situation situation = RandomSituation(seed, {5, 6, 4, 8, 4, 16, seed % 4 == 3}, rules);
    std::map<Key, double> expected;
    const testing::ReferenceGraph reference(situation);
    for (const Action& action : reference.nodes()) expected[KeyOf(action)] = action.weight;
    const BuiltInstance built = BuildInstance(situation);
    const std::map<Key, double> found = NodesOf(built, situation);
    ASSERT_EQ(found.size(), expected.size());
    ASSERT_EQ(CountNodes(built.instance), static_cast<std::int64_t>(expected.size()));
    for (const auto& [key, weight] : expected) {
      const auto it = found.find(key);
      ASSERT_NE(it, found.end());
      ASSERT_NEAR(it->second, weight, 1e-9);
    }
    total += expected.size();
  }
  EXPECT_GT(total, 5000u);
}

TEST(PlaceIndex, NearestIsThatOfAPlainScan) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed, Stream::kTest);
    std::vector<Point> points(random.Below(40));
    std::vector<ChargingPoint> charges;
    // Spread over an area, on a line, at one spot.
    const double width = seed % 3 == 2 ? 0 : 1e4, height = seed % 3 == 0 ? 1e4 : 0;
    for (Point& p : points) {
      p = {random.Uniform() * width, random.Uniform() * height};
      charges.push_back({p, 1});
    }
    const PlaceIndex index(points, {});
    for (int q = 0; q < 20; ++q) {
      const Point from = {random.Uniform(-3e4, 4e4), random.Uniform(-3e4, 4e4)};
      ASSERT_EQ(index.NearestFrom(from), NearestChargeM(StraightWays(), from, charges))
          << "seed " << seed;
      const double radius = random.Uniform(0, 3e4);
      std::size_t within = 0, expected = 0;
      index.WithinFrom(from, radius, [&](std::int32_t, double) { ++within; });
      for (const Point& p : points) expected += Distance(from, p) <= radius;
      ASSERT_EQ(within, expected);
    }
  }
}

TEST(LevelOf, RoundsUpOnWholeMicroseconds) {
  // 6000 m at 10 m/s are exactly one interval of 600 s; 1 mm more are 100 us more: two.
  const LevelOf level(10, Rules());
  const std::pair<double, int> cases[] = {{0, 1}, {1, 1}, {6000, 1}, {6000.001, 2}, {12000, 2}};
  for (const auto& [distance_m, intervals] : cases) EXPECT_EQ(level(distance_m), intervals);
  // 4 um more are 0.4 us, rounded away.
  EXPECT_EQ(level(6000.000004), 1);
}

TEST(LevelOf, IsTheDefinitionAtAnyDistance) {
  Rules rules;
  Random random(7, Stream::kTest);
  for (int i = 0; i < 200000; ++i) {
    const double speed = i % 3 == 0 ? 1000.0 / 60 : random.Uniform(0.1, 40);
    const LevelOf level(speed, rules);
    double distance = random.Uniform(0, 2e5);
    if (i % 2 == 0) {
      // Close to a whole number of intervals.
      const double whole = std::floor(distance / level.reach_m()) * level.reach_m();
      distance = std::max(0.0, whole + random.Uniform(-2e-6, 2e-6) * speed);
    }
    ASSERT_EQ(level(distance), Intervals(TravelUs(distance, speed), rules.interval_us))
        << "speed " << speed << " distance " << distance;
  }
}

}  // namespace
}  // namespace muster::scheduler
