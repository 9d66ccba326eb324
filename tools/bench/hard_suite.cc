#include "tools/bench/hard_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "base/random.h"
#include "scheduler/policies/certified/certified_policy.h"
#include "scheduler/policies/registry.h"
#include "scheduler/solver/candidates.h"
#include "tools/bench/general_solver.h"
#include "tools/bench/sheet.h"
#include "tools/bench/statistics.h"

namespace muster::tools {
namespace {

using scheduler::Situation;
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

/// All agents are free at once and most tasks are within an interval or two.
HardFamily AnHour(int scale) {
  HardFamily family{fmt::format("hour-x{}", scale),
                    fmt::format("--preset Random_29 --scale {} --limit 60", scale),
                    Scaled(PresetByName("Random_29"), scale)};
  family.settings.rules.limit_us = 60 * kMinuteUs;
  return family;
}

HardRow Decide(const Situation& situation, const BenchOptions& options, HardRow row) {
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
  row.cbc_relaxation = row.cbc_relaxation_s = row.cbc_optimum = row.cbc_optimum_s = kNotKnown;
  row.others = kNotKnown;
  return row;
}

constexpr std::int64_t kMostNodes = 1'000'000;  ///< that CBC is asked about, or that are drawn

void Ask(const Situation& situation, AskCbc ask, GeneralSolver* cbc, HardRow* row) {
  if (cbc == nullptr || ask == AskCbc::kNothing || row->nodes > kMostNodes) return;
  const scheduler::Candidates graph = scheduler::EnumerateCandidates(situation);
  const auto shares = cbc->Heaviest(graph.nodes, graph.elements, true, kCbcSeconds);
  row->cbc_relaxation = shares.weight.value_or(kNotKnown);
  row->cbc_relaxation_s = shares.cpu_s;
  if (ask != AskCbc::kOptimum) return;
  const auto whole = cbc->Heaviest(graph.nodes, graph.elements, false, kCbcSeconds);
  row->cbc_optimum = whole.weight.value_or(kNotKnown);
  row->cbc_optimum_s = whole.cpu_s;
}

/// Draws of RandomSettings.
struct Limits {
  int low, high;
};
constexpr Limits kSideKm{5, 60}, kUavs{2, 150}, kWorkers{2, 120}, kVehicles{2, 60}, kTasks{5, 200},
    kCharges{1, 40};

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

using Rows = std::vector<const HardRow*>;

std::string LineOf(const std::string& name, const Rows& rows) {
  const auto cpu_ms = ValuesOf(rows, [](const HardRow& row) { return row.cpu_s * 1e3; });
  const auto gap = ValuesOf(rows, [](const HardRow& row) { return row.gap(); });
  const auto nodes = ValuesOf(rows, [](const HardRow& row) { return row.nodes; });
  // Known of rows for which CBC has an answer.
  const auto loss = ValuesOf(
      rows, [](const HardRow& row) { return (row.cbc_optimum - row.weight) / row.cbc_optimum; });
  const auto off = ValuesOf(rows, [](const HardRow& row) {
    return std::abs(row.relaxation - row.cbc_relaxation) / row.cbc_relaxation;
  });
  const auto cbc_ms = ValuesOf(rows, [](const HardRow& row) {
    return std::isnan(row.cbc_relaxation) ? kNotKnown : row.cbc_relaxation_s * 1e3;
  });
  const auto ratio = ValuesOf(rows, [](const HardRow& row) {
    return std::isnan(row.cbc_relaxation) ? kNotKnown : row.cpu_s / row.cbc_relaxation_s;
  });
  return fmt::format("{}|{}|{:.0f}|{:.2f}|{:.1f}|{:.1g}|{:.2f}|{}|{}|{}|{}", name, rows.size(),
                     Quantile(nodes, 1), Quantile(cpu_ms, 0.5), Quantile(cpu_ms, 1),
                     Quantile(gap, 1), PercentUpTo(1e-3, gap), Shown("{:.1g}", Quantile(loss, 1)),
                     Shown("{:.1g}", Quantile(off, 1)), Shown("{:.2f}", Quantile(cbc_ms, 0.5)),
                     Shown("{:.2f}", Quantile(ratio, 0.5)));
}

/// The five rows with the most of it.
std::string MostOf(const char* what, Rows rows, double (*measure)(const HardRow&)) {
  std::stable_sort(rows.begin(), rows.end(),
                   [&](const HardRow* a, const HardRow* b) { return measure(*a) > measure(*b); });
  rows.resize(std::min<std::size_t>(5, rows.size()));
  std::string text = what;
  for (const HardRow* row : rows) {
    text += fmt::format(" {} seed {} decision {} ({} nodes, {:.0f} ms, {:.1g});", row->family,
                        row->seed, row->decision, row->nodes, row->cpu_s * 1e3, row->gap());
  }
  return text + "\n";
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
      AnHour(2),
      AnHour(4),
      AnHour(7),
  };
  return families;
}

bool RunHard(const BenchOptions& options, const std::function<void(const HardRow&)>& report) {
  const auto cbc = options.ask == AskCbc::kNothing ? nullptr : GeneralSolver::Load();
  for (const HardFamily& family : HardFamilies()) {
    for (const std::uint64_t seed : options.AllSeeds()) {
      for (const Situation& situation : SituationsOf(family.settings, seed)) {
        const std::int32_t d = situation.decision;
        if (d != 2 && d != 4 && d != 8 && d != 12) continue;
        HardRow row;
        row.family = family.name;
        row.seed = seed;
        row = Decide(situation, options, row);
        Ask(situation, options.ask, cbc.get(), &row);
        report(row);
      }
    }
  }
  return options.ask == AskCbc::kNothing || cbc != nullptr;
}

void RunRandomSettings(const BenchOptions& options,
                       const std::function<void(const HardRow&)>& report) {
  for (const std::uint64_t seed : options.AllSeeds()) {
    HardRow row;
    row.family = "random";
    row.seed = seed;
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
  Sheet sheet("family|runs|nodes<=|median_ms|max_ms|gap<=|gap<=.1%|loss<=|LP_off|CBC_LP|ours/LP");
  Rows all;
  std::size_t not_reached = 0, asked = 0, below = 0;
  for (const HardRow& row : rows) {
    all.push_back(&row);
    not_reached += std::isnan(row.relaxation);
    asked += !std::isnan(row.others);
    below += row.others > row.weight * (1 + kProven);
  }
  const auto groups = GroupsOf(rows, [](const HardRow& row) { return row.family; });
  for (const auto& [name, group] : groups) sheet.Add(LineOf(name, group));
  if (groups.size() > 1) sheet.Add(LineOf("all", all));
  std::string relaxations;
  if (not_reached < rows.size()) {  // else nobody has told of them
    relaxations = fmt::format(
        "{} of {} relaxations not reached; {} decisions not proven within 1e-9 compared with mpq, "
        "ils and kwta, {} below\n",
        not_reached, rows.size(), asked, below);
  }
  return sheet.Text() + relaxations +
         MostOf("slowest:", all, [](const HardRow& row) { return row.cpu_s; }) +
         MostOf("largest gaps:", all, [](const HardRow& row) { return row.gap(); });
}

}  // namespace muster::tools
