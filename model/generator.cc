#include "model/generator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "base/number_text.h"
#include "base/random.h"
#include "base/text.h"
#include "model/scenario_json.h"

namespace muster {
namespace {

/// Which property of an item a draw is for. Part of every scenario's content: never renumber.
enum Property : std::uint32_t {
  kPlace = 0,
  kOnline = 1,
  kUptime = 2,
  kPower = 3,
  kStart = 4,
  kRecord = 5,
  kIsReported = 6,
  kReport = 7,
  kBurst = 8,    // which of them a task is in
  kBurstAt = 9,  // of a burst, not of a task
  kPriority = 10,
  kDue = 11,
  kExpires = 12
};

struct Row {
  const char* name;
  double width_km, height_km;
  int tasks, charging_points;
  DrawRange online_min;
  int workers, uavs, vehicles;
  DrawRange task_cost_km, charge_km_per_min;
};

constexpr DrawRange AtLeast(double value) { return {value, kUpToLimit}; }

// Source: the paper's Table 1 ("Description of experimental datasets", appendix B).
constexpr Row kRows[] = {
    {"BicycleOrder", 25, 16, 99, 30, AtLeast(70), 54, 17, 34, Always(3), Always(10)},
    {"DidiOrders", 10, 9, 34, 10, AtLeast(50), 26, 18, 14, Always(3), Always(10)},
    {"TaxiTrajectories", 30, 30, 102, 60, AtLeast(90), 38, 20, 16, Always(3), Always(10)},
    {"Random_1", 30, 30, 120, 20, Always(60), 50, 30, 20, Always(3), Always(10)},
    {"Random_2", 20, 20, 120, 20, Always(60), 50, 30, 20, Always(3), Always(10)},
    {"Random_3", 40, 40, 120, 20, Always(60), 50, 30, 20, Always(3), Always(10)},
    {"Random_4", 30, 30, 100, 20, Always(60), 50, 30, 20, Always(3), Always(10)},
    {"Random_5", 30, 30, 140, 20, Always(60), 50, 30, 20, Always(3), Always(10)},
    {"Random_6", 30, 30, 120, 10, Always(60), 50, 30, 20, Always(3), Always(10)},
    {"Random_7", 30, 30, 120, 30, Always(60), 50, 30, 20, Always(3), Always(10)},
    {"Random_8", 30, 30, 120, 20, Always(40), 50, 30, 20, Always(3), Always(10)},
    {"Random_9", 30, 30, 120, 20, Always(80), 50, 30, 20, Always(3), Always(10)},
    {"Random_10", 30, 30, 80, 20, Always(60), 30, 20, 10, Always(3), Always(10)},
    {"Random_11", 30, 30, 120, 20, Always(60), 70, 40, 30, Always(3), Always(10)},
    {"Random_12", 30, 30, 120, 20, Always(60), 30, 30, 20, Always(3), Always(10)},
    {"Random_13", 30, 30, 120, 20, Always(60), 70, 30, 20, Always(3), Always(10)},
    {"Random_14", 30, 30, 120, 20, Always(60), 50, 20, 20, Always(3), Always(10)},
    {"Random_15", 30, 30, 120, 20, Always(60), 50, 40, 20, Always(3), Always(10)},
    {"Random_16", 30, 30, 120, 20, Always(60), 50, 30, 10, Always(3), Always(10)},
    {"Random_17", 30, 30, 120, 20, Always(60), 50, 30, 30, Always(3), Always(10)},
    {"Random_18", 30, 30, 120, 20, Always(60), 50, 30, 20, Always(2), Always(10)},
    {"Random_19", 30, 30, 120, 20, Always(60), 50, 30, 20, Always(4), Always(10)},
    {"Random_20", 30, 30, 120, 20, Always(60), 50, 30, 20, {2, 3}, Always(10)},
    {"Random_21", 30, 30, 120, 20, Always(60), 50, 30, 20, {3, 4}, Always(10)},
    {"Random_22", 30, 30, 120, 20, Always(60), 50, 30, 20, {4, 5}, Always(10)},
    {"Random_23", 30, 30, 120, 20, Always(60), 50, 30, 20, Always(3), Always(6)},
    {"Random_24", 30, 30, 120, 20, Always(60), 50, 30, 20, Always(3), Always(14)},
    {"Random_25", 30, 30, 120, 20, Always(60), 50, 30, 20, Always(3), {2, 6}},
    {"Random_26", 30, 30, 120, 20, Always(60), 50, 30, 20, Always(3), {6, 10}},
    {"Random_27", 30, 30, 120, 20, Always(60), 50, 30, 20, Always(3), {10, 14}},
    {"Random_28", 40, 40, 240, 40, Always(60), 100, 60, 40, Always(3), Always(10)},
    {"Random_29", 60, 60, 480, 80, Always(60), 200, 120, 80, Always(3), Always(10)},
};

std::vector<GeneratorSettings> MakePresets() {
  std::vector<GeneratorSettings> presets;
  for (const Row& row : kRows) {
    GeneratorSettings& preset = presets.emplace_back();
    preset.name = row.name;
    preset.width_km = row.width_km;
    preset.height_km = row.height_km;
    preset.tasks = row.tasks;
    preset.charging_points = row.charging_points;
    preset.online_min = row.online_min;
    preset.workers = row.workers;
    preset.uavs = row.uavs;
    preset.vehicles = row.vehicles;
    preset.task_cost_km = row.task_cost_km;
    preset.charge_km_per_min = row.charge_km_per_min;
  }
  return presets;
}

/// A whole number in [0, steps]; `steps` beyond 32 bits are cut to them.
double DrawSteps(Random* random, double steps) {
  return random->Below(static_cast<std::uint32_t>(std::clamp(steps, 0.0, 4294967294.0)) + 1u);
}

/// A thousandth of the unit, drawn in the range; not rounded when it is fixed.
double DrawThousandths(const DrawRange& range, std::uint64_t seed, Stream stream, std::size_t id,
                       Property property) {
  if (range.low == range.high) return KmToM(range.low);
  Random random(seed, stream, id, property);
  const double low = std::round(range.low * 1000);
  return low + DrawSteps(&random, std::round(range.high * 1000) - low);
}

Point DrawPlace(const GeneratorSettings& settings, std::uint64_t seed, Stream stream,
                std::size_t id) {
  Random random(seed, stream, id, kPlace);
  const double width_m = KmToM(settings.width_km);
  const double height_m = KmToM(settings.height_km);
  if (settings.placement == Placement::kContinuous) {
    const double x_m = DrawSteps(&random, std::floor(width_m));
    return {x_m, DrawSteps(&random, std::floor(height_m))};
  }
  const int column = static_cast<int>(DrawSteps(&random, std::ceil(width_m / kCellM) - 1));
  const int row = static_cast<int>(DrawSteps(&random, std::ceil(height_m / kCellM) - 1));
  return CellCentre(column, row, width_m, height_m);
}

Stream StreamOf(AgentKind kind) {
  return PerKind<Stream>{Stream::kUavs, Stream::kWorkers, Stream::kVehicles}[kind];
}

/// Whole time steps in [0, most_us], drawn.
TimeUs DrawTime(TimeUs most_us, std::uint64_t seed, Stream stream, std::size_t id,
                Property property) {
  Random random(seed, stream, id, property);
  const TimeUs steps = std::max<TimeUs>(most_us, 0) / kOnlineStepUs;
  return static_cast<TimeUs>(DrawSteps(&random, static_cast<double>(steps))) * kOnlineStepUs;
}

/// `from_us` and the delay of that priority after it; kNever without one.
TimeUs DrawDelayed(const Delays& delays, Priority priority, TimeUs from_us, std::uint64_t seed,
                   std::size_t id, Property property) {
  const auto& range = delays[static_cast<std::size_t>(priority)];
  if (!range) return kNever;
  const TimeUs low_us = ToUs(range->low * 60);
  const TimeUs more_us = ToUs(range->high * 60) - low_us;
  return from_us + low_us + DrawTime(more_us, seed, Stream::kTasks, id, property);
}

}  // namespace

double KmToM(double km) {
  const double m = km * 1000;
  const double whole = std::round(m);
  return std::abs(m - whole) <= 1e-9 * std::abs(whole) ? whole : m;
}

Point CellCentre(int column, int row, double width_m, double height_m) {
  const auto middle = [](int cell, double side_m) {
    return (kCellM * cell + std::min(kCellM * (cell + 1), side_m)) / 2;
  };
  return {middle(column, width_m), middle(row, height_m)};
}

const std::vector<GeneratorSettings>& Presets() {
  static const std::vector<GeneratorSettings> presets = MakePresets();
  return presets;
}

const GeneratorSettings& PresetByName(std::string_view name) {
  for (const GeneratorSettings& preset : Presets()) {
    if (preset.name == name) return preset;
  }
  std::vector<std::string> names;
  for (const GeneratorSettings& preset : Presets()) names.push_back(preset.name);
  throw InputError(
      fmt::format("no preset '{}': expected BicycleOrder, DidiOrders, TaxiTrajectories or Random_1 "
                  "to Random_29{}",
                  name, DidYouMean(name, names)));
}

GeneratorSettings Scaled(GeneratorSettings settings, double scale) {
  MUSTER_CHECK(scale > 0 && std::isfinite(scale), "scale={}", scale);
  if (scale == 1) return settings;
  for (double* side_km : {&settings.width_km, &settings.height_km}) {
    *side_km = std::round(*side_km * std::sqrt(scale) * 1000) / 1000;
  }
  for (int* count : {&settings.uavs, &settings.workers, &settings.vehicles, &settings.tasks,
                     &settings.charging_points}) {
    *count = static_cast<int>(std::clamp(std::round(*count * scale), 1.0, 2147483647.0));
  }
  return settings;
}

AgentSpec DrawAgent(const GeneratorSettings& settings, std::uint64_t seed, AgentKind kind,
                    std::size_t id) {
  const Stream stream = StreamOf(kind);
  const TimeUs limit_us = settings.rules.limit_us;
  AgentSpec agent;
  agent.at = DrawPlace(settings, seed, stream, id);

  const TimeUs least_us = ToUs(settings.online_min.low * 60);
  TimeUs online_us = least_us;
  if (settings.online_min.high != settings.online_min.low) {
    const TimeUs most_us =
        std::isinf(settings.online_min.high) ? limit_us : ToUs(settings.online_min.high * 60);
    online_us += DrawTime(most_us - least_us, seed, stream, id, kOnline);
  }
  const TimeUs latest_us = settings.uptime == Uptime::kAnyTime ? limit_us : limit_us - online_us;
  agent.online_from_us = DrawTime(latest_us, seed, stream, id, kUptime);
  agent.online_until_us = agent.online_from_us + online_us;

  double speed_km_per_min = settings.vehicle_speed_km_per_min;
  if (kind == AgentKind::kUav) {
    speed_km_per_min = settings.uav_speed_km_per_min;
    agent.range_full_m = KmToM(settings.full_range_km);
    const double thousandths = DrawThousandths(settings.start_fraction, seed, stream, id, kStart);
    agent.range_m = std::min(agent.range_full_m, agent.range_full_m * thousandths / 1000);
  } else if (kind == AgentKind::kWorker) {
    speed_km_per_min = settings.worker_speed_km_per_min;
  } else {
    const double m_per_min = DrawThousandths(settings.charge_km_per_min, seed, stream, id, kPower);
    agent.charge_rate_m_s = m_per_min / 60;
  }
  agent.speed_m_s = KmToM(speed_km_per_min) / 60;
  return agent;
}

double DrawTaskCostM(const GeneratorSettings& settings, std::uint64_t seed, std::size_t id) {
  return DrawThousandths(settings.task_cost_km, seed, Stream::kTasks, id, kPower);
}

Priority DrawPriority(const GeneratorSettings& settings, std::uint64_t seed, std::size_t id) {
  const auto& shares = settings.priority_shares;
  double sum = 0;
  for (const double share : shares) sum += share;
  double left = Random(seed, Stream::kTasks, id, kPriority).Uniform() * sum;
  std::size_t drawn = kPriorities;
  for (std::size_t i = 0; i < kPriorities; ++i) {
    if (shares[i] <= 0) continue;
    drawn = i;  // the last one also when the sum was rounded
    if (left < shares[i]) break;
    left -= shares[i];
  }
  MUSTER_CHECK(drawn < kPriorities, "sum of shares={}", sum);
  return static_cast<Priority>(drawn);
}

TimeUs DrawReport(const GeneratorSettings& settings, std::uint64_t seed, std::size_t id) {
  const Arrivals& arrivals = settings.arrivals;
  if (Random(seed, Stream::kTasks, id, kIsReported).Uniform() >= arrivals.share) return 0;
  const TimeUs limit_us = settings.rules.limit_us;
  if (arrivals.bursts == 0) return DrawTime(limit_us - 1, seed, Stream::kTasks, id, kReport);
  const std::uint32_t burst =
      Random(seed, Stream::kTasks, id, kBurst).Below(static_cast<std::uint32_t>(arrivals.bursts));
  const TimeUs length_us = std::min(kBurstUs, limit_us);
  return DrawTime(limit_us - length_us, seed, Stream::kTasks, burst, kBurstAt) +
         DrawTime(length_us - 1, seed, Stream::kTasks, id, kReport);
}

void DrawDeadlines(const GeneratorSettings& settings, std::uint64_t seed, std::size_t id,
                   Task* task) {
  const TimeUs from_us = task->reported_us;
  task->due_us = DrawDelayed(settings.due_min, task->priority, from_us, seed, id, kDue);
  task->expires_us = DrawDelayed(settings.expires_min, task->priority, from_us, seed, id, kExpires);
  if (task->due_us != kNever) task->due_us = std::min(task->due_us, task->expires_us);
}

double DrawTaskRank(std::uint64_t seed, std::size_t record) {
  return Random(seed, Stream::kTasks, record, kRecord).Uniform();
}

std::size_t DrawRecord(std::uint64_t seed, AgentKind kind, std::size_t id, std::size_t n) {
  MUSTER_CHECK(n > 0 && n <= UINT32_MAX, "n={}", n);
  return Random(seed, StreamOf(kind), id, kRecord).Below(static_cast<std::uint32_t>(n));
}

Scenario Generate(const GeneratorSettings& settings, std::uint64_t seed) {
  constexpr double kMaxSideKm = 100'000;  // twice round the Earth
  for (const double side_km : {settings.width_km, settings.height_km}) {
    if (!(side_km > 0 && side_km <= kMaxSideKm)) {
      throw InputError("generator settings", "area", fmt::format("a side of {} km", side_km),
                       fmt::format("above 0 and at most {} km", kMaxSideKm));
    }
  }
  const DrawRange& online = settings.online_min;
  MUSTER_CHECK(online.low >= 0 && online.low <= kMaxMinutes && online.low <= online.high &&
                   (online.high <= kMaxMinutes || std::isinf(online.high)),
               "online_min={}..{}", online.low, online.high);
  Scenario scenario;
  scenario.name = settings.name;
  scenario.seed = seed;
  scenario.width_m = KmToM(settings.width_km);
  scenario.height_m = KmToM(settings.height_km);
  scenario.rules = settings.rules;
  scenario.disturbances = settings.disturbances;
  const auto agents = [&](AgentKind kind, int count, std::vector<AgentSpec>* list) {
    for (int id = 0; id < count; ++id) {
      list->push_back(DrawAgent(settings, seed, kind, static_cast<std::size_t>(id)));
    }
  };
  agents(AgentKind::kUav, settings.uavs, &scenario.uavs);
  agents(AgentKind::kWorker, settings.workers, &scenario.workers);
  agents(AgentKind::kVehicle, settings.vehicles, &scenario.vehicles);
  for (int i = 0; i < settings.tasks; ++i) {
    const auto id = static_cast<std::size_t>(i);
    Task& task = scenario.tasks.emplace_back();
    task.at = DrawPlace(settings, seed, Stream::kTasks, id);
    task.cost_m = DrawTaskCostM(settings, seed, id);
    task.priority = DrawPriority(settings, seed, id);
    task.reported_us = DrawReport(settings, seed, id);
    DrawDeadlines(settings, seed, id, &task);
  }
  for (int i = 0; i < settings.charging_points; ++i) {
    const auto id = static_cast<std::size_t>(i);
    scenario.charging_points.push_back(
        {DrawPlace(settings, seed, Stream::kChargingPoints, id), settings.capacity});
  }
  ValidateScenario(scenario, "generator settings");
  return scenario;
}

}  // namespace muster
