// What the commander has decided, in single decisions.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "scheduler/checker.h"
#include "scheduler/policies/directives/directing.h"
#include "scheduler/policies/registry.h"
#include "tests/scheduler/reference_graph.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::SituationBuilder;
using State = DirectiveOutcome::State;

Directive Make(Directive::Kind kind, PerKind<std::int32_t> agents, std::int32_t task = -1) {
  Directive directive;
  directive.kind = kind;
  directive.order = "d";
  directive.agents = agents;
  directive.task = task;
  return directive;
}
Directive Pin(std::int32_t uav, std::int32_t worker, std::int32_t task) {
  return Make(Directive::Kind::kPin, {uav, worker, -1}, task);
}

/// In a row, 1 km apart: T0, u0 and w0, u1 and w1, T1; the charging point and its vehicle beside.
SituationBuilder Row() {
  SituationBuilder builder;
  builder.Uav({2000, 5000})
      .Uav({3000, 5000}, 20e3)
      .Worker({2000, 5000})
      .Worker({3000, 5000})
      .Vehicle({2000, 6000})
      .Task({1000, 5000})
      .Task({4000, 5000})
      .Charge({2000, 6000});
  return builder;
}

Situation With(SituationBuilder builder, const std::vector<Directive>& directives) {
  builder.scenario().directives = directives;
  return builder.Build();
}

/// "u0 w1 T0", "u1 v0 C0", "w0 to T1", ... of what is not staying, in the decision's order.
std::vector<std::string> Told(const Decision& decision) {
  std::vector<std::string> told;
  for (const Action& a : decision.actions) {
    if (!IsStay(a.kind)) told.push_back(ToString(a));
  }
  return told;
}
Decision Decide(const Situation& situation, const char* policy = "certified") {
  return DecideWithDirectives(situation, MakePolicy(policy).get());
}
using Actions = std::vector<std::string>;

TEST(Directives, APinnedPairIsSentAndTheRestIsLeftToThePolicy) {
  // All four pairs weigh the same.
  EXPECT_EQ(Told(Decide(Row().Build())),
            (Actions{"UiTxWj uav:0 worker:1 task:1", "UiTxWj uav:1 worker:0 task:0"}));
  const Situation situation = With(Row(), {Pin(0, 0, 1)});
  const Decision decision = Decide(situation);
  EXPECT_EQ(Told(decision),
            (Actions{"UiTxWj uav:0 worker:0 task:1", "UiTxWj uav:1 worker:1 task:0"}));
  EXPECT_TRUE(CheckActions(situation, decision.actions).empty());
  EXPECT_TRUE(decision.unkept.empty());
  EXPECT_NEAR(decision.bound, decision.weight, 1e-9);
}

TEST(Directives, OneWhoIsPinnedAloneGetsThePartnerOfTheHighestWeight) {
  SituationBuilder builder = Row();  // 0 of each class is some intervals further away
  builder.scenario().uavs[0].at = builder.scenario().workers[0].at = {2000, 15000};
  const auto sends = [&](const Directive& pin, const std::string& pair) {
    const Actions told = Told(Decide(With(builder, {pin})));
    return std::find(told.begin(), told.end(), pair) != told.end();
  };
  EXPECT_TRUE(sends(Pin(0, -1, 1), "UiTxWj uav:0 worker:1 task:1"));
  EXPECT_TRUE(sends(Pin(-1, 0, 1), "UiTxWj uav:1 worker:0 task:1"));
}

TEST(Directives, APinWaitsForWhoIsUnderWayAndKeepsTheTask) {
  Situation situation = With(Row(), {Pin(0, 1, 1)});
  situation.workers[1].busy_until_us = 5 * kMinuteUs;
  situation.workers[1].action = ActionKind::kWorkerToTask;
  const Directing directing = Direct(situation);
  EXPECT_EQ(directing.outcomes[0].state, State::kWaits);
  EXPECT_EQ(directing.outcomes[0].why, "worker:1 is under way");
  EXPECT_EQ(Told(Decide(situation)),
            (Actions{"UiTx uav:0 task:1", "UiTxWj uav:1 worker:0 task:0"}));
}

TEST(Directives, WhatCannotBeKeptIsSaidAndLeftToThePolicy) {
  SituationBuilder builder = Row();
  builder.scenario().uavs[0].range_m = 5e3;  // T1 takes 2 + 3 + 2.2 km
  const Decision decision = Decide(With(builder, {Pin(0, 1, 1)}));
  ASSERT_EQ(decision.unkept.size(), 1U);
  EXPECT_EQ(
      decision.unkept[0].find("order d (pin: uav:0 and worker:1 to task 1): constraint (6): "), 0U)
      << decision.unkept[0];
  EXPECT_EQ(Told(decision).size(), 2U);

  builder = Row();
  builder.scenario().workers[1].online_from_us = 20 * kMinuteUs;
  EXPECT_EQ(Direct(With(builder, {Pin(0, 1, 1)})).outcomes[0].why,
            "worker:1 has failed or is not online");
  builder = Row();
  builder.scenario().tasks[1].expires_us = kMinuteUs;  // worker:1 needs 200 s
  EXPECT_EQ(Direct(With(builder, {Pin(1, 1, 1)})).outcomes[0].why,
            "uav:1 cannot be there before it expires");
}

TEST(Directives, PinsOfOneAgentAreDoneInTheirOrder) {
  const Situation situation = With(Row(), {Pin(0, 0, 1), Pin(0, 1, 0)});
  const Directing directing = Direct(situation);
  EXPECT_EQ(directing.outcomes[0].state, State::kKept);
  EXPECT_EQ(directing.outcomes[1].state, State::kWaits);
  const Actions told = Told(Decide(situation));
  ASSERT_GE(told.size(), 2U);
  EXPECT_EQ(told[0], "WjTx worker:1 task:0");
  EXPECT_EQ(told[1], "UiTxWj uav:0 worker:0 task:1");
}

TEST(Directives, NobodyIsSentToWhatIsForbiddenByAnyPolicy) {
  Directive area = Make(Directive::Kind::kForbid, {-1, -1, -1});
  area.of_class = AgentKind::kWorker;
  area.area = std::make_shared<const Zone>(Zone{"", {CornersAround({4000, 5000}, 500)}});
  for (const PolicyInfo& policy : Policies()) {
    SCOPED_TRACE(policy.name);
    const Situation pair = With(Row(), {Make(Directive::Kind::kForbid, {0, -1, -1}, 0),
                                        Make(Directive::Kind::kForbid, {-1, 1, -1}, 1)});
    const Decision decision = Decide(pair, std::string(policy.name).c_str());
    EXPECT_TRUE(CheckActions(pair, decision.actions).empty());
    for (const Action& a : decision.actions) {
      EXPECT_FALSE(a.uav.value == 0 && a.task.value == 0) << ToString(a);
      EXPECT_FALSE(a.worker.value == 1 && a.task.value == 1) << ToString(a);
    }
    for (const Action& a : Decide(With(Row(), {area}), std::string(policy.name).c_str()).actions) {
      EXPECT_NE(a.task.value, 1) << ToString(a);
      EXPECT_FALSE(a.worker.valid() && Distance(a.to, {4000, 5000}) < 500) << ToString(a);
    }
  }
}

TEST(Directives, AUavIsChargedBeforeItDoesAnythingElse) {
  const Situation situation =
      With(Row(), {Pin(1, 1, 1), Make(Directive::Kind::kChargeNow, {1, -1, -1})});
  const Directing directing = Direct(situation);
  EXPECT_EQ(directing.outcomes[0].state, State::kWaits);
  EXPECT_EQ(directing.outcomes[1].state, State::kKept);
  EXPECT_EQ(Told(Decide(situation)).back(), "UiCyVk uav:1 vehicle:0 charge:0");
  // A full battery needs none.
  EXPECT_EQ(Direct(With(Row(), {Make(Directive::Kind::kChargeNow, {0, -1, -1})})).outcomes[0].state,
            State::kOver);
  // Without a vehicle it goes ahead.
  Situation waiting = With(Row(), {Make(Directive::Kind::kChargeNow, {1, -1, -1})});
  waiting.vehicles.clear();
  EXPECT_EQ(Told(Decide(waiting)).front(), "UiCy uav:1 charge:0");
}

TEST(Directives, OneWhoIsSentToAPlaceGoesThereAndStays) {
  Directive go = Make(Directive::Kind::kGoTo, {-1, 0, -1});
  go.place = {2000, 9000};
  Situation situation = With(Row(), {go});
  const Decision decision = Decide(situation);
  const auto sent = std::find_if(decision.actions.begin(), decision.actions.end(),
                                 [](const Action& a) { return a.kind == ActionKind::kGoTo; });
  ASSERT_NE(sent, decision.actions.end());
  EXPECT_EQ(sent->to, go.place);
  situation.workers[0].to = situation.workers[0].from = go.place;
  for (const Action& a : Decide(situation).actions) EXPECT_NE(a.worker.value, 0) << ToString(a);
}

/// Brute force on small situations. The pinned pair has the weight of the whole problem's graph; a
/// partner who was not named is the best there; what the policy adds is the best of the graph that
/// is left.
TEST(Directives, WithAPinTheDecisionIsTheBestThatIsLeft) {
  int pairs = 0, partners = 0;
  for (std::uint64_t seed = 1; seed <= 600; ++seed) {
    SCOPED_TRACE(seed);
    Situation situation = testing::RandomSituation(seed, {.times = seed % 2 == 0});
    Random random(seed, Stream::kTest, 8);
    auto site = std::make_shared<Site>(*situation.site);
    const auto below = [&](int n) {
      return static_cast<std::int32_t>(random.Below(static_cast<std::uint32_t>(n)));
    };
    const int named = below(3);  // both, the UAV, the worker
    const Directive pin = Pin(named == 2 ? -1 : below(3), named == 1 ? -1 : below(4), below(5));
    site->directives = {pin};
    situation.site = site;
    const testing::ReferenceGraph whole(situation);
    const Action* best = nullptr;  // of the nodes in order of ids: the first of equals
    for (const Action& a : whole.nodes()) {
      if (a.kind == ActionKind::kSense && IsSentBy(a, pin) &&
          (best == nullptr || a.weight > best->weight + 1e-9)) {
        best = &a;
      }
    }
    const Directing directing = Direct(situation);
    double expected = 0;
    for (const Action& a : directing.actions) {
      if (a.kind != ActionKind::kSense) continue;
      ASSERT_NE(best, nullptr) << ToString(a);
      EXPECT_EQ(ToString(a), ToString(*best));
      EXPECT_NEAR(a.weight, best->weight, 1e-9);
      ++(named == 0 ? pairs : partners);
    }
    for (const Action& a : directing.actions) expected += a.weight;
    expected += testing::ReferenceGraph(directing.rest).BestWeight();
    const Decision decision = Decide(situation);
    EXPECT_NEAR(decision.weight, expected, 1e-6);
    EXPECT_NEAR(decision.bound, expected, 1e-6);
  }
  EXPECT_GT(pairs, 20);
  EXPECT_GT(partners, 60);
}

/// The same with everything that may be directed: pins, forbidden pairs and areas, charges. A
/// forbidden pair is no node of the graph that is left; who is in a directive, and what is kept for
/// it, is not in it either.
TEST(Directives, WithWhatIsForbiddenTheDecisionIsTheBestThatIsLeft) {
  int forbidden = 0, sent = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(seed);
    Situation situation = testing::RandomSituation(seed, {.times = seed % 2 == 0});
    Random random(seed, Stream::kTest, 9);
    auto site = std::make_shared<Site>(*situation.site);
    const auto below = [&](int n) {
      return static_cast<std::int32_t>(random.Below(static_cast<std::uint32_t>(n)));
    };
    // The free optimum's own pairs are what to forbid: it has to change.
    for (const Action& a : Decide(situation).actions) {
      if (a.kind != ActionKind::kSense) continue;
      const bool uav = below(2) == 0;
      site->directives.push_back(Make(Directive::Kind::kForbid,
                                      {uav ? a.uav.value : -1, uav ? -1 : a.worker.value, -1},
                                      a.task.value));
      ++forbidden;
    }
    if (below(3) == 0) {
      Directive area = Make(Directive::Kind::kForbid, {-1, -1, -1});
      area.of_class = AgentKind::kWorker;
      area.area = std::make_shared<const Zone>(
          Zone{"", {CornersAround(site->tasks[static_cast<std::size_t>(below(5))].at, 500)}});
      site->directives.push_back(area);
    }
    if (below(2) == 0) site->directives.push_back(Pin(below(3), below(4), below(5)));
    if (below(2) == 0) {
      site->directives.push_back(Make(Directive::Kind::kChargeNow, {below(3), -1, -1}));
    }
    site->forbidden = ForbiddenPairs(site->directives);
    situation.site = site;
    const Directing directing = Direct(situation);
    double expected = testing::ReferenceGraph(directing.rest).BestWeight();
    for (const Action& a : directing.actions) {
      expected += a.weight;
      ++sent;
    }
    const Decision decision = Decide(situation);
    EXPECT_NEAR(decision.weight, expected, 1e-6);
    EXPECT_NEAR(decision.bound, expected, 1e-6);
    for (const ForbiddenPair& pair : site->forbidden) {
      for (const Action& a : decision.actions) {
        EXPECT_FALSE(a.task.value == pair.task && MemberOf(a, pair.kind) == pair.agent)
            << ToString(a);
      }
    }
  }
  EXPECT_GT(forbidden, 200);
  EXPECT_GT(sent, 100);
}

/// Of random directives in random situations: whatever they and the policy decide together may be
/// carried out, and a pin of two idle agents is kept whenever the pair alone could be sent.
TEST(Directives, OfAnySituationTheWholeDecisionMayBeCarriedOut) {
  int kept = 0, waits = 0, unkept = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(seed);
    Situation situation = testing::RandomSituation(seed, {.times = seed % 2 == 0});
    Random random(seed, Stream::kTest, 7);
    auto site = std::make_shared<Site>(*situation.site);
    const auto below = [&](int n) {
      return static_cast<std::int32_t>(random.Below(static_cast<std::uint32_t>(n)));
    };
    const int task = below(5);
    site->directives.push_back(Pin(below(3), below(4), task));
    site->directives.push_back(Pin(below(2) == 0 ? below(3) : -1, below(4), (task + 1) % 5));
    site->directives.push_back(Make(Directive::Kind::kForbid, {below(3), -1, -1}, below(5)));
    if (below(2) == 0) {
      site->directives.push_back(Make(Directive::Kind::kChargeNow, {below(3), -1, -1}));
    }
    Directive go = Make(Directive::Kind::kGoTo, {-1, below(4), -1});
    go.place = {random.Uniform(0, 12e3), random.Uniform(0, 12e3)};
    site->directives.push_back(go);
    site->forbidden = ForbiddenPairs(site->directives);
    situation.site = site;

    const Directing directing = Direct(situation);
    const char* policies[] = {"certified",     "mpq",  "horizon",
                              "rollout-steps", "kwta", "neighbours:reach=4"};
    const Decision decision = Decide(situation, policies[seed % std::size(policies)]);
    for (const Violation& violation : CheckActions(situation, decision.actions)) {
      ADD_FAILURE() << violation.message;
    }
    for (const DirectiveOutcome& outcome : directing.outcomes) {
      kept += outcome.state == State::kKept;
      waits += outcome.state == State::kWaits;
      unkept += outcome.state == State::kUnkept;
    }
    // The first pin: only a charge comes before it.
    const Directive& pin = site->directives[0];
    const AgentState& uav = situation.uavs[static_cast<std::size_t>(pin.agents.uavs)];
    const AgentState& worker = situation.workers[static_cast<std::size_t>(pin.agents.workers)];
    const bool charges = site->directives[3].kind == Directive::Kind::kChargeNow &&
                         site->directives[3].agents.uavs == pin.agents.uavs;
    const Action pair = MakeAction(*site, &uav, &worker, TaskId(pin.task), {});
    const bool sent =
        std::any_of(decision.actions.begin(), decision.actions.end(), [&](const Action& a) {
          return a.kind == ActionKind::kSense && a.uav == pair.uav && a.worker == pair.worker &&
                 a.task == pair.task;
        });
    if (!charges) {
      EXPECT_EQ(sent, CheckActions(situation, {&pair, 1}).empty());
    }
    for (const Action& a : decision.actions) {
      const bool held = directing.outcomes[0].state == State::kWaits;
      if (held && a.task.value == pin.task) {
        EXPECT_TRUE((!a.uav.valid() || a.uav == pair.uav) &&
                    (!a.worker.valid() || a.worker == pair.worker))
            << ToString(a);
      }
    }
  }
  EXPECT_GT(kept, 200);
  EXPECT_GT(waits, 100);
  EXPECT_GT(unkept, 100);
}

}  // namespace
}  // namespace muster::scheduler
