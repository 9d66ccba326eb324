#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <tuple>

#include "model/made_up.h"
#include "model/road_ways.h"
#include "scheduler/explain/explain.h"
#include "scheduler/explain/fate.h"
#include "scheduler/policies/horizon/horizon.h"
#include "scheduler/policies/horizon/pairs.h"
#include "scheduler/policies/rollout/rollout.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::RandomSize;
using testing::SituationBuilder;

/// The decision of that policy, as logged.
std::unique_ptr<HorizonDecision> Made(const Situation& situation, MatchingPolicy* policy) {
  return std::make_unique<HorizonDecision>(situation, policy->Decide(situation).actions, *policy);
}

/// Calls visit(worth, pairs) for every matching: every set of pairs in which no agent, no task and
/// no more places than are free are used. Exhaustive, by UAV.
class AllMatchings {
 public:
  using Visit = std::function<void(double, const std::vector<Match>&)>;
  AllMatchings(const Situation& situation, const HorizonSettings& settings, Visit visit)
      : open_(OpenSitesOf(situation)), visit_(std::move(visit)) {
    const Participants participants = ParticipantsOf(situation, settings);
    const PossiblePairs pairs = FindPairs(situation, participants, open_, settings);
    by_uav_.resize(participants.uavs.size());
    for (std::int32_t site = 0; site < pairs.instance.n_sites(); ++site) {
      const auto s = static_cast<std::size_t>(site);
      for (auto i = pairs.instance.uav_begin[s]; i < pairs.instance.uav_begin[s + 1]; ++i) {
        for (auto j = pairs.instance.partner_begin[s]; j < pairs.instance.partner_begin[s + 1];
             ++j) {
          const auto& uav = pairs.instance.uav_arcs[static_cast<std::size_t>(i)];
          const auto& partner = pairs.instance.partner_arcs[static_cast<std::size_t>(j)];
          if (!pairs.instance.Compatible(uav, partner)) continue;
          by_uav_[static_cast<std::size_t>(uav.uav)].push_back(
              MatchOf(pairs, participants, site, uav, partner));
        }
      }
    }
    Choose(0, 0);
  }

 private:
  bool Fits(const Match& pair) const {
    int there = 0;
    for (const Match& other : chosen_) {
      if (other.charging != pair.charging) continue;
      if (other.partner == pair.partner) return false;
      there += other.site == pair.site ? 1 : 0;
    }
    return there < (pair.charging ? open_.place[static_cast<std::size_t>(pair.site)] : 1);
  }
  void Choose(std::size_t uav, double worth) {
    if (uav == by_uav_.size()) return visit_(worth, chosen_);
    Choose(uav + 1, worth);
    for (const Match& pair : by_uav_[uav]) {
      if (!Fits(pair)) continue;
      chosen_.push_back(pair);
      Choose(uav + 1, worth + pair.weight);
      chosen_.pop_back();
    }
  }

  OpenSites open_;
  Visit visit_;
  std::vector<std::vector<Match>> by_uav_;
  std::vector<Match> chosen_;
};

TEST(ExplainerOfHorizon, CostOfForcingIsThatOfAllMatchings) {
  int forced = 0, costly = 0, impossible = 0, agents = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(
        seed,
        {.uavs = 3, .workers = 3, .vehicles = 2, .tasks = 4, .charging_points = 2, .area_km = 9});
    HorizonSettings settings;
    if (seed % 2 == 0) settings.charge_worth = 1.6;
    HorizonPolicy policy(settings);
    const auto decision = Made(situation, &policy);
    double best = 0;
    std::map<int, double> best_at;                                    // task
    std::map<std::tuple<AgentKind, int, bool, int>, double> best_of;  // agent, charging, place
    const Participants& who = decision->deciding.plan.now;
    AllMatchings(situation, settings, [&](double worth, const std::vector<Match>& pairs) {
      best = std::max(best, worth);
      const auto raise = [worth](auto* values, const auto& key) {
        const auto [entry, is_new] = values->try_emplace(key, worth);
        if (!is_new) entry->second = std::max(entry->second, worth);
      };
      for (const Match& pair : pairs) {
        if (!pair.charging) raise(&best_at, pair.site);
        const AgentKind kind = pair.charging ? AgentKind::kVehicle : AgentKind::kWorker;
        const int uav = who.uavs[static_cast<std::size_t>(pair.uav)].agent->id;
        const int partner = who[kind][static_cast<std::size_t>(pair.partner)].agent->id;
        raise(&best_of, std::tuple(AgentKind::kUav, uav, pair.charging, pair.site));
        raise(&best_of, std::tuple(kind, partner, pair.charging, pair.site));
      }
    });
    const Explainer explainer(*decision);
    for (int x = 0; x < 4; ++x) {
      if (situation.task_status[static_cast<std::size_t>(x)] != TaskStatus::kOpen) continue;
      const TaskAnswer answer = explainer.AboutTask(TaskId(x));
      EXPECT_EQ(answer.look.obstacle == Obstacle::kNone, best_at.contains(x));
      EXPECT_EQ(answer.verdict == TaskVerdict::kImpossible, !best_at.contains(x) && !answer.plan);
      impossible += best_at.contains(x) ? 0 : 1;
      if (answer.options.empty()) continue;
      ASSERT_TRUE(answer.forcing);
      ASSERT_TRUE(answer.forcing->exact && answer.forcing->plan);
      EXPECT_NEAR(explainer.Quality().best.weight, best, 1e-6);
      EXPECT_NEAR(answer.forcing->cost, best - best_at.at(x), 1e-6);
      EXPECT_EQ(answer.forcing->plan->site, x);
      EXPECT_LE(answer.forcing->displaced.size(), 3u);
      ++forced;
      costly += answer.forcing->cost > 0.01 ? 1 : 0;
    }
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentState& agent : situation.agents(kind)) {
        const AgentAnswer answer = explainer.AboutAgent(kind, agent.id, {});
        for (const Option& option : answer.options) {
          ASSERT_TRUE(option.forcing && option.forcing->exact);
          EXPECT_NEAR(option.forcing->cost,
                      best - best_of.at({kind, agent.id, option.charging, option.site}), 1e-6);
          ++agents;
        }
      }
    }
  }
  EXPECT_GT(forced, 100);
  EXPECT_GT(costly, 50);
  EXPECT_GT(impossible, 50);
  EXPECT_GT(agents, 300);
}

/// By road some tasks are out of reach, and the commander forbids some pairs: what is not possible
/// has a reason, and a task that no worker has a way to has that one.
TEST(ExplainerOfHorizon, WhatNobodyHasAWayToHasAReason) {
  int no_road = 0, others = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed, Stream::kTest);
    const auto place = [&] { return Point{6000 * random.Uniform(), 6000 * random.Uniform()}; };
    SituationBuilder builder;
    Scenario& scenario = builder.scenario();
    scenario.width_m = scenario.height_m = 6000;
    const auto roads = std::make_shared<const RoadWays>(
        std::make_shared<const Roads>(StreetGrid(5, 1000, seed)),
        PerKind<OpenGround>{{}, {50, 250}, {25, 250}}, std::vector<Point>{});
    scenario.ways = roads;
    for (int i = 0; i < 3; ++i) builder.Uav(place()).Worker(place()).Vehicle(place());
    for (int i = 0; i < 5; ++i) builder.Task(place(), 500).Charge(place());
    Situation situation = builder.Build();
    if (seed % 3 == 0) {
      auto site = std::make_shared<Site>(*situation.site);
      for (std::int32_t worker = 0; worker < 3; ++worker) {
        site->forbidden.push_back({AgentKind::kWorker, worker, 0});
      }
      situation.site = site;
    }
    HorizonPolicy policy{HorizonSettings()};
    const auto decision = Made(situation, &policy);
    const Explainer explainer(*decision);
    for (int x = 0; x < 5; ++x) {
      const TaskAnswer answer = explainer.AboutTask(TaskId(x));
      EXPECT_EQ(answer.look.obstacle == Obstacle::kNone, answer.look.pairs_feasible > 0);
      const Point to = situation.site->tasks[static_cast<std::size_t>(x)].at;
      const bool reached = std::any_of(
          situation.workers.begin(), situation.workers.end(), [&](const AgentState& worker) {
            return std::isfinite(roads->Length(AgentKind::kWorker, worker.to, to));
          });
      if (!reached && answer.look.uavs_in_range > 0) {
        EXPECT_EQ(answer.look.obstacle, Obstacle::kNoRoad);
        ++no_road;
      } else if (answer.look.obstacle != Obstacle::kNone) {
        EXPECT_NE(answer.look.obstacle, Obstacle::kNoRoad);
        const bool forbidden = x == 0 && seed % 3 == 0 && answer.look.uavs_in_range > 0;
        EXPECT_EQ(answer.look.obstacle == Obstacle::kForbidden, forbidden);
        ++others;
      }
    }
    for (const AgentKind kind : kAgentKinds) {
      for (std::int32_t id = 0; id < 3; ++id) explainer.AboutAgent(kind, id, {});
    }
  }
  EXPECT_GT(no_road, 50);
  EXPECT_GT(others, 20);
}

/// What stands against a pair, from distances and times alone.
TEST(HorizonLook, ObstaclesFollowFromTheRules) {
  std::map<Obstacle, int> seen;
  int soon = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed);
    const Site& site = *situation.site;
    const HorizonSettings settings;
    const HorizonLook look(situation, settings);
    for (std::size_t x = 0; x < site.tasks.size(); ++x) {
      if (situation.task_status[x] != TaskStatus::kOpen) continue;
      int feasible = 0, window = 0, limit = 0, in_range = 0;
      double least_late_s = 1e18;
      Obstacle nearest = Obstacle::kNone;
      for (const Participant& uav : look.participants().uavs) {
        const double way_m = Distance(uav.at, site.tasks[x].at);
        if (way_m + site.tasks[x].cost_m + site.task_to_charge_m[x] > uav.range_m) continue;
        ++in_range;
        for (const Participant& worker : look.participants().workers) {
          const double uav_s =
              static_cast<double>(uav.ready_us) / 1e6 + way_m / uav.agent->speed_m_s;
          const double worker_s = static_cast<double>(worker.ready_us) / 1e6 +
                                  Distance(worker.at, site.tasks[x].at) / worker.agent->speed_m_s;
          const double end_s =
              std::max(uav_s, worker_s) + site.tasks[x].cost_m / uav.agent->speed_m_s;
          const auto until_us = std::min(uav.agent->online_until_us, worker.agent->online_until_us);
          soon += uav.idle && worker.idle ? 0 : 1;
          if (end_s > static_cast<double>(site.rules.limit_us) / 1e6 + 1e-4) {
            ++limit;
            const double late_s = end_s - static_cast<double>(site.rules.limit_us) / 1e6;
            if (late_s < least_late_s - 1e-4) nearest = Obstacle::kLimit;
            least_late_s = std::min(least_late_s, late_s);
          } else if (end_s > static_cast<double>(until_us) / 1e6 + 1e-4) {
            ++window;
            const double late_s = end_s - static_cast<double>(until_us) / 1e6;
            if (late_s < least_late_s - 1e-4) nearest = Obstacle::kWindow;
            least_late_s = std::min(least_late_s, late_s);
          } else {
            ++feasible;
          }
        }
      }
      const PlaceLook place = look.AtTask(TaskId(static_cast<int>(x)));
      EXPECT_EQ(place.uavs_in_range, in_range);
      EXPECT_EQ(place.pairs_feasible, feasible);
      EXPECT_EQ(place.pairs_after_window, window);
      EXPECT_EQ(place.pairs_after_limit, limit);
      const Obstacle expected = feasible > 0                          ? Obstacle::kNone
                                : look.participants().uavs.empty()    ? Obstacle::kNoUav
                                : look.participants().workers.empty() ? Obstacle::kNoPartner
                                : in_range == 0                       ? Obstacle::kRange
                                                                      : nearest;
      EXPECT_EQ(place.obstacle, expected);
      ++seen[place.obstacle];
    }
    for (std::size_t y = 0; y < site.charging_points.size(); ++y) {
      const PlaceLook place = look.AtCharge(ChargeId(static_cast<int>(y)));
      EXPECT_EQ(place.obstacle == Obstacle::kNone, place.pairs_feasible > 0);
      ++seen[place.obstacle];
    }
  }
  for (const Obstacle obstacle : {Obstacle::kNone, Obstacle::kNoPlace, Obstacle::kRange,
                                  Obstacle::kWindow, Obstacle::kNoUse}) {
    EXPECT_GT(seen[obstacle], 0) << ToString(obstacle);
  }
  EXPECT_GT(soon, 100);
}

TEST(HowDecided, FindsTheVariantAndTheDraw) {
  int variants = 0, draws = 0, later_draws = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(
        seed,
        {.uavs = 6, .workers = 8, .vehicles = 3, .tasks = 14, .charging_points = 3, .area_km = 20});
    RolloutSettings settings;
    if (seed % 3 == 0) {
      for (HorizonSettings& variant : settings.variants) variant.steps = true;
    }
    if (seed % 2 == 0) settings.rounds = 3;
    RolloutPolicy policy(settings);
    const Decision decision = policy.Decide(situation);
    const HowDecided how = policy.Explain(situation, decision.actions).how;
    ASSERT_TRUE(how.again);
    EXPECT_EQ(HorizonPolicy(how.settings).Decide(situation).actions, decision.actions);
    ASSERT_TRUE(how.follow);
    variants += how.variant > 0 ? 1 : 0;
    draws += how.draws.empty() ? 0 : 1;
    later_draws += how.draws.size() == 2 ? 1 : 0;
    if (decision.actions.empty()) continue;
    std::vector<Action> other = decision.actions;
    other.front().weight += 0.5;
    EXPECT_FALSE(policy.Explain(situation, other).how.again);
  }
  EXPECT_GT(variants, 0);
  EXPECT_GT(draws, 0);
  EXPECT_GT(later_draws, 0);
}

TEST(HowDecided, SettingsAreToldByWhatDiffers) {
  EXPECT_EQ(Difference({}), "");
  HorizonSettings settings;
  settings.patience = 0.6;
  settings.chains = false;
  settings.jitters[0].most = 0.1;
  EXPECT_EQ(Difference(settings), "patience 0.6, without chains");
}

/// A UAV at (1, 1) km that flies 600 m a minute, a worker there that comes free at 10 min, a task
/// at (4, 1) km that takes 3 km, a charging point at (5, 1) km. Sensing 5 min, ways 5 and 10 min:
/// they would be done at 25 min.
SituationBuilder SoonFree() {
  SituationBuilder builder;
  builder.Uav({1e3, 1e3}).Worker({1e3, 1e3}).Task({4e3, 1e3}).Charge({5e3, 1e3});
  return builder;
}

void Busy(AgentState* agent, TimeUs until_us) {
  agent->action = ActionKind::kGoTo;
  agent->busy_until_us = agent->arrive_us = until_us;
  agent->decision = 0;
}

/// Two pairs far from each other, each with two equal tasks to choose from, and a third task that
/// the first pair can serve. What forcing it displaces is near it, however the others tie.
TEST(ExplainerOfHorizon, ForcingDisplacesOnlyWhatItHasTo) {
  SituationBuilder builder;
  builder.Uav({1e3, 1e3}).Worker({1e3, 1e3}).Charge({1e3, 2e3});
  builder.Task({2e3, 1e3}).Task({1e3, 4e3});
  for (int i = 0; i < 4; ++i) {
    const double x_m = 20e3 + i * 2e3;
    builder.Uav({x_m, 25e3}).Worker({x_m, 25e3}).Charge({x_m, 25e3});
    builder.Task({x_m, 24e3}).Task({x_m, 26e3});
  }
  HorizonPolicy policy;
  const Situation situation = builder.Build();
  const auto decision = Made(situation, &policy);
  const TaskAnswer answer = Explainer(*decision).AboutTask(TaskId(1));
  ASSERT_TRUE(answer.forcing);
  EXPECT_EQ(answer.forcing->displaced, std::vector<TaskId>{TaskId(0)});
  EXPECT_EQ(answer.forcing->plan->uav, UavId(0));
}

TEST(ExplainerOfHorizon, APairWithAMemberThatWillBeFreeIsPlanned) {
  SituationBuilder builder = SoonFree();
  Situation situation = builder.Build();
  Busy(&situation.workers[0], 10 * kMinuteUs);
  HorizonPolicy policy;
  const auto decision = Made(situation, &policy);
  const TaskAnswer answer = Explainer(*decision).AboutTask(TaskId(0));
  EXPECT_EQ(answer.verdict, TaskVerdict::kPlanned);
  ASSERT_TRUE(answer.plan);
  EXPECT_FALSE(answer.plan->uav_free_us);
  EXPECT_EQ(answer.plan->partner_free_us, 10 * kMinuteUs);
  EXPECT_EQ(answer.plan->end_us, 25 * kMinuteUs);
  EXPECT_FALSE(answer.plan->second);
  ASSERT_EQ(answer.commanded.size(), 1u);
  EXPECT_EQ(answer.commanded[0].kind, ActionKind::kUavToTask);

  Busy(&situation.workers[0], 40 * kMinuteUs);  // beyond two decisions
  const auto later = Made(situation, &policy);
  const TaskAnswer none = Explainer(*later).AboutTask(TaskId(0));
  EXPECT_EQ(none.verdict, TaskVerdict::kImpossible);
  EXPECT_EQ(none.look.obstacle, Obstacle::kNoPartner);
  EXPECT_EQ(none.look.busy_partners, 1);
}

class Fates : public ::testing::Test {
 protected:
  Fates() {
    Situation situation = builder_.Build();
    Busy(&situation.workers[0], 10 * kMinuteUs);
    first_ = Made(situation, &policy_);
    plan_ = *Explainer(*first_).AboutTask(TaskId(0)).plan;
  }
  Situation Next() {
    builder_.Decision(1);
    return builder_.Build();
  }
  Fate Of(const Situation& next) {
    second_ = Made(next, &policy_);
    return FateOf(plan_, 0, builder_.scenario(),
                  [&](std::int32_t d) { return d == 1 ? second_.get() : nullptr; });
  }

  SituationBuilder builder_ = SoonFree();
  HorizonPolicy policy_;
  std::unique_ptr<HorizonDecision> first_, second_;
  PairPlan plan_;
};

TEST_F(Fates, ComesAbout) {
  const Fate fate = Of(Next());
  EXPECT_EQ(fate.kind, FateKind::kCameAbout);
  EXPECT_EQ(fate.decision, 1);
  EXPECT_EQ(fate.at_us, 10 * kMinuteUs);
}

TEST_F(Fates, StillPlannedAtTheEnd) {
  Situation next = Next();
  Busy(&next.workers[0], 20 * kMinuteUs);
  const Fate fate = Of(next);
  EXPECT_EQ(fate.kind, FateKind::kOpen);
  EXPECT_EQ(fate.kept, 1);
}

TEST_F(Fates, SomebodyElseHasDoneIt) {
  Situation next = Next();
  next.task_status[0] = TaskStatus::kDone;
  EXPECT_EQ(Of(next).kind, FateKind::kOthers);
}

TEST_F(Fates, AMemberFails) {
  Situation next = Next();
  next.workers.clear();
  const Fate fate = Of(next);
  EXPECT_EQ(fate.kind, FateKind::kFailed);
  EXPECT_EQ(fate.member_kind, AgentKind::kWorker);
  EXPECT_EQ(fate.member, 0);
}

TEST_F(Fates, AMemberGoesOffline) {
  Situation next = Next();
  next.uavs.clear();
  builder_.scenario().uavs[0].online_until_us = 9 * kMinuteUs;
  const Fate fate = Of(next);
  EXPECT_EQ(fate.kind, FateKind::kOffline);
  EXPECT_EQ(fate.member_kind, AgentKind::kUav);
}

TEST_F(Fates, BecomesImpossible) {
  Situation next = Next();
  next.uavs[0].range_at_departure_m = 6e3;  // of 3 + 3 + 1 km
  const Fate fate = Of(next);
  EXPECT_EQ(fate.kind, FateKind::kImpossible);
  ASSERT_TRUE(fate.look);
  EXPECT_EQ(fate.look->obstacle, Obstacle::kRange);
}

TEST_F(Fates, IsOutbidByAnotherTaskOfItsMembers) {
  builder_.Task({1e3, 1e3});  // where both stand; the other one is still planned for after it
  builder_.scenario().uavs[0].range_m = 7.5e3;
  const Fate fate = Of(Next());
  EXPECT_EQ(fate.kind, FateKind::kOutbid) << ToString(fate.kind);
  ASSERT_EQ(fate.rivals.size(), 1u);
  EXPECT_EQ(fate.rivals[0].site, 1);
}

TEST_F(Fates, AnotherPairIsBetter) {
  builder_.Uav({4e3, 1e3}).Worker({4e3, 1e3});
  const Fate fate = Of(Next());
  EXPECT_EQ(fate.kind, FateKind::kOthers);
  ASSERT_TRUE(fate.taken_by);
  EXPECT_EQ(fate.taken_by->uav, UavId(1));
}

}  // namespace
}  // namespace muster::scheduler
