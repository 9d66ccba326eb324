#include "scheduler/policies/registry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "base/check.h"
#include "scheduler/checker.h"
#include "tests/model/manhattan_ways.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::SituationBuilder;

TEST(Policy, UnknownNameNamesTheKnownOnes) {
  try {
    MakePolicy("mqp");
    FAIL();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("found mqp"), std::string::npos) << message;
    for (const PolicyInfo& info : Policies()) {
      EXPECT_NE(message.find(info.name), std::string::npos) << message;
    }
  }
}

TEST(Policy, ADeadlineIsAboveZeroAndAtMostAnHour) {
  for (const double good_ms : {0.001, 10.0, 3'600'000.0}) {
    EXPECT_NO_THROW(MakePolicy("certified", good_ms)) << good_ms;
  }
  for (const double bad_ms : {0.0, -1.0, 3'600'001.0, std::nan("")}) {
    EXPECT_THROW(MakePolicy("certified", bad_ms), InputError) << bad_ms;
  }
  EXPECT_THROW(MakePolicy("mpq", 10.0), InputError) << "cannot be cut short";
}

TEST(Policy, WhatIsExpectedIsPartOfItsName) {
  for (const char* good : {"rollout:expect=0", "rollout-steps:expect=12.5", "rollout:expect=1e5"}) {
    EXPECT_NO_THROW(MakePolicy(good)) << good;
  }
  for (const char* bad : {"rollout:expect=", "rollout:expect=-1", "rollout:expect=1x",
                          "rollout:expect=nan", "rollout:expect=inf", "rollout:expect=100001",
                          "rollout:expect=3:expect=3", "rollout:expects=3"}) {
    EXPECT_THROW(MakePolicy(bad), InputError) << bad;
  }
  EXPECT_THROW(MakePolicy("mpq:expect=3"), InputError) << "does not look so far ahead";
  EXPECT_EQ(BaseName("rollout:expect=3"), "rollout");
  EXPECT_EQ(BaseName("external:run --with:expect=3"), "external:run --with:expect=3");
}

TEST(Policy, EffortAndShiftsArePartOfItsName) {
  for (const char* good : {"rollout:effort=1", "rollout-steps:effort=1000000:shifts=1",
                           "rollout:shifts=0:expect=3:effort=2"}) {
    EXPECT_NO_THROW(MakePolicy(good)) << good;
  }
  for (const char* bad : {"rollout:effort=0", "rollout:effort=1.5", "rollout:effort=1000001",
                          "rollout:effort=", "rollout:shifts=2", "rollout:shifts=0.5",
                          "horizon:effort=2", "neighbours:shifts=1"}) {
    EXPECT_THROW(MakePolicy(bad), InputError) << bad;
  }
}

TEST(Policy, ReachAndLossesArePartOfItsName) {
  for (const char* good : {"neighbours", "neighbours:reach=0", "neighbours:reach=2.5:loss=0.1",
                           "neighbours:loss=1:reach=1000"}) {
    EXPECT_NO_THROW(MakePolicy(good)) << good;
  }
  for (const char* bad : {"neighbours:", "neighbours:reach", "neighbours:reach=",
                          "neighbours:reach=-1", "neighbours:reach=1001", "neighbours:loss=1.1",
                          "neighbours:reach=1:reach=2", "neighbours:reach=1:", "neighbours:range=3",
                          "neighbours:expect=3", "horizon:reach=3", "certified:loss=0.1"}) {
    EXPECT_THROW(MakePolicy(bad), InputError) << bad;
  }
  EXPECT_EQ(BaseName("neighbours:reach=2.5:loss=0.1"), "neighbours");
}

TEST(Policy, ExpectingNothingIsTheSamePolicy) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Situation situation = RandomSituation(seed, {6, 8, 4, 15, 3, 15, true});
    EXPECT_EQ(MakePolicy("rollout:expect=0")->Decide(situation).actions,
              MakePolicy("rollout")->Decide(situation).actions);
  }
}

TEST(Policy, WithoutTimesPrioritiesAndDueTimesChangeNothing) {
  int others = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Situation timed = RandomSituation(seed, {6, 8, 4, 15, 3, 15, true});
    Situation plain = timed;
    auto site = std::make_shared<Site>(*timed.site);
    for (Task& task : site->tasks) {
      task.priority = Priority::kNormal;
      task.due_us = kNever;  // expiry stays
    }
    plain.site = site;
    const auto decide = [](const char* policy, const Situation& situation) {
      return MakePolicy(policy)->Decide(situation).actions;
    };
    EXPECT_EQ(decide("horizon-without-times", timed), decide("horizon", plain)) << seed;
    others += decide("horizon", timed) != decide("horizon", plain);
  }
  EXPECT_GT(others, 2);
}

TEST(Policy, WithoutRoadsItPlansInStraightLinesAndSendsNobodyInVain) {
  const muster::testing::ManhattanWays manhattan;
  std::size_t kept = 0, dropped = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Situation straight = RandomSituation(seed, {6, 8, 4, 15, 3, 15, false});
    Situation bent = straight;
    auto site = std::make_shared<Site>(*straight.site);
    site->ways = {&manhattan, [](const Ways*) {}};
    bent.site = site;
    for (auto* agents : {&bent.uavs, &bent.workers, &bent.vehicles}) {
      for (AgentState& agent : *agents) agent.ways = &manhattan;
    }
    const auto planned = MakePolicy("horizon")->Decide(straight).actions;
    const auto sent = MakePolicy("horizon-without-roads")->Decide(bent).actions;
    EXPECT_TRUE(CheckActions(bent, sent).empty()) << seed;
    for (const Action& action : sent) {
      EXPECT_NE(std::find(planned.begin(), planned.end(), action), planned.end()) << seed;
    }
    kept += sent.size();
    dropped += planned.size() - sent.size();
  }
  EXPECT_GT(kept, 20u);
  EXPECT_GT(dropped, 0u);
}

/// What every policy must keep.
class EveryPolicy : public ::testing::TestWithParam<std::string> {};

void ExpectSound(const Situation& situation, const Decision& decision) {
  for (const Violation& violation : CheckActions(situation, decision.actions)) {
    ADD_FAILURE() << violation.message;
  }
  double weight = 0;
  for (const Action& action : decision.actions) weight += action.weight;
  EXPECT_NEAR(decision.weight, weight, 1e-9);
  if (!std::isnan(decision.bound)) {
    EXPECT_GE(decision.bound, decision.weight - 1e-9);
  }
}

TEST_P(EveryPolicy, PassesTheChecker) {
  const auto policy = MakePolicy(GetParam());
  std::size_t actions = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rules rules;
    if (seed % 3 == 1) rules.availability = Availability::kOverrun;
    const Situation situation = RandomSituation(seed, {6, 8, 5, 9, 3, 12}, rules);
    const Decision decision = policy->Decide(situation);
    ExpectSound(situation, decision);
    actions += decision.actions.size();
  }
  EXPECT_GT(actions, 100u);
}

TEST_P(EveryPolicy, IsAFunctionOfTheSituation) {
  const auto policy = MakePolicy(GetParam());
  std::vector<Decision> first;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    first.push_back(policy->Decide(RandomSituation(seed, {6, 8, 5, 9, 3, 12})));
  }
  for (std::uint64_t seed = 12; seed-- > 0;) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {6, 8, 5, 9, 3, 12});
    const Decision again = policy->Decide(situation);  // after other calls
    const Decision fresh = MakePolicy(GetParam())->Decide(situation);
    EXPECT_EQ(again.actions, first[seed].actions);
    EXPECT_EQ(fresh.actions, first[seed].actions);
    EXPECT_EQ(again.weight, first[seed].weight);
    EXPECT_EQ(fresh.candidates, first[seed].candidates);
  }
}

TEST_P(EveryPolicy, DecidesInDegenerateSituations) {
  const auto policy = MakePolicy(GetParam());
  const auto decide = [&](const SituationBuilder& builder) {
    const Situation situation = builder.Build();
    ExpectSound(situation, policy->Decide(situation));
  };
  decide(SituationBuilder());
  decide(SituationBuilder().Uav({0, 0}).Worker({0, 0}).Vehicle({0, 0}));
  decide(SituationBuilder().Task({0, 0}).Charge({0, 0}));
  decide(SituationBuilder().Uav({0, 0}, 0).Worker({0, 0}).Task({0, 0}).Charge({0, 0}));
  decide(SituationBuilder().Uav({0, 0}).Worker({0, 0}).Task({0, 0}));  // nowhere to charge
  decide(SituationBuilder().Vehicle({0, 0}).Worker({0, 0}).Task({1, 0}).Charge({0, 1}));
}

std::vector<std::string> PolicyNames() {
  std::vector<std::string> names;
  for (const PolicyInfo& info : Policies()) names.emplace_back(info.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(All, EveryPolicy, ::testing::ValuesIn(PolicyNames()), [](const auto& row) {
  std::string name = row.param;
  for (char& c : name) {
    if (c == '-') c = '_';
  }
  return name;
});

}  // namespace
}  // namespace muster::scheduler
