#include "tools/bench/paper_scenarios.h"

#include <utility>

#include "model/generator.h"

namespace muster::tools {
namespace {

/// The rows of the paper's Table 6 that are none of its data sets.
GeneratorSettings Table6(const std::string& setting) {
  GeneratorSettings settings = PresetByName("Random_1");
  const auto set = [&](double side_km, int tasks, int charging, int workers, int uavs,
                       int vehicles) {
    settings.name = setting;
    settings.width_km = settings.height_km = side_km;
    settings.tasks = tasks;
    settings.charging_points = charging;
    settings.workers = workers;
    settings.uavs = uavs;
    settings.vehicles = vehicles;
  };
  if (setting == "Table6_3") {
    set(60, 480, 80, 80, 48, 32);
  } else if (setting == "Table6_4") {
    set(150, 600, 200, 500, 300, 200);
  } else if (setting == "Table6_5") {
    set(90, 600, 200, 180, 108, 72);
  } else if (setting == "Table6_6") {
    set(150, 600, 200, 300, 180, 120);
  } else {
    return PresetByName(setting);
  }
  return settings;
}

/// Readings of the paper's section 5.3.4 (docs/results/paper-results.md).
Disturbances DisturbancesOf(const std::string& name) {
  Disturbances d;
  if (name == "wind") d.wind = {0.1, 0.4};
  if (name == "communication") d.communication_m = {100, 500};
  if (name == "failure") d.agent_failure = {0.01, 0.05};
  if (name == "match") d.match_failure = {0.05, 0.1};
  return d;
}

}  // namespace

bool MovesByCells(std::string_view policy) { return policy.starts_with("greedy-"); }

PaperScenarios::PaperScenarios(std::string data_folder) : imported_(std::move(data_folder)) {}

void PaperScenarios::Prepare(const std::string& setting) {
  if (ImportedSettings::Has(setting)) {
    imported_.Prepare(setting);
  } else {
    Table6(setting);
  }
}

std::string PaperScenarios::PlacesOf(const std::string& setting) {
  return ImportedSettings::Has(setting) ? imported_.Sha256Of(setting).substr(0, 12) : "";
}

Scenario PaperScenarios::Make(const PaperRun& run) {
  const bool is_imported = ImportedSettings::Has(run.what.setting);
  GeneratorSettings settings =
      is_imported ? ImportedSettings::ShapeOf(run.what.setting) : Table6(run.what.setting);
  settings.name = run.what.setting;
  settings.rules.interval_us = run.what.interval_min * kMinuteUs;
  settings.rules.limit_us = run.what.limit_min * kMinuteUs;
  settings.rules.availability = run.what.availability;
  settings.rules.start_on_meeting = MovesByCells(run.policy);
  settings.disturbances = DisturbancesOf(run.what.disturbance);
  return is_imported ? imported_.Make(run.what.setting, settings, run.seed, false)
                     : Generate(settings, run.seed);
}

}  // namespace muster::tools
