#include "scheduler/policies/neighbours/game.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/index.h"
#include "scheduler/checker.h"
#include "scheduler/policies/registry.h"
#include "scheduler/solver/solver.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::SituationBuilder;

/// A situation, what can be paired in it, and what the agents agree on.
struct Played {
  Played(Situation of, const Radio& heard)
      : situation(std::move(of)),
        participants(ParticipantsOf(situation, settings)),
        pairs(FindPairs(situation, participants, OpenSitesOf(situation), settings)),
        matches(AgreeOnPairs(situation, participants, pairs, heard, &candidates)) {}

  double weight() const {
    double sum = 0;
    for (const Match& match : matches) sum += match.weight;
    return sum;
  }
  /// The weight of the agent's pair; 0: it has none.
  double WeightOf(std::int32_t agent, bool is_uav, bool charging) const {
    for (const Match& match : matches) {
      if (is_uav ? match.uav == agent : match.charging == charging && match.partner == agent) {
        return match.weight;
      }
    }
    return 0;
  }

  HorizonSettings settings;
  Situation situation;
  Participants participants;
  PossiblePairs pairs;
  std::int64_t candidates = -1;
  std::vector<Match> matches;
};

constexpr Radio kEverywhere{1e6, 0, 0};

TEST(Game, AgentsPairOnlyWithThoseThatTheyHear) {
  const Situation situation =
      SituationBuilder().Uav({0, 0}).Worker({3e3, 0}).Task({1e3, 0}).Charge({0, 0}).Build();
  const Played near(situation, {3e3, 0, 0});
  ASSERT_EQ(near.matches.size(), 1u);
  EXPECT_EQ(near.matches.front().site, 0);
  EXPECT_EQ(near.candidates, 1);
  const Played far(situation, {2999, 0, 0});
  EXPECT_TRUE(far.matches.empty());
  EXPECT_EQ(far.candidates, 0);
}

TEST(Game, AWorkerAcceptsTheUavWithWhichMostIsGained) {
  // Both UAVs are there within one interval; the second has the shorter way.
  const Played played(SituationBuilder()
                          .Uav({4e3, 0})
                          .Uav({2e3, 0})
                          .Worker({0, 0})
                          .Task({0, 0})
                          .Charge({0, 0})
                          .Build(),
                      kEverywhere);
  ASSERT_EQ(played.matches.size(), 1u);
  EXPECT_EQ(played.matches.front().uav, 1);
}

TEST(Game, OfTwoPairsThatDoNotHearEachOtherTheHeavierGetsTheTask) {
  const Situation situation = SituationBuilder()
                                  .Uav({0, 0})
                                  .Worker({500, 0})
                                  .Uav({5e3, 0})
                                  .Worker({5500, 0})
                                  .Task({2e3, 0})
                                  .Charge({0, 0})
                                  .Build();
  const Played played(situation, {1e3, 0, 0});
  ASSERT_EQ(played.matches.size(), 1u);
  EXPECT_EQ(played.matches.front().uav, 0);
  EXPECT_EQ(played.matches.front().partner, 0);
}

TEST(Game, WhereEveryMessageIsLostNobodyAgrees) {
  const Played played(
      SituationBuilder().Uav({0, 0}).Worker({0, 0}).Task({0, 0}).Charge({0, 0}).Build(),
      {1e6, 1, 0});
  EXPECT_TRUE(played.matches.empty());
  EXPECT_EQ(played.candidates, 1);
}

TEST(Game, ALostMessageIsMadeUpForInLaterRounds) {
  int agreed = 0;
  for (std::int32_t decision = 0; decision < 15; ++decision) {
    SituationBuilder builder;
    builder.Decision(decision).Uav({0, 0}).Worker({0, 0}).Task({0, 0}).Charge({0, 0});
    agreed += static_cast<int>(Played(builder.Build(), {1e3, 0.5, 0}).matches.size());
  }
  // A round succeeds with 1/8, and three rounds in which the UAV does not hear the worker end the
  // talk.
  EXPECT_GE(agreed, 3);
  EXPECT_LT(agreed, 15);
}

/// By looking at every possible pair: nobody gains by moving to another site, whoever gives way.
void ExpectNashEquilibrium(const Played& played) {
  const Instance& instance = played.pairs.instance;
  std::vector<std::vector<double>> at_site(instance.capacity.size());
  for (const Match& match : played.matches) {
    const auto begin = played.pairs.site_ids.begin();
    const auto first = match.charging ? begin + played.pairs.n_tasks : begin;
    at_site[static_cast<std::size_t>(std::find(first, played.pairs.site_ids.end(), match.site) -
                                     begin)]
        .push_back(match.weight);
  }
  for (std::size_t site = 0; site < instance.capacity.size(); ++site) {
    const bool charging = site >= At(played.pairs.n_tasks);
    std::sort(at_site[site].begin(), at_site[site].end());
    ASSERT_LE(at_site[site].size(), At(instance.capacity[site]));
    const bool full = at_site[site].size() == At(instance.capacity[site]);
    for (std::int32_t u = instance.uav_begin[site]; u < instance.uav_begin[site + 1]; ++u) {
      for (std::int32_t p = instance.partner_begin[site]; p < instance.partner_begin[site + 1];
           ++p) {
        const Instance::UavArc& uav = instance.uav_arcs[At(u)];
        const Instance::PartnerArc& partner = instance.partner_arcs[At(p)];
        if (!instance.Compatible(uav, partner)) continue;
        const std::int32_t id =
            charging ? partner.partner - played.pairs.n_workers : partner.partner;
        // At most these give way, so the gain is at least:
        double least = Instance::PairWeight(uav, partner) -
                       played.WeightOf(uav.uav, true, charging) -
                       played.WeightOf(id, false, charging);
        if (full) least -= at_site[site].front();
        EXPECT_LE(least, 1e-8) << "site " << site << ", UAV " << uav.uav << ", partner " << id;
      }
    }
  }
}

TEST(Game, WithoutLossesAndLimitsItEndsInANashEquilibrium) {
  double share = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const Played played(RandomSituation(seed, {8, 10, 5, 14, 4, 10}), kEverywhere);
    ExpectNashEquilibrium(played);
    const double best = Solve(played.pairs.instance).assignment.weight;
    EXPECT_LE(played.weight(), best + 1e-6);
    // No pair gains by entering against the up to three that it conflicts with.
    EXPECT_GE(played.weight(), best / 3 - 1e-6);
    share += best > 0 ? played.weight() / best / 60 : 1.0 / 60;
  }
  RecordProperty("share_of_heaviest", std::to_string(share));
  EXPECT_GT(share, 0.9);
}

TEST(Game, DecisionsKeepTheRulesWhateverIsHeard) {
  for (const char* name : {"neighbours", "neighbours:reach=3", "neighbours:reach=2:loss=0.3",
                           "neighbours:reach=0", "neighbours:loss=1"}) {
    const auto policy = MakePolicy(name);
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const Situation situation = RandomSituation(seed, {8, 10, 5, 14, 4, 10, seed % 2 == 0});
      const Decision decision = policy->Decide(situation);
      EXPECT_TRUE(CheckActions(situation, decision.actions).empty()) << name << " " << seed;
      EXPECT_EQ(MakePolicy(name)->Decide(situation).actions, decision.actions) << name << seed;
    }
  }
}

TEST(Game, AFartherReachIsWorthMore) {
  double before = -1;
  for (const double reach_m : {500.0, 2e3, 5e3, 1e6}) {
    double sum = 0;
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
      sum += Played(RandomSituation(seed, {8, 10, 5, 14, 4, 10}), {reach_m, 0, 0}).weight();
    }
    EXPECT_GT(sum, before) << reach_m;
    before = sum;
  }
}

}  // namespace
}  // namespace muster::scheduler
