#include "scheduler/explain/explain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <tuple>

#include "scheduler/policies/certified/certified_policy.h"
#include "tests/scheduler/reference_graph.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::ReferenceGraph;
using testing::SituationBuilder;

/// Calls visit(weight, pairs) for every way to command all idle agents. Exhaustive, by the
/// reference graph's nodes.
class AllDecisions {
 public:
  using Visit = std::function<void(double, const std::vector<const Action*>&)>;
  AllDecisions(const Situation& situation, Visit visit)
      : situation_(situation), graph_(situation), visit_(std::move(visit)) {
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentState& agent : situation.agents(kind)) {
        if (agent.idle(situation.now_us)) agents_.emplace_back(kind, agent.id);
      }
    }
    Choose(0, 0);
  }

 private:
  bool Used(AgentKind kind, std::int32_t id) const {
    return std::any_of(chosen_.begin(), chosen_.end(),
                       [&](const Action* a) { return MemberOf(*a, kind) == id; });
  }
  bool Fits(const Action& a) const {
    int there = 0;
    for (const Action* b : chosen_) {
      if (graph_.Conflict(a, *b)) return false;
      there += a.charge.valid() && a.charge == b->charge ? 1 : 0;
    }
    return !a.charge.valid() || there < situation_.free_places(a.charge);
  }
  void Choose(std::size_t i, double weight) {
    if (i == agents_.size()) {
      visit_(weight, chosen_);
      return;
    }
    const auto [kind, id] = agents_[i];
    if (Used(kind, id)) return Choose(i + 1, weight);
    for (const Action& node : graph_.nodes()) {
      // Pairs are chosen with their UAV.
      if (MemberOf(node, kind) != id || (kind != AgentKind::kUav && node.uav.valid())) continue;
      if (!Fits(node)) continue;
      chosen_.push_back(&node);
      Choose(i + 1, weight + node.weight);
      chosen_.pop_back();
    }
  }
  const Situation& situation_;
  const ReferenceGraph graph_;
  Visit visit_;
  std::vector<std::pair<AgentKind, std::int32_t>> agents_;
  std::vector<const Action*> chosen_;
};

/// (task, charge, agent kind, agent) of a demand.
using DemandKey = std::tuple<int, int, std::optional<AgentKind>, int>;

std::vector<DemandKey> MetBy(const Action& pair) {
  std::vector<DemandKey> keys;
  if (pair.task.valid()) keys.push_back({pair.task.value, -1, {}, -1});
  for (const AgentKind kind : kAgentKinds) {
    const std::int32_t id = MemberOf(pair, kind);
    if (id < 0) continue;
    keys.push_back({-1, -1, kind, id});
    keys.push_back({pair.task.value, pair.charge.value, kind, id});
  }
  return keys;
}

TEST(PaperScore, ForcedWeightsAreThoseOfAllDecisions) {
  int forced = 0, costly = 0, impossible = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int n = seed % 3 == 0 ? 3 : 2;
    const Situation situation = RandomSituation(seed, {.uavs = n,
                                                       .workers = 3,
                                                       .vehicles = 2,
                                                       .tasks = n + 1,
                                                       .charging_points = 2,
                                                       .area_km = 9});
    double best = 0;
    std::map<DemandKey, double> best_with;
    AllDecisions(situation, [&](double weight, const std::vector<const Action*>& actions) {
      best = std::max(best, weight);
      for (const Action* action : actions) {
        if (!IsPair(action->kind)) continue;
        for (const DemandKey& key : MetBy(*action)) {
          auto& entry = best_with[key];
          entry = std::max(entry, weight);
        }
      }
    });
    const auto score = PaperScore(situation, {});
    ASSERT_NEAR(score->Quality().best.weight, best, 1e-6);
    ASSERT_TRUE(score->Quality().best.proven());
    const auto check = [&](const DemandKey& key) {
      Demand demand;
      std::tie(demand.task.value, demand.charge.value, demand.agent_kind, demand.agent) = key;
      const auto forcing = score->Force(demand);
      const auto expected = best_with.find(key);
      ASSERT_EQ(forcing.has_value(), expected != best_with.end());
      if (!forcing) {
        ++impossible;
        return;
      }
      ++forced;
      costly += best - expected->second > 0.1 ? 1 : 0;
      ASSERT_NEAR(forcing->with.weight, expected->second, 1e-6);
      ASSERT_NEAR(forcing->cost, best - expected->second, 1e-6);
      ASSERT_TRUE(forcing->exact);
    };
    for (int x = 0; x < 3; ++x) {
      check({x, -1, {}, -1});
      for (int i = 0; i < 2; ++i) check({x, -1, AgentKind::kUav, i});
      for (int i = 0; i < 3; ++i) check({x, -1, AgentKind::kWorker, i});
    }
    for (int y = 0; y < 2; ++y) {
      for (int i = 0; i < 2; ++i) check({-1, y, AgentKind::kUav, i});
      for (int i = 0; i < 2; ++i) check({-1, y, AgentKind::kVehicle, i});
    }
    for (int i = 0; i < 2; ++i) check({-1, -1, AgentKind::kUav, i});
    for (int i = 0; i < 3; ++i) check({-1, -1, AgentKind::kWorker, i});
    for (int i = 0; i < 2; ++i) check({-1, -1, AgentKind::kVehicle, i});
  }
  EXPECT_GT(forced, 500);
  EXPECT_GT(costly, 100);
  EXPECT_GT(impossible, 500);
}

TEST(PaperLook, SaysWhatTheCandidatesSay) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed);
    const Candidates candidates = EnumerateCandidates(situation);
    const PaperLook look(situation);
    std::map<std::pair<bool, int>, std::pair<int, double>> pairs;  // number, heaviest
    for (const Node& node : candidates.nodes) {
      const Action action = candidates.ToAction(situation, node);
      ASSERT_EQ(look.WeightOf(action), node.weight) << ToString(action);
      if (!IsPair(action.kind)) continue;
      const bool charging = action.kind == ActionKind::kCharge;
      auto& [n, heaviest] = pairs[{charging, charging ? action.charge.value : action.task.value}];
      ++n;
      heaviest = std::max(heaviest, node.weight);
    }
    const auto check = [&](const PlaceLook& place) {
      const auto [n, heaviest] = pairs[{place.charging, place.site}];
      ASSERT_EQ(place.pairs_feasible, n);
      ASSERT_EQ(place.obstacle == Obstacle::kNone, n > 0);
      ASSERT_EQ(place.best.size(),
                std::min<std::size_t>(PlaceLook::kBest, static_cast<std::size_t>(n)));
      if (n > 0) {
        ASSERT_EQ(place.best.front().weight, heaviest);
      }
      if (situation.free_places(ChargeId(place.charging ? place.site : 0)) > 0 || !place.charging) {
        ASSERT_EQ(place.pairs, n + place.pairs_after_limit + place.pairs_after_window);
      }
    };
    for (std::size_t x = 0; x < situation.task_status.size(); ++x) {
      if (situation.task_status[x] == TaskStatus::kOpen) check(look.AtTask(TaskId(x)));
    }
    for (std::size_t y = 0; y < situation.site->charging_points.size(); ++y) {
      check(look.AtCharge(ChargeId(y)));
    }
  }
}

/// One UAV at (1, 1) km, a worker at (2, 1) km, a task at (4, 1) km that takes 3 km, a charging
/// point at (5, 1) km. The UAV flies 600 m a minute, the worker walks 300 m a minute: the worker
/// arrives after 400 s, sensing lasts 300 s, done at 11:40.
SituationBuilder OnePair(double range_m = 30e3) {
  SituationBuilder builder;
  builder.Uav({1e3, 1e3}, range_m).Worker({2e3, 1e3}).Task({4e3, 1e3}).Charge({5e3, 1e3});
  return builder;
}

TEST(Explainer, RangeIsConstraintSix) {
  const Situation enough = OnePair(7000).Build();  // 3 km there, 3 km sensing, 1 km to charge
  EXPECT_EQ(Explainer(enough, {}).AboutTask(TaskId(0)).verdict, TaskVerdict::kLost);
  const Situation situation = OnePair(6900).Build();
  const TaskAnswer answer = Explainer(situation, {}).AboutTask(TaskId(0));
  EXPECT_EQ(answer.verdict, TaskVerdict::kInfeasible);
  EXPECT_EQ(answer.look.obstacle, Obstacle::kRange);
  ASSERT_TRUE(answer.look.nearest_range);
  EXPECT_EQ(answer.look.nearest_range->uav, UavId(0));
  EXPECT_EQ(answer.look.nearest_range->range_m, 6900);
  EXPECT_EQ(answer.look.nearest_range->way_m, 3000);
  EXPECT_EQ(answer.look.nearest_range->cost_m, 3000);
  EXPECT_EQ(answer.look.nearest_range->to_charge_m, 1000);
  EXPECT_FALSE(answer.forcing);
}

TEST(Explainer, WindowNamesWhoseDowntimeComesFirst) {
  for (const AgentKind kind : {AgentKind::kUav, AgentKind::kWorker}) {
    SituationBuilder builder = OnePair();
    auto& agents = kind == AgentKind::kUav ? builder.scenario().uavs : builder.scenario().workers;
    agents[0].online_until_us = 11 * kMinuteUs;
    const Situation situation = builder.Build();
    const TaskAnswer answer = Explainer(situation, {}).AboutTask(TaskId(0));
    EXPECT_EQ(answer.verdict, TaskVerdict::kInfeasible);
    EXPECT_EQ(answer.look.obstacle, Obstacle::kWindow);
    ASSERT_TRUE(answer.look.nearest_time);
    EXPECT_EQ(answer.look.nearest_time->window_of, kind);
    EXPECT_EQ(answer.look.nearest_time->end_us, 700 * kSecondUs);
    EXPECT_EQ(answer.look.nearest_time->latest_us, 660 * kSecondUs);
  }
  SituationBuilder overrun = OnePair();
  overrun.scenario().workers[0].online_until_us = 11 * kMinuteUs;
  overrun.scenario().rules.availability = Availability::kOverrun;
  const Situation situation = overrun.Build();
  EXPECT_EQ(Explainer(situation, {}).AboutTask(TaskId(0)).verdict, TaskVerdict::kLost);
}

TEST(Explainer, TheLimitIsToldFromTheWindow) {
  SituationBuilder builder = OnePair();
  builder.Decision(17);  // 170 min; the pair would be done at 181:40, the mission ends at 180
  builder.scenario().uavs[0].online_until_us = builder.scenario().workers[0].online_until_us =
      400 * kMinuteUs;
  const Situation situation = builder.Build();
  const TaskAnswer answer = Explainer(situation, {}).AboutTask(TaskId(0));
  EXPECT_EQ(answer.look.obstacle, Obstacle::kLimit);
  EXPECT_EQ(answer.look.pairs_after_limit, 1);
  ASSERT_TRUE(answer.look.nearest_time);
  EXPECT_EQ(answer.look.nearest_time->latest_us, 180 * kMinuteUs);
}

TEST(Explainer, NobodyIdle) {
  SituationBuilder no_uav;
  no_uav.Worker({2e3, 1e3}).Task({4e3, 1e3}).Charge({5e3, 1e3});
  const Situation without_uav = no_uav.Build();
  EXPECT_EQ(Explainer(without_uav, {}).AboutTask(TaskId(0)).look.obstacle, Obstacle::kNoUav);
  SituationBuilder no_worker;
  no_worker.Uav({1e3, 1e3}).Task({4e3, 1e3}).Charge({5e3, 1e3});
  const Situation without_worker = no_worker.Build();
  const TaskAnswer answer = Explainer(without_worker, {}).AboutTask(TaskId(0));
  EXPECT_EQ(answer.look.obstacle, Obstacle::kNoPartner);
  EXPECT_EQ(answer.look.uavs_in_range, 1);
}

TEST(Explainer, DoneAndUnderWay) {
  Situation situation = OnePair().Task({8e3, 8e3}).Build();
  situation.task_status = {TaskStatus::kDone, TaskStatus::kReserved};
  AgentState& uav = situation.uavs[0];
  uav.action = ActionKind::kSense;
  uav.target = 1;
  uav.partner = 0;
  uav.busy_until_us = 20 * kMinuteUs;
  uav.activity = Activity{Activity::Kind::kSensing, UavId(0), 0, 1, 10 * kMinuteUs, 20 * kMinuteUs};
  const Explainer explainer(situation, {});
  EXPECT_EQ(explainer.AboutTask(TaskId(0)).verdict, TaskVerdict::kDone);
  const TaskAnswer answer = explainer.AboutTask(TaskId(1));
  EXPECT_EQ(answer.verdict, TaskVerdict::kUnderWay);
  EXPECT_EQ(answer.activity, uav.activity);
  const AgentAnswer agent =
      explainer.AboutAgent(AgentKind::kUav, 0, AgentSpec{{}, 0, 0, 0, 0, 0, kNever});
  EXPECT_EQ(agent.condition, AgentCondition::kBusy);
}

/// One UAV between two tasks, a worker beside each: task 0 is one interval off for both, task 1
/// two, so the pair at task 0 weighs about 100 and the pair at task 1 about 50.
TEST(Explainer, WhatATaskLostTo) {
  SituationBuilder builder;
  builder.Uav({10e3, 1e3}).Worker({8e3, 1e3}).Worker({18e3, 1e3});
  builder.Task({8e3, 1e3}, 1000).Task({18e3, 1e3}, 1000).Charge({10e3, 2e3});
  const Situation situation = builder.Build();
  const Decision decision = CertifiedPolicy().Decide(situation);
  const Explainer explainer(situation, decision.actions);
  EXPECT_EQ(explainer.AboutTask(TaskId(0)).verdict, TaskVerdict::kChosen);
  const TaskAnswer lost = explainer.AboutTask(TaskId(1));
  ASSERT_EQ(lost.verdict, TaskVerdict::kLost);
  // Its best pair is the UAV and the worker beside it; the UAV senses task 0 with the other one.
  const Option& option = lost.options.at(0);
  EXPECT_EQ(option.pair.uav, UavId(0));
  EXPECT_EQ(option.pair.partner, 1);
  EXPECT_EQ(option.uav_did.kind, ActionKind::kSense);
  EXPECT_EQ(option.uav_did.task, TaskId(0));
  EXPECT_GT(option.uav_did.weight, 100);
  EXPECT_LT(option.pair.weight, 60);
  EXPECT_NE(option.partner_did.kind, ActionKind::kSense);
  ASSERT_FALSE(lost.rivals.empty());
  EXPECT_NE(std::find(lost.rivals.begin(), lost.rivals.end(), option.uav_did), lost.rivals.end());
  ASSERT_TRUE(lost.forcing);
  EXPECT_TRUE(lost.forcing->exact);
  EXPECT_EQ(lost.forcing->displaced, std::vector<TaskId>{TaskId(0)});
  ASSERT_TRUE(lost.forcing->pair);
  EXPECT_EQ(lost.forcing->pair->uav, UavId(0));
  EXPECT_EQ(lost.forcing->pair->worker, WorkerId(1));
  // Half of the first task's foundation, Softplus(100) = 100, is lost, and little else changes.
  EXPECT_NEAR(lost.forcing->cost, 50, 3);
  double weight = 0;
  for (const Action& action : decision.actions) weight += action.weight;
  EXPECT_NEAR(lost.forcing->cost, weight - lost.forcing->with.weight, 1e-6);
  const DecisionQuality quality = explainer.Quality();
  EXPECT_NEAR(quality.weight, quality.best.weight, 1e-9);
  EXPECT_FALSE(quality.own_weights);

  // The worker that was left out: it could have sensed task 1, with the UAV that was taken.
  const AgentAnswer worker = explainer.AboutAgent(AgentKind::kWorker, 1, AgentSpec{});
  EXPECT_EQ(worker.condition, AgentCondition::kIdle);
  ASSERT_TRUE(worker.did);
  EXPECT_FALSE(IsPair(worker.did->kind));
  ASSERT_EQ(worker.options.size(), 2u);
  EXPECT_EQ(worker.options[0].site, 1);
  EXPECT_EQ(worker.options[0].uav_did.task, TaskId(0));
  ASSERT_TRUE(worker.options[0].forcing);
  EXPECT_NEAR(worker.options[0].forcing->cost, lost.forcing->cost, 1e-6);
  EXPECT_EQ(worker.options[1].site, 0);
  ASSERT_TRUE(worker.options[1].site_holder);
  EXPECT_EQ(worker.options[1].site_holder->worker, WorkerId(0));
}

TEST(Explainer, ForcingCostsNothingWhereWeightsTie) {
  SituationBuilder builder;  // two tasks mirror each other; one pair
  builder.Uav({10e3, 10e3}).Worker({10e3, 10e3});
  builder.Task({9e3, 10e3}, 1000).Task({11e3, 10e3}, 1000).Charge({10e3, 10e3});
  const Situation situation = builder.Build();
  const Decision decision = CertifiedPolicy().Decide(situation);
  const Explainer explainer(situation, decision.actions);
  int lost = 0;
  for (const int x : {0, 1}) {
    const TaskAnswer answer = explainer.AboutTask(TaskId(x));
    if (answer.verdict != TaskVerdict::kLost) continue;
    ++lost;
    ASSERT_TRUE(answer.forcing);
    EXPECT_EQ(answer.forcing->cost, 0);
  }
  EXPECT_EQ(lost, 1);
}

TEST(Explainer, AnAgentsBlockedPlacesByObstacle) {
  SituationBuilder builder = OnePair(6900);
  builder.Task({2e3, 2e3}, 1000).Vehicle({6e3, 1e3}).Charge({20e3, 20e3});
  builder.scenario().workers[0].online_until_us = 4 * kMinuteUs;
  const Situation situation = builder.Build();
  const AgentSpec online{{}, 0, 0, 0, 0, 0, kNever};
  const AgentAnswer uav = Explainer(situation, {}).AboutAgent(AgentKind::kUav, 0, online);
  ASSERT_EQ(uav.condition, AgentCondition::kIdle);
  EXPECT_EQ(uav.did->kind, ActionKind::kUavStays);
  EXPECT_EQ(uav.places_feasible, 1);  // charging at (5, 1)
  ASSERT_EQ(uav.options.size(), 1u);
  EXPECT_TRUE(uav.options[0].charging);
  EXPECT_EQ(uav.options[0].site, 0);
  std::map<std::pair<Obstacle, bool>, int> places;
  for (const AgentAnswer::Blocked& b : uav.blocked) places[{b.obstacle, b.charging}] = b.places;
  EXPECT_EQ(places, (std::map<std::pair<Obstacle, bool>, int>{
                        {{Obstacle::kRange, false}, 1},    // task 0
                        {{Obstacle::kWindow, false}, 1},   // task 1: the worker leaves
                        {{Obstacle::kRange, true}, 1}}));  // the far charging point
  EXPECT_EQ(Explainer(situation, {})
                .AboutAgent(AgentKind::kUav, 7, AgentSpec{{}, 0, 0, 0, 0, kMinuteUs, kNever})
                .condition,
            AgentCondition::kNotYetOnline);
  EXPECT_EQ(Explainer(situation, {})
                .AboutAgent(AgentKind::kUav, 7, AgentSpec{{}, 0, 0, 0, 0, 0, 0})
                .condition,
            AgentCondition::kOffline);
  EXPECT_EQ(Explainer(situation, {}).AboutAgent(AgentKind::kUav, 7, online).condition,
            AgentCondition::kFailed);
}

}  // namespace
}  // namespace muster::scheduler
