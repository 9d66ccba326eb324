#include "scheduler/policies/horizon/regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/index.h"
#include "base/random.h"
#include "scheduler/policies/horizon/pairs.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::SituationBuilder;

Situation Drawn(std::uint64_t seed) {
  return RandomSituation(seed, {.uavs = 240,
                                .workers = 250,
                                .vehicles = 90,
                                .tasks = 500,
                                .charging_points = 90,
                                .area_km = 60});
}

double WeightOf(const std::vector<Match>& matches) {
  return std::accumulate(matches.begin(), matches.end(), 0.0,
                         [](double sum, const Match& match) { return sum + match.weight; });
}

/// No agent and no task twice, no more UAVs at a charging point than places, and every pair one of
/// those that could be made in one piece. There it weighs more where the best next task lies across
/// a cut.
void ExpectPossible(const Situation& situation, const Participants& participants,
                    const OpenSites& open, const std::vector<Match>& matches) {
  const PossiblePairs pairs = FindPairs(situation, participants, open, {});
  const Instance& instance = pairs.instance;
  std::set<std::pair<AgentKind, std::int32_t>> agents;
  std::vector<std::int32_t> tasks(open.task.size(), 0), places(open.place.size(), 0);
  for (const Match& match : matches) {
    EXPECT_TRUE(agents.emplace(AgentKind::kUav, match.uav).second) << match.uav;
    EXPECT_TRUE(agents.emplace(PartnerKindOf(match), match.partner).second) << match.partner;
    ++(match.charging ? places : tasks)[At(match.site)];
    const auto first = pairs.site_ids.begin() + (match.charging ? pairs.n_tasks : 0);
    const auto s = At(static_cast<std::int32_t>(std::find(first, pairs.site_ids.end(), match.site) -
                                                pairs.site_ids.begin()));
    const std::int32_t partner = match.partner + (match.charging ? pairs.n_workers : 0);
    bool found = false;
    for (auto i = instance.uav_begin.at(s); i < instance.uav_begin.at(s + 1); ++i) {
      const Instance::UavArc& uav = instance.uav_arcs[At(i)];
      if (uav.uav != match.uav) continue;
      for (auto j = instance.partner_begin.at(s); j < instance.partner_begin.at(s + 1); ++j) {
        const Instance::PartnerArc& arc = instance.partner_arcs[At(j)];
        if (arc.partner != partner || !instance.Compatible(uav, arc)) continue;
        found = true;
        const double weight = Instance::PairWeight(uav, arc);
        EXPECT_LE(match.weight, weight);
      }
    }
    EXPECT_TRUE(found) << "uav " << match.uav << " site " << match.site;
  }
  for (std::size_t x = 0; x < tasks.size(); ++x) EXPECT_LE(tasks[x], open.task[x]) << "task " << x;
  for (std::size_t y = 0; y < places.size(); ++y) {
    EXPECT_LE(places[y], open.place[y]) << "charging point " << y;
  }
}

TEST(PairsByRegion, ArePossibleAndNearlyAsHeavyAsInOnePiece) {
  int suited = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = Drawn(seed);
    const Participants participants = ParticipantsOf(situation, {});
    const OpenSites open = OpenSitesOf(situation);
    const double whole = WeightOf(HeaviestPairs(situation, participants, open, {}));
    const auto by_region = PairsByRegion(situation, participants, open, {}, 3, 1, nullptr);
    if (!by_region) continue;
    ++suited;
    ExpectPossible(situation, participants, open, *by_region);
    EXPECT_LE(WeightOf(*by_region), whole * (1 + 1e-12));
    EXPECT_GE(WeightOf(*by_region), 0.94 * whole) << "regions of 27 UAVs";
    EXPECT_TRUE(std::is_sorted(by_region->begin(), by_region->end(),
                               [](const Match& a, const Match& b) { return a.uav < b.uav; }));
  }
  EXPECT_GE(suited, 6);
}

TEST(PairsByRegion, DependNotOnThreads) {
  for (std::uint64_t seed = 21; seed <= 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = Drawn(seed);
    const Participants participants = ParticipantsOf(situation, {});
    const OpenSites open = OpenSitesOf(situation);
    std::int64_t one = 0, two = 0;
    const auto alone = PairsByRegion(situation, participants, open, {}, 3, 1, &one);
    const auto together = PairsByRegion(situation, participants, open, {}, 3, 2, &two);
    EXPECT_EQ(one, two);
    ASSERT_EQ(alone.has_value(), together.has_value());
    if (!alone) continue;
    ASSERT_EQ(alone->size(), together->size());
    for (std::size_t i = 0; i < alone->size(); ++i) {
      const Match &a = (*alone)[i], &b = (*together)[i];
      EXPECT_EQ(std::tie(a.uav, a.partner, a.site, a.charging, a.weight),
                std::tie(b.uav, b.partner, b.site, b.charging, b.weight));
    }
  }
}

/// Nine UAVs in a square of 200 m, tasks and workers 5 km around: all regions but those at the
/// edges are empty, and most pairs could only be made across cuts.
TEST(PairsByRegion, DoNotSuitWhereAllUavsStartFromOnePlace) {
  SituationBuilder builder;
  for (int i = 0; i < 9; ++i) builder.Uav({1e4 + 100.0 * (i % 3), 1e4 + 100.0 * (i / 3)}, 30e3);
  for (int i = 0; i < 9; ++i) {
    const Point place{1.5e4 + 10.0 * i, 1.5e4};
    builder.Worker(place).Task(place, 1000);
  }
  const Situation situation = builder.Charge({1.5e4, 1.6e4}).Build();
  const Participants participants = ParticipantsOf(situation, {});
  const OpenSites open = OpenSitesOf(situation);
  EXPECT_EQ(PairsByRegion(situation, participants, open, {}, 3, 1, nullptr), std::nullopt);
  EXPECT_EQ(HeaviestPairs(situation, participants, open, {}).size(), 9);
}

TEST(HeaviestPairs, OfThousandsOfUavsAreFoundByRegion) {
  SituationBuilder builder;
  builder.scenario().width_m = builder.scenario().height_m = 100e3;
  Random random(1, Stream::kTest);
  const auto place = [&] {
    const double x_m = 100e3 * random.Uniform();
    return Point{x_m, 100e3 * random.Uniform()};
  };
  for (int i = 0; i < 5400; ++i) builder.Uav(place(), 30e3);
  for (int i = 0; i < 60; ++i) {
    const Point at = place();
    builder.Worker(at).Task(at, 1000).Charge(at);
  }
  const Situation situation = builder.Build();
  const Participants participants = ParticipantsOf(situation, {});
  const OpenSites open = OpenSitesOf(situation);
  const auto by_region = PairsByRegion(situation, participants, open, {}, 3, 1, nullptr);
  ASSERT_TRUE(by_region);
  const std::vector<Match> matches = HeaviestPairs(situation, participants, open, {});
  EXPECT_EQ(matches.size(), 60);
  ASSERT_EQ(matches.size(), by_region->size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    EXPECT_EQ(matches[i].uav, (*by_region)[i].uav);
    EXPECT_EQ(matches[i].site, (*by_region)[i].site);
  }
}

/// All tasks lie east of all UAVs, and only the western half of these has any range: in every
/// region either the UAVs or the tasks are of no use.
TEST(HeaviestPairs, AreFoundInOnePieceWhereNoRegionsSuit) {
  SituationBuilder builder;
  for (int i = 0; i < 5400; ++i) {
    builder.Uav({1e4 + 0.1 * i, 1e4 + i % 73}, i < 2700 ? 30e3 : 10.0);
  }
  for (int i = 0; i < 20; ++i) {
    const Point at{1.2e4, 1e4 + 20.0 * i};
    builder.Worker(at).Task(at, 1000).Charge(at);
  }
  const Situation situation = builder.Build();
  const Participants participants = ParticipantsOf(situation, {});
  const OpenSites open = OpenSitesOf(situation);
  EXPECT_FALSE(PairsByRegion(situation, participants, open, {}, 3, 1, nullptr));
  EXPECT_FALSE(PairsByRegion(situation, participants, open, {}, 2, 1, nullptr));
  EXPECT_EQ(HeaviestPairs(situation, participants, open, {}).size(), 20);
}

std::vector<Participant> UavsAt(const std::vector<Point>& places) {
  std::vector<Participant> uavs;
  for (const Point place : places) {
    uavs.emplace_back();
    uavs.back().at = place;
  }
  return uavs;
}

/// Columns are cut before the UAVs at x = 2; rows before the upper one of each column.
TEST(Regions, HaveAsManyUavsEach) {
  const auto uavs = UavsAt({{0, 5}, {1, 0}, {2, 3}, {3, 9}});
  const Regions regions(uavs, 2, false);
  EXPECT_EQ(regions.size(), 4);
  EXPECT_EQ(regions.Of({1, 0}), 0);
  EXPECT_EQ(regions.Of({0, 5}), 1);
  EXPECT_EQ(regions.Of({2, 3}), 2);
  EXPECT_EQ(regions.Of({3, 9}), 3);
  // Where there is no UAV, the nearest edge decides.
  EXPECT_EQ(regions.Of({-100, -100}), 0);
  EXPECT_EQ(regions.Of({100, 100}), 3);
  EXPECT_TRUE(regions.IsNearCut({1.5, -7}, 0.5));
  EXPECT_FALSE(regions.IsNearCut({1.5, -7}, 0.4));
  EXPECT_TRUE(regions.IsNearCut({-9, 5.25}, 0.25));
  EXPECT_FALSE(regions.IsNearCut({9, 5.25}, 0.25));
}

TEST(Regions, ShiftedOnesHaveOtherCuts) {
  std::vector<Point> places;
  for (int i = 0; i < 64; ++i)
    places.push_back({static_cast<double>(i % 8), static_cast<double>(i / 8)});
  const auto uavs = UavsAt(places);
  const Regions regions(uavs, 2, false), shifted(uavs, 2, true);
  EXPECT_EQ(regions.size(), 4);
  EXPECT_EQ(shifted.size(), 9);
  // Columns: 0 to 3 and 4 to 7; shifted: 0 and 1, 2 to 5, 6 and 7.
  EXPECT_NE(regions.Of({3, 3}), regions.Of({4, 4}));
  EXPECT_EQ(shifted.Of({2, 2}), shifted.Of({5, 5}));
  EXPECT_NE(shifted.Of({1, 1}), shifted.Of({2, 2}));
}

}  // namespace
}  // namespace muster::scheduler
