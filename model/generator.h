#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/scenario.h"

namespace muster {

/// A number that is drawn uniformly in [low, high] for each item, in thousandths; fixed when both
/// ends are equal.
struct DrawRange {
  double low = 0;
  double high = 0;
  bool operator==(const DrawRange&) const = default;
};
inline constexpr DrawRange Always(double value) { return {value, value}; }

/// Where places and agents stand: in the centre of a 1 km cell, or at any metre.
enum class Placement { kCellCentres, kContinuous };

/// From when an agent is online: uniform in [0, limit - its online time], so that it is never cut
/// short, or in [0, limit].
enum class Uptime { kWithinLimit, kAnyTime };

/// When tasks are reported. The others are known from the start.
struct Arrivals {
  double share = 0;  ///< probability that a task is reported while the mission runs
  /// 0: at any time of the mission, uniformly. Else each in one of so many bursts of kBurstUs, that
  /// begin at any time of it.
  int bursts = 0;
  bool operator==(const Arrivals&) const = default;
};
inline constexpr TimeUs kBurstUs = 10 * kMinuteUs;

/// Minutes after a task's report, by its priority; none: never.
using Delays = std::array<std::optional<DrawRange>, kPriorities>;

/// What a random scenario is made from, in the units of the paper's Table 1 (km, min): this
/// describes a data set; the scenario made from it is in SI. The paper does not publish the speeds,
/// the full range, `placement`, `uptime` and `start_fraction`: those are ours
/// (docs/reference/scenario-format.md).
struct GeneratorSettings {
  std::string name;
  double width_km = 30;
  double height_km = 30;
  int uavs = 30;
  int workers = 50;
  int vehicles = 20;
  int tasks = 120;
  int charging_points = 20;
  /// How long an agent is online. An infinite upper end stands for the limit: the paper's ">70
  /// min".
  DrawRange online_min = Always(60);
  DrawRange task_cost_km = Always(3);
  DrawRange charge_km_per_min = Always(10);
  double uav_speed_km_per_min = 1;
  double worker_speed_km_per_min = 0.5;
  double vehicle_speed_km_per_min = 0.75;
  double full_range_km = 30;
  DrawRange start_fraction = Always(1);  ///< of the full range, at mission start
  std::optional<int> capacity = 1;       ///< of each charging point; none: unlimited
  Placement placement = Placement::kCellCentres;
  Uptime uptime = Uptime::kWithinLimit;
  Arrivals arrivals;
  std::array<double, kPriorities> priority_shares = {0, 1, 0, 0};  ///< at least 0, not all of them
  Delays due_min, expires_min;  ///< a task is due at the latest when it expires
  Rules rules;
  Disturbances disturbances;
};

inline constexpr double kUpToLimit = std::numeric_limits<double>::infinity();

/// The 32 settings of the paper's Table 1, in its order: the shapes of BicycleOrder, DidiOrders and
/// TaxiTrajectories (with random places, not the real ones), then Random_1 to Random_29.
const std::vector<GeneratorSettings>& Presets();

/// Throws InputError when there is no preset of that name.
const GeneratorSettings& PresetByName(std::string_view name);

/// The same density on `scale` times the area: sides grow by sqrt(scale), counts by `scale`,
/// rounded to nearest, at least 1. scale > 0.
GeneratorSettings Scaled(GeneratorSettings settings, double scale);

/// A random scenario: a function of settings and seed alone. Every item is drawn from its own
/// stream (seed, class, id) and every property from its own index of it, so one more agent or
/// another range of costs leaves all other draws as they were. Items may share a cell. Throws
/// InputError when the settings break a rule of the scenario file. Linear in the number of items.
Scenario Generate(const GeneratorSettings& settings, std::uint64_t seed);

/// The parts of Generate, for scenarios whose places come from elsewhere.
AgentSpec DrawAgent(const GeneratorSettings& settings, std::uint64_t seed, AgentKind kind,
                    std::size_t id);
double DrawTaskCostM(const GeneratorSettings& settings, std::uint64_t seed, std::size_t id);
Priority DrawPriority(const GeneratorSettings& settings, std::uint64_t seed, std::size_t id);
TimeUs DrawReport(const GeneratorSettings& settings, std::uint64_t seed, std::size_t id);
/// Sets when a task is due and expires, by its report and its priority.
void DrawDeadlines(const GeneratorSettings& settings, std::uint64_t seed, std::size_t id,
                   Task* task);
/// In which order tasks are made from records, where there are more of them.
double DrawTaskRank(std::uint64_t seed, std::size_t record);
/// Which of `n` > 0 records an agent is made from, uniformly; apart from DrawAgent's draws.
std::size_t DrawRecord(std::uint64_t seed, AgentKind kind, std::size_t id, std::size_t n);
/// Times are drawn in these steps, so that files stay legible.
inline constexpr TimeUs kOnlineStepUs = kMinuteUs / 100;

inline constexpr double kCellM = 1000;
/// Centre of the 1 km cell, counted from the south-west corner; the last column and row of an area
/// that is no whole number of km are cut, and so is their centre.
Point CellCentre(int column, int row, double width_m, double height_m);

/// Kilometres to metres such that 2.371 km are 2371 m.
double KmToM(double km);

}  // namespace muster
