// When drawn tasks are reported, due and gone, and how much they matter.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "model/generator.h"
#include "model/scenario_json.h"

namespace muster {
namespace {

GeneratorSettings Many() {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.tasks = 20'000;
  return settings;
}

TEST(TaskDraws, SteadyReportsAreUniformOverTheMission) {
  GeneratorSettings settings = Many();
  settings.arrivals = {.share = 1};
  std::array<int, 18> tens = {};
  for (const Task& task : Generate(settings, 1).tasks) {
    ASSERT_GE(task.reported_us, 0);
    ASSERT_LT(task.reported_us, settings.rules.limit_us);
    EXPECT_EQ(task.reported_us % kOnlineStepUs, 0);
    ++tens[static_cast<std::size_t>(task.reported_us / (10 * kMinuteUs))];
  }
  // 20,000 / 18 = 1111, standard deviation 32.
  for (const int count : tens) EXPECT_NEAR(count, 1111, 160);
}

TEST(TaskDraws, AShareIsKnownFromTheStart) {
  GeneratorSettings settings = Many();
  settings.arrivals = {.share = 0.3};
  const Scenario s = Generate(settings, 2);
  const auto known = std::count_if(s.tasks.begin(), s.tasks.end(),
                                   [](const Task& task) { return task.reported_us == 0; });
  EXPECT_NEAR(static_cast<double>(known), 14'000, 330);  // standard deviation 65
}

TEST(TaskDraws, BurstsAreShort) {
  GeneratorSettings settings = Many();
  settings.tasks = 3000;
  settings.arrivals = {.share = 1, .bursts = 3};
  // No report is farther than a burst's length from the first one of a burst, and there are three.
  std::set<TimeUs> reports;
  for (const Task& task : Generate(settings, 4).tasks) {
    reports.insert(task.reported_us);
    EXPECT_LT(task.reported_us, settings.rules.limit_us);
  }
  int bursts = 0;
  while (!reports.empty()) {
    ++bursts;
    reports.erase(reports.begin(), reports.lower_bound(*reports.begin() + kBurstUs));
  }
  EXPECT_LE(bursts, 3);
  EXPECT_GE(bursts, 1);

  settings.rules.limit_us = settings.rules.interval_us = kMinuteUs;  // shorter than a burst
  settings.online_min = Always(1);
  for (const Task& task : Generate(settings, 4).tasks) EXPECT_LT(task.reported_us, kMinuteUs);
}

TEST(TaskDraws, PrioritiesHaveTheirShares) {
  GeneratorSettings settings = Many();
  settings.priority_shares = {2, 0, 5, 3};
  std::array<int, kPriorities> counts = {};
  for (const Task& task : Generate(settings, 1).tasks) {
    ++counts[static_cast<std::size_t>(task.priority)];
  }
  EXPECT_NEAR(counts[0], 4000, 300);
  EXPECT_EQ(counts[1], 0);
  EXPECT_NEAR(counts[2], 10'000, 360);
  EXPECT_NEAR(counts[3], 6000, 330);
}

TEST(TaskDraws, DueAndExpiryCountFromTheReportByPriority) {
  GeneratorSettings settings = Many();
  settings.tasks = 2000;
  settings.arrivals = {.share = 0.5};
  settings.priority_shares = {1, 1, 1, 1};
  settings.due_min = {std::nullopt, Always(60), DrawRange{20, 40}, Always(10)};
  settings.expires_min = {Always(90), std::nullopt, DrawRange{30, 50}, Always(5)};
  for (const Task& task : Generate(settings, 1).tasks) {
    const TimeUs from_us = task.reported_us;
    switch (task.priority) {
      case Priority::kLow:
        EXPECT_EQ(task.due_us, kNever);
        EXPECT_EQ(task.expires_us, from_us + 90 * kMinuteUs);
        break;
      case Priority::kNormal:
        EXPECT_EQ(task.due_us, from_us + 60 * kMinuteUs);
        EXPECT_EQ(task.expires_us, kNever);
        break;
      case Priority::kHigh:
        EXPECT_GE(task.due_us, from_us + 20 * kMinuteUs);
        EXPECT_LE(task.due_us, from_us + 40 * kMinuteUs);
        EXPECT_GE(task.expires_us, std::max(task.due_us, from_us + 30 * kMinuteUs));
        EXPECT_LE(task.expires_us, from_us + 50 * kMinuteUs);
        break;
      case Priority::kEmergency:  // gone before it would be due
        EXPECT_EQ(task.due_us, from_us + 5 * kMinuteUs);
        EXPECT_EQ(task.expires_us, task.due_us);
        break;
    }
  }
}

TEST(TaskDraws, OneMoreDrawLeavesAllOthersAsTheyWere) {
  GeneratorSettings settings = PresetByName("Random_20");
  const Scenario plain = Generate(settings, 5);
  settings.arrivals = {.share = 0.8, .bursts = 4};
  const Scenario reported = Generate(settings, 5);
  settings.priority_shares = {1, 6, 2, 1};
  const Scenario urgent = Generate(settings, 5);
  settings.due_min.fill(DrawRange{20, 60});
  const Scenario due = Generate(settings, 5);
  settings.expires_min.fill(DrawRange{60, 90});
  const Scenario all = Generate(settings, 5);
  for (std::size_t i = 0; i < plain.tasks.size(); ++i) {
    EXPECT_EQ(all.tasks[i].at, plain.tasks[i].at);
    EXPECT_EQ(all.tasks[i].cost_m, plain.tasks[i].cost_m);
    EXPECT_EQ(all.tasks[i].reported_us, reported.tasks[i].reported_us);
    EXPECT_EQ(all.tasks[i].priority, urgent.tasks[i].priority);
    EXPECT_EQ(all.tasks[i].due_us, due.tasks[i].due_us);
  }
  Scenario without = all;
  for (Task& task : without.tasks) task = {task.at, task.cost_m};
  EXPECT_EQ(ScenarioToJson(without), ScenarioToJson(plain));
}

}  // namespace
}  // namespace muster
