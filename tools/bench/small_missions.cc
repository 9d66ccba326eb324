#include "tools/bench/small_missions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>

#include "base/random.h"
#include "lcmtypes/words.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tools/bench/sheet.h"
#include "tools/bench/statistics.h"
#include "tools/bound/schedule_bound.h"
#include "tools/bound/upper_bound.h"
#include "tools/explain/hindsight.h"
#include "tools/log/packet_source.h"

namespace muster::tools {
namespace {

constexpr std::array kSmallLimitsMin = {60, 90, 120};
constexpr std::array kSmallIntervalsMin = {5, 10, 15};
constexpr int kMostUavs = 8;
constexpr std::int64_t kSearchEffort = 20, kRounds = 3000;

/// The first that is drawn in which anything can be done.
Scenario DrawnSmallMission(std::uint64_t seed) {
  Random random(seed, Stream::kPolicy, 2, 8);
  const auto between = [&](int least, int most) {
    return least + static_cast<int>(random.Below(static_cast<std::uint32_t>(most - least + 1)));
  };
  for (std::uint64_t draw = 0;; ++draw) {
    GeneratorSettings settings = PresetByName("Random_1");
    settings.uavs = between(2, kMostUavs);
    settings.workers = between(std::max(1, settings.uavs - 2), settings.uavs + 2);
    settings.vehicles = between(1, 3);
    settings.tasks = between(3 * settings.uavs, 6 * settings.uavs);
    settings.charging_points = between(2, 6);
    settings.width_km = settings.height_km = between(8, 15);
    settings.online_min = {30, kUpToLimit};
    settings.rules.limit_us = kSmallLimitsMin[random.Below(kSmallLimitsMin.size())] * kMinuteUs;
    settings.rules.interval_us =
        kSmallIntervalsMin[random.Below(kSmallIntervalsMin.size())] * kMinuteUs;
    settings.rules.availability =
        random.Below(2) == 0 ? Availability::kStrict : Availability::kOverrun;
    Scenario scenario = Generate(settings, 1000 * draw + seed);
    if (UpperBound(scenario) > 0) return scenario;
  }
}

DecisionLog LogOf(const Scenario& scenario, const std::string& policy) {
  std::vector<Packet> packets;
  Simulate(TextOf(scenario), policy, [&](const Packet& packet) { packets.push_back(packet); });
  PacketSource source(packets);
  return ReadDecisionLog(&source);
}

std::int64_t DoneIn(const DecisionLog& log) {
  std::set<std::int32_t> done;
  for (const event_t& event : log.events) {
    if (event.kind == EventKind::kSensingDone) done.insert(event.task_id);
  }
  return static_cast<std::int64_t>(done.size());
}

std::int64_t BoundOf(const Scenario& scenario) {
  return std::min(UpperBound(scenario), WholeTasks(ScheduleBound(scenario, kRounds)));
}

}  // namespace

void RunSmallMissions(const BenchOptions& options,
                      const std::function<void(const SmallRow&)>& report) {
  for (const std::uint64_t seed : options.AllSeeds()) {
    const Scenario scenario = DrawnSmallMission(seed);
    SmallRow row;
    row.seed = seed;
    row.uavs = static_cast<int>(scenario.uavs.size());
    row.workers = static_cast<int>(scenario.workers.size());
    row.vehicles = static_cast<int>(scenario.vehicles.size());
    row.tasks = static_cast<int>(scenario.n_tasks());
    row.interval_min = static_cast<int>(scenario.rules.interval_us / kMinuteUs);
    row.limit_min = static_cast<int>(scenario.rules.limit_us / kMinuteUs);
    row.is_strict = scenario.rules.availability == Availability::kStrict;
    std::vector<SmallRow> rows;
    for (const std::string& policy : options.methods) {
      const DecisionLog log = LogOf(scenario, policy);
      row.policy = policy;
      row.done = DoneIn(log);
      row.best = std::max(row.best, row.done);
      rows.push_back(row);
      if (rows.size() < options.methods.size()) continue;
      const Hindsight hindsight = LookBack(log, policy, kSearchEffort);
      row.best = std::max(row.best, static_cast<std::int64_t>(hindsight.best.done));
    }
    row.bound = BoundOf(scenario);
    for (SmallRow& one : rows) {
      one.best = row.best;
      one.bound = row.bound;
      report(one);
    }
  }
}

std::string SmallMissionsLimits() {
  return fmt::format(
      "2 to {} UAVs, as many workers or up to two more or fewer, 1 to 3 vehicles, 3 to 6 tasks a "
      "UAV, 2 to 6 charging points, on a square of 8 to 15 km; agents online for 30 min and more; "
      "limit {} min; interval {} min; either mode; else as Random_1; drawn again where nothing "
      "can be done\n",
      kMostUavs, fmt::join(kSmallLimitsMin, ", "), fmt::join(kSmallIntervalsMin, ", "));
}

std::string SmallCsvHeader() {
  return "seed,uavs,workers,vehicles,tasks,interval_min,limit_min,availability,policy,done,best,"
         "bound\n";
}

std::string ToCsv(const SmallRow& row) {
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", row.seed, row.uavs, row.workers,
                     row.vehicles, row.tasks, row.interval_min, row.limit_min,
                     row.is_strict ? "strict" : "overrun", row.policy, row.done, row.best,
                     row.bound);
}

std::string SummaryOf(const std::vector<SmallRow>& rows) {
  const auto percent = [](std::int64_t part, std::int64_t of) {
    return of == 0 ? kNotKnown : 100 * static_cast<double>(part) / static_cast<double>(of);
  };
  Sheet sheet("policy|tasks done|% of the bound|% of the optimum|missions at the optimum");
  // Each policy has flown the same missions.
  std::int64_t missions = 0, proven = 0, best = 0, bound = 0;
  for (const auto& [policy, group] :
       GroupsOf(rows, [](const SmallRow& row) { return row.policy; })) {
    missions = static_cast<std::int64_t>(group.size());
    std::int64_t done = 0, done_proven = 0, optimum = 0, at_optimum = 0;
    proven = best = bound = 0;
    for (const SmallRow* row : group) {
      done += row->done;
      best += row->best;
      bound += row->bound;
      if (!row->is_proven()) continue;
      ++proven;
      done_proven += row->done;
      optimum += row->best;
      at_optimum += row->done == row->best ? 1 : 0;
    }
    sheet.Add(fmt::format("{}|{}|{}|{}|{}", policy, done, Shown("{:.1f}", percent(done, bound)),
                          Shown("{:.1f}", percent(done_proven, optimum)), at_optimum));
  }
  return fmt::format(
      "{}{} of {} missions: the best plan known is an optimum, as no plan does more; "
      "all best plans together: {} tasks, all bounds: {}\n",
      sheet.Text(), proven, missions, best, bound);
}

}  // namespace muster::tools
