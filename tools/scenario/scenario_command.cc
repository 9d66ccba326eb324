#include "tools/scenario/scenario_command.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "base/text.h"
#include "tools/map/roads_option.h"
#include "tools/map/zones_option.h"
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

Origin ParseOrigin(const std::string& text) {
  const std::vector<std::string> parts = Split(text, ',');
  const auto latitude = ToNumber(parts.front()), longitude = ToNumber(parts.back());
  if (parts.size() != 2 || !latitude || !longitude || std::abs(*latitude) > 90 ||
      std::abs(*longitude) > 180) {
    throw InputError("command line", "--origin", "'" + text + "'",
                     "LAT,LON: degrees within 90 and 180, like 18.41,-72.47");
  }
  return {*latitude, *longitude};
}

}  // namespace

int ScenarioCommand(int argc, const char* const* argv) {
  Options options("muster scenario", "Writes a random scenario file.");
  options.Add("preset", "NAME", "Data set of the paper to start from (see --list)")
      .Default("Random_1");
  options.Flag("list", "Print the presets as a table and exit");
  options.Add("start", "TIME",
              "When the mission starts, like 2010-01-16T09:00:00-05:00 (default: unknown)");
  options.Add("origin", "LAT,LON",
              "Degrees of the area's south-west corner, like 18.41,-72.47 (default: unknown)");
  options.Quiet();
  AddSettingsOptions(&options);
  AddRoadsOptions(&options);
  AddZonesOptions(&options);
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
  if (arguments->Has("origin")) scenario.origin = ParseOrigin(arguments->Get("origin"));
  std::vector<std::string> summary = TakeRoads(*arguments, &scenario);
  for (std::string& line : TakeZones(*arguments, &scenario)) summary.push_back(std::move(line));
  WriteScenario(scenario, *arguments);
  if (!arguments->Has("quiet")) {
    for (const std::string& line : summary) Say("{}\n", line);
  }
  return kExitOk;
}

}  // namespace muster::tools
