#include "tools/bound/upper_bound.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <string>

#include "base/check.h"
#include "base/random.h"
#include "model/generator.h"
#include "model/order.h"
#include "model/scenario_json.h"
#include "scheduler/policies/rollout/forward_model.h"
#include "scheduler/solver/candidates.h"
#include "simulation/simulator.h"
#include "tests/cases.h"
#include "tests/simulation/audited.h"
#include "tests/temporary_folder.h"
#include "tools/bound/bound_command.h"
#include "tools/bound/max_flow.h"
#include "tools/bound/schedule_bound.h"
#include "tools/record/run_record.h"

namespace muster::tools {
namespace {

using scheduler::Candidates;
using scheduler::ForwardModel;
using scheduler::Situation;

/// What the best list of commands gets done: all of them are tried on the rule book itself, every
/// agent known from the start.
class BruteForce {
 public:
  explicit BruteForce(const Scenario& scenario) : scenario_(scenario) {
    start_.site = std::make_shared<const scheduler::Site>(scenario);
    start_.task_status.assign(scenario.tasks.size(), TaskStatus::kOpen);
    start_.charging_load.assign(scenario.charging_points.size(), 0);
  }

  std::int64_t Best() {
    best_ = 0;
    From(start_);
    return best_;
  }

 private:
  /// The model forgets who is not online; who comes online now is put in as the world does it.
  void Newcomers(Situation* situation) const {
    const TimeUs now = situation->now_us;
    const TimeUs before = now - scenario_.rules.interval_us;
    const auto add = [&](AgentKind kind, std::vector<AgentState>* agents) {
      std::int32_t id = 0;
      for (const AgentSpec& spec : scenario_.agents(kind)) {
        const AgentState agent = StartOf(kind, id++, spec, *scenario_.ways);
        if (agent.online(now) && agent.online_from_us > before) agents->push_back(agent);
      }
      std::sort(agents->begin(), agents->end(),
                [](const AgentState& a, const AgentState& b) { return a.id < b.id; });
    };
    add(AgentKind::kUav, &situation->uavs);
    add(AgentKind::kWorker, &situation->workers);
    add(AgentKind::kVehicle, &situation->vehicles);
  }

  void From(Situation situation) {
    const auto done =
        std::count(situation.task_status.begin(), situation.task_status.end(), TaskStatus::kDone);
    best_ = std::max<std::int64_t>(best_, done);
    if (situation.now_us >= scenario_.rules.limit_us) return;
    Newcomers(&situation);
    const Candidates graph = scheduler::EnumerateCandidates(situation);
    std::vector<Action> actions;
    Choose(situation, graph, 0, &actions);
  }

  void Choose(const Situation& situation, const Candidates& graph, std::size_t next,
              std::vector<Action>* actions) {
    if (best_ == static_cast<std::int64_t>(scenario_.tasks.size())) return;
    if (next == graph.nodes.size()) {
      ForwardModel model(situation);
      model.Step(*actions);
      return From(model.situation());
    }
    const Action action = graph.ToAction(situation, graph.nodes[next]);
    const bool clash = std::any_of(actions->begin(), actions->end(), [&](const Action& other) {
      return (action.uav.valid() && action.uav == other.uav) ||
             (action.worker.valid() && action.worker == other.worker) ||
             (action.vehicle.valid() && action.vehicle == other.vehicle) ||
             (action.kind == ActionKind::kSense && other.kind == ActionKind::kSense &&
              action.task == other.task) ||
             (action.kind == ActionKind::kCharge && other.kind == ActionKind::kCharge &&
              action.charge == other.charge);
    });
    if (!clash && !IsStay(action.kind)) {
      actions->push_back(action);
      Choose(situation, graph, next + 1, actions);
      actions->pop_back();
    }
    Choose(situation, graph, next + 1, actions);
  }

  const Scenario& scenario_;
  Situation start_;
  std::int64_t best_ = 0;
};

GeneratorSettings Tiny(std::uint64_t seed) {
  Random random(seed, Stream::kPolicy);
  GeneratorSettings settings;
  settings.name = "tiny";
  settings.width_km = settings.height_km = 4 + 4 * static_cast<double>(seed % 3);
  settings.uavs = 1 + static_cast<int>(seed % 2);
  settings.workers = 2 - static_cast<int>(seed / 2 % 2);
  settings.vehicles = 1;
  settings.tasks = 3;
  settings.charging_points = 1;
  settings.rules.interval_us = (5 + 5 * static_cast<int>(seed % 3)) * kMinuteUs;
  settings.rules.limit_us = 3 * settings.rules.interval_us;
  settings.rules.availability = seed % 5 < 2 ? Availability::kOverrun : Availability::kStrict;
  settings.online_min = {6, ToMinutes(settings.rules.limit_us)};
  settings.task_cost_km = {1, 7};
  settings.full_range_km = 12 + 6 * random.Uniform();
  return settings;
}

TEST(UpperBound, HoldsAgainstEveryListOfCommands) {
  std::int64_t bounds = 0, bests = 0;
  int exact = 0, exact_schedules = 0, lower = 0;
  constexpr int kScenarios = 120;
  for (std::uint64_t seed = 0; seed < kScenarios; ++seed) {
    Scenario scenario = Generate(Tiny(seed), seed);
    // Five agents would be too many lists to try.
    if (scenario.uavs.size() + scenario.workers.size() == 4) scenario.vehicles.clear();
    const std::int64_t bound = UpperBound(scenario);
    const std::int64_t best = BruteForce(scenario).Best();
    EXPECT_GE(bound, best) << "seed " << seed;
    const double by_schedules = ScheduleBound(scenario, 100);
    EXPECT_GE(by_schedules + 1e-6, static_cast<double>(best)) << "seed " << seed;
    lower += std::floor(by_schedules + 1e-6) < static_cast<double>(bound);
    exact_schedules += std::floor(by_schedules + 1e-6) == static_cast<double>(best);
    bounds += bound;
    bests += best;
    exact += bound == best;
  }
  // A bound that says "all tasks" would pass the above and be worth nothing.
  EXPECT_LT(bounds, 3 * kScenarios * 3 / 4);
  EXPECT_GE(exact, kScenarios / 2) << bounds << " against " << bests;
  EXPECT_GE(exact_schedules, exact) << lower;
}

std::int64_t Done(const Scenario& scenario, const std::string& policy) {
  RunRecord record;
  Audited audited;
  Simulate(ScenarioToJson(scenario), policy, [&](const Packet& packet) {
    record.Add(packet);
    audited.Add(packet);
  });
  const auto& status = record.final_world()->task_status;
  return std::count(status.begin(), status.end(), static_cast<std::int8_t>(TaskStatus::kDone));
}

/// A hook that is open to the north, and a tower east of it, in a square of that width.
ScenarioAir HookAndTower(double width_m) {
  const auto corners = [width_m](std::vector<Point> shares) {
    for (Point& at : shares) at = {std::round(at.x_m * width_m), std::round(at.y_m * width_m)};
    return shares;
  };
  const auto zone = [](std::vector<Point> outline) {
    return PlannedZone{{"", {outline}}, 0, kNever};
  };
  ScenarioAir air;
  air.zones = {zone(corners({{0.1, 0.15},
                             {0.6, 0.15},
                             {0.6, 0.75},
                             {0.5, 0.75},
                             {0.5, 0.25},
                             {0.2, 0.25},
                             {0.2, 0.75},
                             {0.1, 0.75}})),
               zone(CornersAround({std::round(0.8 * width_m), std::round(0.6 * width_m)}, 400))};
  return air;
}

TEST(UpperBound, HoldsAgainstEveryListOfCommandsAroundZones) {
  std::int64_t bests = 0, bests_without = 0;
  std::map<std::string, std::int64_t> done;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Scenario scenario = Generate(Tiny(seed), seed);
    scenario.workers.resize(1);
    bests_without += BruteForce(scenario).Best();
    // Keeping apart takes time, so it is no better than the best without.
    ScenarioAir air = HookAndTower(scenario.width_m);
    if (seed % 2 == 0) air.separation.reset();
    UseAir(std::move(air), &scenario);
    const std::int64_t bound = UpperBound(scenario);
    Scenario with_zones = scenario;
    for (const PlannedZone& planned : scenario.air->zones) {
      const std::string order = R"({"order": "zone_add", )" + ZoneToJson(planned.zone) + "}";
      TakeInto(&with_zones, ParseOrder(order, "order"), 0);
    }
    const std::int64_t best = BruteForce(with_zones).Best();
    EXPECT_GE(bound, best) << "seed " << seed;
    EXPECT_GE(ScheduleBound(scenario, 100) + 1e-6, static_cast<double>(best)) << "seed " << seed;
    for (const char* policy : {"certified", "mpq", "horizon", "rollout-steps"}) {
      const std::int64_t by_policy = Done(scenario, policy);
      EXPECT_LE(by_policy, best) << policy << " seed " << seed;
      done[policy] += by_policy;
    }
    bests += best;
  }
  for (const auto& [policy, sum] : done) {
    EXPECT_GE(sum, bests / 2) << policy << ", that passes by doing nothing";
  }
  EXPECT_LT(bests, bests_without) << "the zones are in nobody's way";
}

TEST(UpperBound, HoldsForEveryPolicyUnderAllRulesAndDisturbances) {
  for (std::uint64_t seed = 1; seed <= Cases(12, 24); ++seed) {
    GeneratorSettings settings = PresetByName("Random_1");
    settings.width_km = settings.height_km = 4 + static_cast<double>(seed % 4) * 3;
    settings.uavs = 6;
    settings.workers = 7;
    settings.vehicles = 4;
    settings.tasks = 40;
    settings.charging_points = 4;
    settings.online_min = {15, 45};
    settings.task_cost_km = {1, 6};
    settings.rules.limit_us = 60 * kMinuteUs;
    settings.rules.interval_us = (seed % 2 == 0 ? 5 : 15) * kMinuteUs;
    settings.rules.availability = seed % 3 == 0 ? Availability::kOverrun : Availability::kStrict;
    settings.rules.start_on_meeting = seed % 4 < 2;
    settings.placement = seed % 5 == 0 ? Placement::kContinuous : Placement::kCellCentres;
    if (seed % 6 == 0) settings.disturbances.wind = {0.1, 0.4};
    if (seed % 6 == 1) settings.disturbances.match_failure = {0.05, 0.1};
    if (seed % 6 == 2) settings.disturbances.agent_failure = {0.05, 0.2};
    if (seed % 3 == 1) settings.arrivals.share = 0.5;
    const Scenario scenario = Generate(settings, seed);
    const std::int64_t bound = UpperBound(scenario);
    const double by_schedules = ScheduleBound(scenario, 20);
    for (const char* policy :
         {"mpq", "kwta", "horizon", "horizon-steps", "rollout", "greedy-nearest"}) {
      const std::int64_t done = Done(scenario, policy);
      EXPECT_LE(done, bound) << policy << " seed " << seed;
      EXPECT_LE(static_cast<double>(done), by_schedules + 1e-6) << policy << " seed " << seed;
    }
  }
}

/// One UAV (1 km/min) and one worker (0.5 km/min) at the origin of the map.
Scenario Pair(double worker_until_min) {
  Scenario scenario;
  scenario.name = "pair";
  scenario.width_m = scenario.height_m = 20e3;
  scenario.rules.interval_us = 10 * kMinuteUs;
  scenario.rules.limit_us = 30 * kMinuteUs;
  AgentSpec uav;
  uav.speed_m_s = 1000.0 / 60;
  uav.range_full_m = uav.range_m = 30e3;
  uav.online_until_us = 30 * kMinuteUs;
  scenario.uavs = {uav};
  AgentSpec worker;
  worker.speed_m_s = 500.0 / 60;
  worker.online_until_us = ToUs(worker_until_min * 60);
  scenario.workers = {worker};
  scenario.charging_points = {{{0, 0}, 1}};
  return scenario;
}

TEST(UpperBound, CountsTheDecisionsOfWhoIsThereShorter) {
  Scenario scenario = Pair(22);
  for (int x = 0; x < 5; ++x) scenario.tasks.push_back({{0, 0}, 3000});
  // The worker's decisions are at 0, 10 and 20 min; sensing takes 3 min and from 20 min on would
  // end after its time.
  EXPECT_EQ(UpperBound(scenario), 2);
  scenario.rules.availability = Availability::kOverrun;
  EXPECT_EQ(UpperBound(scenario), 3);
  // Sensing of 12 min takes two intervals: at 0 and 20 min, the latter beyond the limit.
  for (Task& task : scenario.tasks) task.cost_m = 12000;
  EXPECT_EQ(UpperBound(scenario), 1);
}

TEST(UpperBound, KnowsWhatNobodyReaches) {
  Scenario scenario = Pair(30);
  // 27 min of the worker's way and 3 of sensing are just possible, 28 and 3 are not.
  scenario.tasks = {{{13500, 0}, 3000}};
  EXPECT_EQ(UpperBound(scenario), 1);
  scenario.tasks = {{{14000, 0}, 3000}};
  EXPECT_EQ(UpperBound(scenario), 0);
  // On meeting, the worker need only come to the cell: 1.4 km less.
  scenario.rules.start_on_meeting = true;
  EXPECT_EQ(UpperBound(scenario), 1);
  // A full range does for the sensing and the way back.
  scenario.tasks = {{{3000, 0}, 3000}};
  scenario.uavs[0].range_full_m = scenario.uavs[0].range_m = 5999;
  EXPECT_EQ(UpperBound(scenario), 0);
  scenario.uavs[0].range_full_m = scenario.uavs[0].range_m = 6000;
  EXPECT_EQ(UpperBound(scenario), 1);
}

TEST(ScheduleBound, CountsWaysBetweenTasks) {
  Scenario scenario = Pair(30);
  // Either is done 13 min after the start, and from there the other is 10 km away: the worker takes
  // 20 min, and comes too late for both.
  scenario.tasks = {{{5000, 0}, 3000}, {{0, 5000}, 3000}};
  EXPECT_EQ(UpperBound(scenario), 2);
  EXPECT_NEAR(ScheduleBound(scenario, 100), 1, 1e-6);
  // A task that is closer to the first one: 3 km, and 6 min of the worker's.
  scenario.tasks[1].at = {5000, 3000};
  EXPECT_NEAR(ScheduleBound(scenario, 100), 2, 1e-6);
  // No round, no search.
  EXPECT_EQ(ScheduleBound(scenario, 0), 2);
}

TEST(ScheduleBound, CountsRangeAndCharging) {
  Scenario scenario = Pair(60);
  scenario.rules.limit_us = 60 * kMinuteUs;
  scenario.uavs[0].online_until_us = 60 * kMinuteUs;
  scenario.tasks = {{{1000, 0}, 3000}, {{1000, 0}, 3000}, {{1000, 0}, 3000}};
  // There, three times sensing, and back: 11 km.
  scenario.uavs[0].range_full_m = scenario.uavs[0].range_m = 11e3;
  EXPECT_NEAR(ScheduleBound(scenario, 100), 3, 1e-6);
  scenario.uavs[0].range_full_m = scenario.uavs[0].range_m = 10.9e3;
  EXPECT_EQ(UpperBound(scenario), 3);
  EXPECT_NEAR(ScheduleBound(scenario, 100), 2, 1e-6);
  // A vehicle at the charging point gives as much in six seconds.
  AgentSpec vehicle;
  vehicle.speed_m_s = 10;
  vehicle.charge_rate_m_s = 1000.0 / 60;
  vehicle.online_until_us = 60 * kMinuteUs;
  scenario.vehicles = {vehicle};
  EXPECT_NEAR(ScheduleBound(scenario, 100), 3, 1e-6);
  // It gives 60 m of range in an hour: 100 m are missing.
  scenario.vehicles[0].charge_rate_m_s = 1.0 / 60;
  EXPECT_NEAR(ScheduleBound(scenario, 100), 2, 1e-6);
  // It comes for the last ten minutes: too late to sense after it.
  scenario.vehicles[0].charge_rate_m_s = 1000.0 / 60;
  scenario.vehicles[0].online_from_us = 50 * kMinuteUs;
  EXPECT_NEAR(ScheduleBound(scenario, 100), 2, 1e-6);
}

TEST(ScheduleBound, KnowsWhenTasksAreReportedAndExpire) {
  Scenario scenario = Pair(30);
  scenario.tasks = {{{0, 0}, 3000}, {{0, 0}, 3000}};
  EXPECT_NEAR(ScheduleBound(scenario, 100), 2, 1e-6);
  // Known at the decisions at 20 min alone: one of them.
  scenario.tasks[0].reported_us = scenario.tasks[1].reported_us = 15 * kMinuteUs;
  EXPECT_NEAR(ScheduleBound(scenario, 100), 1, 1e-6);
  scenario.tasks[0].reported_us = scenario.tasks[1].reported_us = 21 * kMinuteUs;
  EXPECT_NEAR(ScheduleBound(scenario, 100), 0, 1e-6);
  // 10 km of the worker's way are 20 min.
  scenario.tasks = {{{10000, 0}, 3000}};
  scenario.tasks[0].expires_us = 21 * kMinuteUs;
  EXPECT_NEAR(ScheduleBound(scenario, 100), 1, 1e-6);
  scenario.tasks[0].expires_us = 15 * kMinuteUs;
  // A search ends where no lower whole number is left.
  EXPECT_LT(ScheduleBound(scenario, 100), 1);
}

/// Few agents, who have long ways between tasks.
Scenario FarApart() {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.uavs = 6;
  settings.workers = 8;
  settings.vehicles = 4;
  settings.tasks = 25;
  settings.rules.interval_us = 15 * kMinuteUs;
  return Generate(settings, 3);
}

TEST(ScheduleBound, FallsRoundByRoundAndIsTheSameAgain) {
  const Scenario scenario = FarApart();
  const auto bounds = [&] {
    std::vector<double> told;
    const double last = ScheduleBound(scenario, 200, [&](std::int64_t round, double bound) {
      EXPECT_EQ(round, static_cast<std::int64_t>(told.size()) + 1);
      told.push_back(bound);
    });
    EXPECT_EQ(told.back(), last);
    return told;
  };
  const std::vector<double> once = bounds();
  EXPECT_TRUE(std::is_sorted(once.rbegin(), once.rend()));
  EXPECT_LT(once.back(), static_cast<double>(UpperBound(scenario)));
  EXPECT_LT(once.size(), 200u) << "no more rounds than the whole number needs";
  EXPECT_EQ(bounds(), once);
}

TEST(MaxFlow, IsTheSmallestCut) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed, Stream::kPolicy);
    constexpr std::int32_t kNodes = 7;
    std::int32_t capacity[kNodes][kNodes] = {};
    MaxFlow flow(kNodes);
    for (std::int32_t a = 0; a < kNodes; ++a) {
      for (std::int32_t b = 0; b < kNodes; ++b) {
        if (a == b || random.Uniform() < 0.5) continue;
        capacity[a][b] = static_cast<std::int32_t>(random.Uniform(0, 6));
        flow.Arc(a, b, capacity[a][b]);
      }
    }
    std::int64_t smallest = 1000;
    for (int side = 0; side < 1 << kNodes; ++side) {
      if ((side & 1) == 0 || (side & 2) != 0) continue;  // node 0 is the source, 1 the sink
      std::int64_t cut = 0;
      for (std::int32_t a = 0; a < kNodes; ++a) {
        for (std::int32_t b = 0; b < kNodes; ++b) {
          if ((side >> a & 1) != 0 && (side >> b & 1) == 0) cut += capacity[a][b];
        }
      }
      smallest = std::min(smallest, cut);
    }
    EXPECT_EQ(flow.Solve(0, 1), smallest) << "seed " << seed;
  }
}

/// A run's scenario has room for what orders may add: that is no task.
TEST(BoundCommand, CountsNoRoomForOrders) {
  const TemporaryFolder folder;
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  AddRoom({1000, {}}, &scenario);
  const std::string file = folder.File("scenario.json");
  std::ofstream(file) << ScenarioToJson(scenario);
  const char* const arguments[] = {"muster bound", file.c_str()};
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(BoundCommand(2, arguments), 0);
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "at most 120 of 120 tasks (100.0 %)\n");
}

TEST(BoundCommand, SearchesForALowerBound) {
  const TemporaryFolder folder;
  Scenario scenario = FarApart();
  const auto bound = static_cast<int>(ScheduleBound(scenario, 100) + 1e-6);
  const std::string file = folder.File("scenario.json");
  std::ofstream(file) << ScenarioToJson(scenario);
  const char* const arguments[] = {"muster bound", file.c_str(), "--effort", "1"};
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(BoundCommand(4, arguments), 0);
  EXPECT_EQ(::testing::internal::GetCapturedStdout(),
            fmt::format("at most {} of 25 tasks ({:.1f} %)\n", bound, 4.0 * bound));
  scenario.rules.start_on_meeting = true;
  std::ofstream(file) << ScenarioToJson(scenario);
  EXPECT_THROW(BoundCommand(4, arguments), InputError);
}

}  // namespace
}  // namespace muster::tools
