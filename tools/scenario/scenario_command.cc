#include "tools/scenario/scenario_command.h"

#include <fmt/format.h>

#include <cmath>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "tools/scenario/settings_options.h"

namespace muster::tools {
namespace {

std::string Shown(const DrawRange& range) {
  if (range.low == range.high) return fmt::to_string(range.low);
  if (std::isinf(range.high)) return fmt::format("{}:", range.low);
  return fmt::format("{}:{}", range.low, range.high);
}

void ListPresets() {
  fmt::print("{:<16} {:>8} {:>5} {:>15} {:>10} {:>4} {:>7} {:>8} {:>12} {:>17}\n", "preset",
             "area_km", "tasks", "charging_points", "online_min", "uavs", "workers", "vehicles",
             "task_cost_km", "charge_km_per_min");
  for (const GeneratorSettings& preset : Presets()) {
    fmt::print("{:<16} {:>8} {:>5} {:>15} {:>10} {:>4} {:>7} {:>8} {:>12} {:>17}\n", preset.name,
               fmt::format("{}x{}", preset.width_km, preset.height_km), preset.tasks,
               preset.charging_points, Shown(preset.online_min), preset.uavs, preset.workers,
               preset.vehicles, Shown(preset.task_cost_km), Shown(preset.charge_km_per_min));
  }
}

}  // namespace

int ScenarioCommand(int argc, const char* const* argv) {
  Options options("muster scenario", "Writes a random scenario file.");
  options.Add("preset", "NAME", "Data set of the paper to start from (see --list)")
      .Default("Random_1");
  options.Flag("list", "Print the presets as a table and exit");
  options.Add("start", "TIME",
              "Mission time 0, like 2010-01-16T09:00:00-05:00 (default: not told)");
  AddSettingsOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  if (arguments->Has("list")) {
    ListPresets();
    return kExitOk;
  }
  const GeneratorSettings& preset = PresetByName(arguments->Get("preset"));
  Scenario scenario =
      Generate(SettingsFrom(*arguments, preset), arguments->Get<std::uint64_t>("seed"));
  if (arguments->Has("start")) {
    const std::string text = arguments->Get("start");
    scenario.start = ParseMoment(text);
    if (!scenario.start) {
      throw InputError("command line", "--start", "'" + text + "'", kMomentExpected);
    }
  }
  WriteScenario(scenario, *arguments);
  return kExitOk;
}

}  // namespace muster::tools
