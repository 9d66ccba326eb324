#include "tools/bench/hard_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "base/random.h"
#include "lcmtypes/bus/bus.h"
#include "model/scenario_json.h"
#include "scheduler/policies/certified/certified_policy.h"
#include "scheduler/policies/registry.h"
#include "scheduler/solver/nodes.h"
#include "simulation/simulator.h"
#include "tools/bench/general_solver.h"
#include "tools/bench/suites.h"
#include "tools/graph/situations.h"

namespace muster::tools {
namespace {

using scheduler::Situation;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kCbcSeconds = 120;
constexpr double kProven = 1e-9;  ///< gap, relative, that is rounding

GeneratorSettings LongOnline(int uavs, int workers, int vehicles, int tasks, double side_km) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.online_min = Always(180);
  settings.uavs = uavs;
  settings.workers = workers;
  settings.vehicles = vehicles;
  settings.tasks = tasks;
  settings.width_km = settings.height_km = side_km;
  return settings;
}

GeneratorSettings With(GeneratorSettings settings,
                       const std::function<void(GeneratorSettings*)>& change) {
  change(&settings);
  return settings;
}

void EqualSpeeds(GeneratorSettings* settings, double km_per_min) {
  settings->uav_speed_km_per_min = settings->worker_speed_km_per_min =
      settings->vehicle_speed_km_per_min = km_per_min;
}

HardRow Decide(const Situation& situation, const HardOptions& options, HardRow row) {
  scheduler::SolverLimits limits;
  limits.threads = options.threads;
  scheduler::CertifiedProfile profile;
  const double cpu = CpuSeconds();
  const auto start = std::chrono::steady_clock::now();
  const scheduler::Decision decision = scheduler::DecideCertified(situation, limits, &profile);
  row.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  row.cpu_s = CpuSeconds() - cpu;
  row.decision = situation.decision;
  row.nodes = decision.candidates;
  row.weight = decision.weight;
  row.bound = decision.bound;
  row.relaxation = profile.relaxation;
  row.cbc_relaxation = row.cbc_relaxation_s = row.cbc_optimum = row.cbc_optimum_s = kNone;
  row.others = kNone;
  return row;
}

void Ask(const Situation& situation, AskCbc ask, GeneralSolver* cbc, HardRow* row) {
  if (cbc == nullptr || ask == AskCbc::kNothing) return;
  const scheduler::ArcNodes graph = scheduler::ListNodes(situation);
  const auto shares = cbc->Heaviest(graph.nodes, graph.elements, true, kCbcSeconds);
  row->cbc_relaxation = shares.weight.value_or(kNone);
  row->cbc_relaxation_s = shares.cpu_s;
  if (ask != AskCbc::kOptimum) return;
  const auto whole = cbc->Heaviest(graph.nodes, graph.elements, false, kCbcSeconds);
  row->cbc_optimum = whole.weight.value_or(kNone);
  row->cbc_optimum_s = whole.cpu_s;
}

/// Draws of RandomSettings.
struct Limits {
  int low, high;
};
constexpr Limits kSideKm{5, 60}, kUavs{2, 150}, kWorkers{2, 120}, kVehicles{2, 60}, kTasks{5, 200},
    kCharges{1, 40};
constexpr std::int64_t kMostNodes = 1'000'000;

GeneratorSettings RandomSettings(std::uint64_t seed, Availability* availability) {
  Random random(seed, Stream::kPolicy, 1, 7);
  // Small and large numbers alike: uniform in the logarithm.
  const auto draw = [&](const Limits& limits) {
    return static_cast<int>(
        std::lround(std::exp(random.Uniform(std::log(limits.low), std::log(limits.high)))));
  };
  const auto one_of = [&](const auto&... values) {
    const std::array choices{values...};
    return choices[random.Below(static_cast<std::uint32_t>(choices.size()))];
  };
  GeneratorSettings settings = PresetByName("Random_1");
  settings.width_km = settings.height_km = draw(kSideKm);
  settings.uavs = draw(kUavs);
  settings.workers = draw(kWorkers);
  settings.vehicles = draw(kVehicles);
  settings.tasks = draw(kTasks);
  settings.charging_points = draw(kCharges);
  settings.online_min = Always(one_of(60.0, 90.0, 120.0, 180.0));
  settings.uav_speed_km_per_min = one_of(0.5, 1.0, 2.0);
  settings.worker_speed_km_per_min = one_of(0.25, 0.5, 1.0, 2.0);
  settings.vehicle_speed_km_per_min = one_of(0.5, 0.75, 1.0, 2.0);
  settings.full_range_km = one_of(15.0, 30.0, 60.0);
  settings.task_cost_km = one_of(Always(0), Always(3), DrawRange{1, 5});
  settings.placement = one_of(Placement::kCellCentres, Placement::kContinuous);
  settings.rules.ceil_to_minutes = random.Below(5) == 0;
  settings.capacity = one_of(std::optional(1), std::optional(3), std::optional<int>());
  *availability = random.Below(5) == 0 ? Availability::kOverrun : Availability::kStrict;
  return settings;
}

std::string Number(double value) { return std::isnan(value) ? "" : fmt::format("{:.9g}", value); }

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return kNone;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(
      std::lround(share * static_cast<double>(values.size() - 1)))];
}

std::string LineOf(const std::string& name, const std::vector<const HardRow*>& rows) {
  std::vector<double> ms, cbc_ms, ratio;
  double gap = 0, loss = kNone, difference = kNone, worst = 0;
  std::int64_t nodes = 0;
  std::size_t small = 0;
  for (const HardRow* row : rows) {
    ms.push_back(row->cpu_s * 1e3);
    worst = std::max(worst, row->cpu_s * 1e3);
    nodes = std::max(nodes, row->nodes);
    gap = std::max(gap, row->gap());
    small += row->gap() <= 1e-3;
    if (!std::isnan(row->cbc_relaxation)) {
      cbc_ms.push_back(row->cbc_relaxation_s * 1e3);
      ratio.push_back(row->cpu_s / row->cbc_relaxation_s);
    }
    // fmax: NaN is passed over.
    loss = std::fmax(loss, (row->cbc_optimum - row->weight) / row->cbc_optimum);
    difference = std::fmax(difference,
                           std::abs(row->relaxation - row->cbc_relaxation) / row->cbc_relaxation);
  }
  const auto share = [](double value) {
    return std::isnan(value) ? std::string("-") : fmt::format("{:.1g}", value);
  };
  const auto time = [](double value) {
    return std::isnan(value) ? std::string("-") : fmt::format("{:.2f}", value);
  };
  return fmt::format(
      "{:<14} {:>5} {:>8} {:>9.2f} {:>8.1f} {:>8.1g} {:>9.2f} {:>8} {:>8} {:>8} {:>7}\n", name,
      rows.size(), nodes, Quantile(ms, 0.5), worst, gap,
      100.0 * static_cast<double>(small) / static_cast<double>(rows.size()), share(loss),
      share(difference), time(Quantile(cbc_ms, 0.5)), time(Quantile(ratio, 0.5)));
}

}  // namespace

const std::vector<HardFamily>& HardFamilies() {
  static const std::vector<HardFamily> families = {
      {"equal-speeds",
       "--preset Random_1 --online-min 180 --workers 15 --worker-speed-km-per-min 1 "
       "--vehicle-speed-km-per-min 1",
       With(LongOnline(30, 15, 20, 120, 30), [](auto* s) { EqualSpeeds(s, 1); })},
      {"many-uavs", "--preset Random_1 --online-min 180 --uavs 120",
       LongOnline(120, 50, 20, 120, 30)},
      {"small-area", "--preset Random_1 --online-min 180 --tasks 30 --area 10x10 --workers 15",
       LongOnline(30, 15, 20, 30, 10)},
      {"few-partners", "--preset Random_1 --online-min 180 --workers 8 --vehicles 5",
       LongOnline(30, 8, 5, 120, 30)},
      {"few-sites",
       "--preset Random_1 --online-min 180 --uavs 60 --workers 80 --tasks 20 --charging-points 5",
       With(LongOnline(60, 80, 20, 20, 30), [](auto* s) { s->charging_points = 5; })},
      {"free-places",
       "--preset Random_1 --online-min 180 --uavs 60 --vehicles 10 --area 15x15 --capacity none",
       With(LongOnline(60, 50, 10, 120, 15), [](auto* s) { s->capacity = std::nullopt; })},
      {"few-uavs",
       "--preset Random_1 --online-min 180 --uavs 10 --workers 100 --uav-speed-km-per-min 2 "
       "--worker-speed-km-per-min 2 --vehicle-speed-km-per-min 2",
       With(LongOnline(10, 100, 20, 120, 30), [](auto* s) { EqualSpeeds(s, 2); })},
      {"minutes", "--preset Random_1 --online-min 180 --workers 15 --ceil-to-minutes",
       With(LongOnline(30, 15, 20, 120, 30), [](auto* s) { s->rules.ceil_to_minutes = true; })},
  };
  return families;
}

bool RunHard(const HardOptions& options, const std::function<void(const HardRow&)>& report) {
  const auto cbc = options.ask == AskCbc::kNothing ? nullptr : GeneralSolver::Load();
  for (const HardFamily& family : HardFamilies()) {
    for (int seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed) {
      SituationRecorder recorder;
      const Scenario scenario = Generate(family.settings, static_cast<std::uint64_t>(seed));
      Simulate(ScenarioToJson(scenario), "certified",
               [&](const Packet& packet) { recorder.Add(packet); });
      for (const Situation& situation : recorder.Situations()) {
        const std::int32_t d = situation.decision;
        if (d != 2 && d != 4 && d != 8 && d != 12) continue;
        HardRow row;
        row.family = family.name;
        row.seed = static_cast<std::uint64_t>(seed);
        row = Decide(situation, options, row);
        Ask(situation, options.ask, cbc.get(), &row);
        report(row);
      }
    }
  }
  return options.ask == AskCbc::kNothing || cbc != nullptr;
}

void RunRandomSettings(const HardOptions& options,
                       const std::function<void(const HardRow&)>& report) {
  for (int seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed) {
    HardRow row;
    row.family = "random";
    row.seed = static_cast<std::uint64_t>(seed);
    Availability availability;
    const GeneratorSettings settings = RandomSettings(row.seed, &availability);
    const Situation situation = MidMission(settings, row.seed, availability);
    row = Decide(situation, options, row);
    if (row.nodes > kMostNodes) continue;
    if (row.gap() > kProven) {
      for (const char* name : {"mpq", "ils", "kwta"}) {
        row.others = std::fmax(row.others, scheduler::MakePolicy(name)->Decide(situation).weight);
      }
    }
    report(row);
  }
}

std::string RandomSettingsLimits() {
  const auto range = [](const char* what, const Limits& limits) {
    return fmt::format("{} {} to {}", what, limits.low, limits.high);
  };
  return fmt::format(
      "uniform in the logarithm: {}, {}, {}, {}, {}, {}\n"
      "one of: 60, 90, 120, 180 min online; speeds .5, 1, 2 (UAVs), .25, .5, 1, 2 (workers), .5, "
      ".75, 1, 2 km/min (vehicles); range 15, 30, 60 km; cost 0, 3, 1:5 km; cells or any metre; 1, "
      "3 or any number of places; a fifth in minutes, a fifth in mode overrun; up to {} nodes\n",
      range("side km", kSideKm), range("UAVs", kUavs), range("workers", kWorkers),
      range("vehicles", kVehicles), range("tasks", kTasks), range("charging points", kCharges),
      kMostNodes);
}

std::string HardCsvHeader() {
  return "family,seed,decision,n,weight,bound,gap,relaxation,cpu_s,wall_s,cbc_relaxation,"
         "cbc_relaxation_s,cbc_optimum,cbc_optimum_s,others\n";
}

std::string ToCsv(const HardRow& row) {
  return fmt::format("{},{},{},{},{:.9f},{:.9f},{:.3g},{},{},{},{},{},{},{},{}\n", row.family,
                     row.seed, row.decision, row.nodes, row.weight, row.bound, row.gap(),
                     Number(row.relaxation), Number(row.cpu_s), Number(row.wall_s),
                     Number(row.cbc_relaxation), Number(row.cbc_relaxation_s),
                     Number(row.cbc_optimum), Number(row.cbc_optimum_s), Number(row.others));
}

std::string SummaryOf(const std::vector<HardRow>& rows) {
  std::string text =
      fmt::format("{:<14} {:>5} {:>8} {:>9} {:>8} {:>8} {:>9} {:>8} {:>8} {:>8} {:>7}\n", "family",
                  "runs", "nodes<=", "median_ms", "max_ms", "gap<=", "gap<=.1%", "loss<=", "LP_off",
                  "CBC_LP", "ours/LP");
  std::vector<std::pair<std::string, std::vector<const HardRow*>>> groups;
  std::vector<const HardRow*> all;
  std::size_t not_reached = 0, asked = 0, below = 0;
  for (const HardRow& row : rows) {
    if (groups.empty() || groups.back().first != row.family) groups.push_back({row.family, {}});
    groups.back().second.push_back(&row);
    all.push_back(&row);
    not_reached += std::isnan(row.relaxation);
    asked += !std::isnan(row.others);
    below += row.others > row.weight * (1 + kProven);
  }
  for (const auto& [name, of_group] : groups) text += LineOf(name, of_group);
  if (groups.size() > 1) text += LineOf("all", all);
  text += fmt::format(
      "{} of {} relaxations not reached; {} decisions not proven within 1e-9 compared with mpq, "
      "ils "
      "and kwta, {} below\n",
      not_reached, rows.size(), asked, below);
  for (const bool by_time : {true, false}) {
    const auto measure = [&](const HardRow* row) { return by_time ? row->cpu_s : row->gap(); };
    std::stable_sort(all.begin(), all.end(),
                     [&](auto* a, auto* b) { return measure(a) > measure(b); });
    text += by_time ? "slowest:" : "largest gaps:";
    for (std::size_t k = 0; k < std::min<std::size_t>(5, all.size()); ++k) {
      text += fmt::format(" {} seed {} decision {} ({} nodes, {:.0f} ms, {:.1g});", all[k]->family,
                          all[k]->seed, all[k]->decision, all[k]->nodes, all[k]->cpu_s * 1e3,
                          all[k]->gap());
    }
    text += '\n';
  }
  return text;
}

}  // namespace muster::tools
