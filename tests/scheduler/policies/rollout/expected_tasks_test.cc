#include "scheduler/policies/rollout/expected_tasks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "scheduler/policies/rollout/forward_model.h"
#include "scheduler/policies/rollout/rollout.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::SituationBuilder;

/// One of two tasks is known, an hour into the mission.
Situation OneIsKnown() {
  SituationBuilder builder;
  builder.Uav({1000, 1000}).Worker({1000, 1000}).Charge({1000, 4000}).Decision(6);
  builder.Task({1000, 1000}, 500).Task({9000, 9000}, 900);
  Task& known = builder.scenario().tasks[0];
  known.priority = Priority::kHigh;
  known.reported_us = 10 * kMinuteUs;
  known.due_us = 30 * kMinuteUs;
  builder.scenario().tasks[1].reported_us = 70 * kMinuteUs;
  Situation situation = builder.Build();
  situation.task_status[1] = TaskStatus::kUnreported;
  return situation;
}

/// The same with further tasks in the scenario that nobody has reported.
Situation WithUnreported(Situation situation, int n) {
  auto site = std::make_shared<Site>(*situation.site);
  for (int i = 0; i < n; ++i) {
    Task task = site->tasks.front();
    task.at = {500.0 * i, 700.0};
    task.priority = Priority::kEmergency;
    task.reported_us = situation.now_us + kMinuteUs * (i + 1);
    site->tasks.push_back(task);
    site->task_to_charge_m.push_back(1000);
    situation.task_status.push_back(TaskStatus::kUnreported);
  }
  situation.site = site;
  return situation;
}

TEST(ExpectedTasks, AreLikeThoseThatAreKnownAndStillToBeReported) {
  const Situation situation = OneIsKnown();
  const Future expected = ExpectTasks(situation, 30, 0);
  EXPECT_EQ(expected.expected, 60u) << "two hours are left";
  const Site& site = *expected.situation.site;
  ASSERT_EQ(site.tasks.size(), 2 + expected.expected);
  ASSERT_EQ(site.task_to_charge_m.size(), site.tasks.size());
  ASSERT_EQ(expected.situation.task_status.size(), site.tasks.size());
  for (std::size_t x = 2; x < site.tasks.size(); ++x) {
    const Task& task = site.tasks[x];
    EXPECT_EQ(task.at, (Point{1000, 1000}));
    EXPECT_EQ(task.cost_m, 500);
    EXPECT_EQ(task.priority, Priority::kHigh);
    EXPECT_GT(task.reported_us, situation.now_us);
    EXPECT_LE(task.reported_us, situation.site->rules.limit_us);
    EXPECT_EQ(task.due_us - task.reported_us, 20 * kMinuteUs);
    EXPECT_EQ(task.expires_us, kNever);
    EXPECT_EQ(site.task_to_charge_m[x], 3000);
    EXPECT_EQ(expected.situation.task_status[x], TaskStatus::kUnreported);
  }
  EXPECT_EQ(situation.site->tasks.size(), 2u) << "the mission's own stay";
}

TEST(ExpectedTasks, ComeAtTheRateInTheMean) {
  double count = 0, early = 0;
  for (std::uint32_t future = 0; future < 400; ++future) {
    const Future expected = ExpectTasks(OneIsKnown(), 2.25, future);
    count += static_cast<double>(expected.expected);
    const auto& tasks = expected.situation.site->tasks;
    early += static_cast<double>(std::count_if(tasks.begin() + 2, tasks.end(), [](const Task& t) {
      return t.reported_us < 90 * kMinuteUs;
    }));
  }
  EXPECT_NEAR(count / 400, 4.5, 0.1);
  EXPECT_NEAR(early / count, 0.25, 0.04);
}

TEST(ExpectedTasks, AreDrawnByDecisionAndFutureAlone) {
  const auto times = [](const Situation& situation, std::uint32_t future) {
    std::vector<TimeUs> list;
    const Future expected = ExpectTasks(situation, 30, future);
    for (const Task& task : expected.situation.site->tasks) list.push_back(task.reported_us);
    return list;
  };
  const Situation situation = OneIsKnown();
  Situation later = situation;
  ++later.decision;
  EXPECT_EQ(times(situation, 0), times(situation, 0));
  EXPECT_NE(times(situation, 0), times(situation, 1));
  EXPECT_NE(times(situation, 0), times(later, 0));
}

TEST(ExpectedTasks, NothingIsExpectedOfNothing) {
  Situation situation = OneIsKnown();
  EXPECT_EQ(ExpectTasks(situation, 0, 0).expected, 0u);
  situation.now_us = situation.site->rules.limit_us;
  EXPECT_EQ(ExpectTasks(situation, 30, 0).expected, 0u);
  situation = OneIsKnown();
  situation.task_status[0] = TaskStatus::kUnreported;
  EXPECT_EQ(ExpectTasks(situation, 30, 0).expected, 0u) << "no task is known to be like";
}

TEST(ExpectedTasks, AreReportedInTheForecastAndNoOthers) {
  const Future expected = ExpectTasks(OneIsKnown(), 30, 0);
  ForwardModel model(expected);
  while (!model.over()) {
    model.Step({});
    const Situation& now = model.situation();
    EXPECT_EQ(now.task_status[1], TaskStatus::kUnreported) << "the scenario's own";
    for (std::size_t x = 2; x < now.task_status.size(); ++x) {
      EXPECT_EQ(now.task_status[x] == TaskStatus::kOpen,
                now.site->tasks[x].reported_us <= now.now_us);
    }
  }
}

class RolloutThatExpects : public ::testing::Test {
 protected:
  static std::vector<Action> Decide(const Situation& situation, double per_hour, int threads = 2) {
    RolloutSettings settings;
    settings.expect_per_hour = per_hour;
    settings.threads = threads;
    return RolloutPolicy(settings).Decide(situation).actions;
  }
  static Situation Draw(std::uint64_t seed) {
    return RandomSituation(seed, {6, 8, 4, 15, 3, 15, true});
  }
};

TEST_F(RolloutThatExpects, DecidesOtherwiseNowAndThen) {
  int others = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    others += Decide(Draw(seed), 40) != Decide(Draw(seed), 0);
  }
  EXPECT_GT(others, 2);
}

TEST_F(RolloutThatExpects, KnowsNothingOfWhatWillBeReported) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Situation situation = Draw(seed);
    EXPECT_EQ(Decide(WithUnreported(situation, 30), 40), Decide(situation, 40)) << "seed " << seed;
  }
}

TEST_F(RolloutThatExpects, AnswersDependNeitherOnThreadsNorOnEarlierCalls) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    EXPECT_EQ(Decide(Draw(seed), 40, 1), Decide(Draw(seed), 40)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace muster::scheduler
