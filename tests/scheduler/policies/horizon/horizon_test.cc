#include "scheduler/policies/horizon/horizon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "scheduler/checker.h"
#include "scheduler/policies/horizon/matching.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::SituationBuilder;

std::vector<std::string> Decide(const Situation& situation, const HorizonSettings& settings = {}) {
  const Decision decision = HorizonPolicy(settings).Decide(situation);
  for (const Violation& violation : CheckActions(situation, decision.actions)) {
    ADD_FAILURE() << violation.message;
  }
  std::vector<std::string> actions;
  for (const Action& action : decision.actions) actions.push_back(ToString(action));
  return actions;
}
using Actions = std::vector<std::string>;

/// Under way to where it stands, free at `until_us`.
void Occupy(AgentState* agent, TimeUs until_us) {
  agent->arrive_us = agent->busy_until_us = until_us;
  agent->action = ActionKind::kGoTo;
}

// UAVs go 6 km an interval, workers 3 km.
TEST(Horizon, SensingCountsAsTime) {
  const Situation situation = SituationBuilder()
                                  .Uav({1000, 1000})
                                  .Worker({6500, 1000})
                                  .Worker({1000, 6900})
                                  .Task({6500, 1000}, 3000)  // 550 s and 300 s: two intervals
                                  .Task({1000, 6900}, 100)   // 590 s and 10 s: one
                                  .Charge({1000, 1000})
                                  .Build();
  HorizonSettings settings;
  settings.chains = false;
  settings.send_ahead = false;
  EXPECT_EQ(Decide(situation, settings), Actions{"UiTxWj uav:0 worker:1 task:1"});
  settings.true_duration = false;
  EXPECT_EQ(Decide(situation, settings), Actions{"UiTxWj uav:0 worker:0 task:0"});
}

TEST(Horizon, AnIdleUavGoesToMeetAWorkerThatIsFreeSoon) {
  Situation situation = SituationBuilder()
                            .Uav({5000, 1000})
                            .Worker({10000, 1000})   // busy now, beside the task
                            .Worker({10000, 13000})  // idle, 2400 s away
                            .Task({10000, 1000})     // 500 s from the UAV
                            .Charge({10000, 1000})
                            .Build();
  Occupy(&situation.workers[0], 100 * kSecondUs);
  HorizonSettings settings;
  settings.send_ahead = false;
  EXPECT_EQ(Decide(situation, settings), Actions{"UiTx uav:0 task:0"});
  settings.meet_ahead = false;
  EXPECT_EQ(Decide(situation, settings), Actions{});
  settings.soon_idle = false;
  EXPECT_EQ(Decide(situation, settings), Actions{"UiTxWj uav:0 worker:1 task:0"});
}

TEST(Horizon, NobodyGoesAheadWhenThatMakesThePairMeetLater) {
  // The UAV would arrive after 700 s and be free at 1200 s only; the worker at 600 s, 700 s from
  // the task. Together they leave at 600 s and meet at 1300 s, else at 1900 s.
  Situation situation = SituationBuilder()
                            .Uav({3000, 1000})
                            .Worker({10000, 4500})
                            .Task({10000, 1000})
                            .Charge({10000, 1000})
                            .Build();
  Occupy(&situation.workers[0], 100 * kSecondUs);
  EXPECT_EQ(Decide(situation), Actions{});
}

TEST(Horizon, AnUnmatchedWorkerGoesWhereItIsNeededNext) {
  const Situation situation = SituationBuilder()
                                  .Uav({1000, 1000})
                                  .Worker({1000, 2000})
                                  .Worker({1000, 11000})
                                  .Task({1000, 2000}, 500)
                                  .Task({1000, 7000}, 500)
                                  .Charge({1000, 1000})
                                  .Build();
  const Actions both = {"WjTx worker:1 task:1", "UiTxWj uav:0 worker:0 task:0"};
  EXPECT_EQ(Decide(situation), both);
  HorizonSettings settings;
  settings.send_ahead = false;
  EXPECT_EQ(Decide(situation, settings), Actions{both[1]});
}

TEST(Horizon, ChargingIsWorthTheTasksThatItEnables) {
  const auto build = [](double range_m, double task_minutes_left) {
    SituationBuilder builder;
    builder.Uav({1000, 1000}, range_m).Worker({1000, 3000}).Vehicle({1000, 1500});
    builder.Task({1000, 3000}, 1000).Charge({1000, 1000});
    builder.scenario().width_m = builder.scenario().height_m = 4000;
    builder.scenario().uavs[0].online_until_us = ToUs(task_minutes_left * 60);
    return builder.Build();
  };
  HorizonSettings settings;
  settings.send_ahead = false;
  const Actions charge = {"UiCyVk uav:0 vehicle:0 charge:0"};
  const Actions sense = {"UiTxWj uav:0 worker:0 task:0"};
  // The task takes 2 km, 1 km and 2 km back: 4 km do not do.
  EXPECT_EQ(Decide(build(4000, 180), settings), charge);
  EXPECT_EQ(Decide(build(30000, 180), settings), sense);
  // 9 min: charging ends in time, but no task can follow.
  EXPECT_EQ(Decide(build(4000, 9), settings), Actions{});
  settings.charge_by_use = false;
  EXPECT_EQ(Decide(build(4000, 9), settings), charge);
}

TEST(Horizon, TheNearerTaskWinsAmongEqualNumbersOfDecisions) {
  // Every end is within the first interval.
  const Situation situation = SituationBuilder()
                                  .Uav({1000, 1000})
                                  .Worker({3000, 1000})
                                  .Task({5000, 1000}, 500)
                                  .Task({3000, 1000}, 500)
                                  .Charge({1000, 1000})
                                  .Build();
  EXPECT_EQ(Decide(situation), Actions{"UiTxWj uav:0 worker:0 task:1"});
}

TEST(Horizon, ATaskWithAnotherOneCloseByWinsAgainstANearerOne) {
  // The pairs differ by 100 m of way. From task 0 the next task ends after three decisions, from
  // task 1 after two.
  const Situation situation = SituationBuilder()
                                  .Uav({10000, 10000})
                                  .Worker({7100, 10000})
                                  .Worker({13000, 10000})
                                  .Task({7100, 10000}, 500)
                                  .Task({13000, 10000}, 500)
                                  .Task({13500, 10000}, 500)
                                  .Charge({10000, 10000})
                                  .Build();
  HorizonSettings settings;
  settings.send_ahead = false;
  EXPECT_EQ(Decide(situation, settings), Actions{"UiTxWj uav:0 worker:1 task:1"});
  settings.chains = false;
  EXPECT_EQ(Decide(situation, settings), Actions{"UiTxWj uav:0 worker:0 task:0"});
}

TEST(Horizon, ANextTaskCountsOnlyWithinRangeAndTime) {
  const auto build = [](double range_m, TimeUs until_us) {
    Situation situation = SituationBuilder()
                              .Uav({10000, 10000}, range_m)
                              .Worker({7100, 10000})
                              .Worker({13000, 10000})
                              .Task({7100, 10000}, 500)
                              .Task({13000, 10000}, 500)
                              .Task({13500, 10000}, 500)
                              .Charge({10000, 10000})
                              .Build();
    situation.uavs[0].online_until_us = until_us;
    return situation;
  };
  HorizonSettings settings;
  settings.send_ahead = false;
  const Actions near{"UiTxWj uav:0 worker:0 task:0"}, chained{"UiTxWj uav:0 worker:1 task:1"};
  // Task 1, 500 m on to task 2, its sensing, 3500 m to charge: 3000 + 500 + 500 + 500 + 3500.
  EXPECT_EQ(Decide(build(8000, 9000 * kSecondUs), settings), chained);
  EXPECT_EQ(Decide(build(7999, 9000 * kSecondUs), settings), near);
  // Sensing task 2 would end at 600 + 50 + 50 s.
  EXPECT_EQ(Decide(build(8000, 700 * kSecondUs), settings), chained);
  EXPECT_EQ(Decide(build(8000, 700 * kSecondUs - 1), settings), near);
}

TEST(Horizon, StepsBringFarPairsNearerWithoutBindingThem) {
  const Situation situation = SituationBuilder()
                                  .Uav({1000, 1000})
                                  .Worker({10000, 11000})
                                  .Task({10000, 1000}, 500)  // 9 km and 10 km away
                                  .Charge({1000, 1000})
                                  .Build();
  EXPECT_EQ(Decide(situation), Actions{"UiTxWj uav:0 worker:0 task:0"});
  HorizonSettings settings;
  settings.steps = true;
  const Decision decision = HorizonPolicy(settings).Decide(situation);
  EXPECT_TRUE(CheckActions(situation, decision.actions).empty());
  ASSERT_EQ(decision.actions.size(), 2u);
  for (const Action& action : decision.actions) {
    EXPECT_EQ(action.kind, ActionKind::kGoTo);
    const bool uav = action.uav.valid();
    const Point from = uav ? Point{1000, 1000} : Point{10000, 11000};
    const Point to = uav ? Point{7000, 1000} : Point{10000, 8000};
    EXPECT_NEAR(Distance(action.to, to), 0, 1e-3);
    EXPECT_LE(TravelUs(Distance(from, action.to), uav ? 10 : 5), 600 * kSecondUs);
  }
}

/// Worth of the best next task close by, as docs/reference/scheduling.md defines it; 0 when there
/// is none.
double WorthOfNext(const Situation& situation, const Participant& uav, std::size_t task,
                   const HorizonSettings& settings) {
  const Site& site = *situation.site;
  const Task& here = site.tasks[task];
  const double way = Distance(uav.at, here.at), speed = uav.agent->speed_m_s;
  const double range = uav.range_m - way - here.cost_m;
  const double interval = static_cast<double>(site.rules.interval_us);
  const double free =
      static_cast<double>(uav.ready_us + TravelUs(way, speed) + TravelUs(here.cost_m, speed));
  const auto open =
      std::count(situation.task_status.begin(), situation.task_status.end(), TaskStatus::kOpen);
  double fewest = 1e9;
  for (std::size_t y = 0; y < site.tasks.size(); ++y) {
    const double on = Distance(here.at, site.tasks[y].at);
    if (y == task || situation.task_status[y] != TaskStatus::kOpen) continue;
    if (on > std::sqrt(site.width_m * site.height_m / static_cast<double>(open))) continue;
    if (on + site.tasks[y].cost_m + site.task_to_charge_m[y] > range) continue;
    const double end =
        std::ceil(free / interval) * interval +
        static_cast<double>(TravelUs(on, speed) + TravelUs(site.tasks[y].cost_m, speed));
    if (end > static_cast<double>(uav.latest_us)) continue;
    fewest = std::min(fewest, std::ceil((end - static_cast<double>(situation.now_us)) / interval));
  }
  return settings.chain_worth / fewest;
}

/// Worth of sensing as docs/reference/scheduling.md defines it; negative when it cannot be.
double WorthOfSensing(const Situation& situation, const Participant& uav, const Participant& worker,
                      std::size_t task, const HorizonSettings& settings) {
  const Site& site = *situation.site;
  const double way = Distance(uav.at, site.tasks[task].at);
  const double worker_way = Distance(worker.at, site.tasks[task].at);
  if (way + site.tasks[task].cost_m + site.task_to_charge_m[task] > uav.range_m) return -1;
  const TimeUs worker_travel = TravelUs(worker_way, worker.agent->speed_m_s);
  const TimeUs end = std::max(uav.ready_us + TravelUs(way, uav.agent->speed_m_s),
                              worker.ready_us + worker_travel) +
                     TravelUs(site.tasks[task].cost_m, uav.agent->speed_m_s);
  if (end > std::min(uav.latest_us, worker.latest_us)) return -1;
  const double interval = static_cast<double>(site.rules.interval_us);
  const double took = static_cast<double>(end - situation.now_us) / interval;
  const double n = std::max(1.0, std::ceil(took));
  return 1 / n + WorthOfNext(situation, uav, task, settings) -
         settings.finish_weight * (took - (n - 1)) * (1 / n - 1 / (n + 1)) -
         settings.uav_way * way / uav.agent->range_full_m -
         settings.partner_way * static_cast<double>(worker_travel) / interval -
         (1 - settings.tentative) * ((uav.idle ? 0 : 1) + (worker.idle ? 0 : 1));
}

/// Every set of pairs, one UAV after the other.
double HeaviestByTrial(const Situation& situation, const Participants& participants,
                       std::size_t uav, std::uint32_t workers, std::uint32_t tasks,
                       const HorizonSettings& settings) {
  if (uav == participants.uavs.size()) return 0;
  double best = HeaviestByTrial(situation, participants, uav + 1, workers, tasks, settings);
  for (std::size_t w = 0; w < participants.workers.size(); ++w) {
    for (std::size_t x = 0; x < situation.task_status.size(); ++x) {
      if ((workers >> w & 1) != 0 || (tasks >> x & 1) != 0) continue;
      if (situation.task_status[x] != TaskStatus::kOpen) continue;
      const double worth =
          WorthOfSensing(situation, participants.uavs[uav], participants.workers[w], x, settings);
      if (worth <= 0) continue;
      best = std::max(best, worth + HeaviestByTrial(situation, participants, uav + 1,
                                                    workers | 1u << w, tasks | 1u << x, settings));
    }
  }
  return best;
}

TEST(HeaviestPairs, NoSetOfPairsIsHeavier) {
  std::size_t matched = 0, not_idle = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {3, 4, 0, 5, 1, 12});
    const HorizonSettings settings;
    const Participants participants = ParticipantsOf(situation, settings);
    const std::vector<Match> matches =
        HeaviestPairs(situation, participants, OpenSitesOf(situation), settings);
    double weight = 0;
    for (const Match& match : matches) {
      const Participant& uav = participants.uavs[static_cast<std::size_t>(match.uav)];
      const Participant& worker = participants.workers[static_cast<std::size_t>(match.partner)];
      weight +=
          WorthOfSensing(situation, uav, worker, static_cast<std::size_t>(match.site), settings);
      if (!uav.idle || !worker.idle) ++not_idle;
    }
    matched += matches.size();
    // Worths are rounded to 1 / 512 of themselves.
    EXPECT_NEAR(weight, HeaviestByTrial(situation, participants, 0, 0, 0, settings),
                0.005 * static_cast<double>(matches.size()));
  }
  EXPECT_GT(matched, 60u);
  EXPECT_GT(not_idle, 10u);
}

}  // namespace
}  // namespace muster::scheduler
