#include "tools/bench/paper_scenarios.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/check.h"
#include "base/sha256.h"
#include "model/generator.h"
#include "tools/scenario/import.h"

namespace muster::tools {
namespace {

struct Imported {
  const char* name;
  const char* shape;
  const char* file;
};
constexpr Imported kImported[] = {
    {"newyork-bicycle", "BicycleOrder", "nyc_citibike_202409/citibike.csv"},
    {"shenzhen-didi", "DidiOrders", "shenzhen_taxi_orders/taxi-price.csv"},
    {"shenzhen-taxi", "TaxiTrajectories", "shenzhen_taxi_orders/taxi-price.csv"},
    {"haiti", "Random_1", "haiti2010_ushahidi/haiti_reports.csv"},
};

const Imported* FindImported(const std::string& setting) {
  const auto* at = std::find_if(std::begin(kImported), std::end(kImported),
                                [&](const Imported& row) { return row.name == setting; });
  return at == std::end(kImported) ? nullptr : at;
}

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

/// Readings of the paper's section 5.3.4 (docs/paper-results.md).
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

PaperScenarios::PaperScenarios(std::string data_folder) : data_folder_(std::move(data_folder)) {
  if (!HasImports()) return;
  for (const Imported& row : kImported) {
    if (std::filesystem::exists(std::filesystem::path(data_folder_) / row.file)) continue;
    throw InputError("options", "--data", data_folder_, fmt::format("a folder with {}", row.file));
  }
}

std::vector<std::string> PaperScenarios::ImportedSettings() {
  std::vector<std::string> names;
  for (const Imported& row : kImported) names.emplace_back(row.name);
  return names;
}

const PaperScenarios::Places& PaperScenarios::Load(const std::string& file) {
  const auto known = places_.find(file);
  if (known != places_.end()) return known->second;
  const std::string path = (std::filesystem::path(data_folder_) / file).string();
  Places places{ReadTable(path), ""};
  std::ifstream in(path, std::ios::binary);
  places.sha256 = Sha256(std::string(std::istreambuf_iterator<char>(in), {}));
  return places_.emplace(file, std::move(places)).first->second;
}

void PaperScenarios::Prepare(const std::string& setting) {
  if (const Imported* imported = FindImported(setting)) {
    Load(imported->file);
  } else {
    Table6(setting);
  }
}

std::string PaperScenarios::PlacesOf(const std::string& setting) {
  const Imported* imported = FindImported(setting);
  return imported == nullptr ? "" : Load(imported->file).sha256.substr(0, 12);
}

Scenario PaperScenarios::Make(const PaperRun& run) {
  const Imported* imported = FindImported(run.what.setting);
  GeneratorSettings settings =
      imported == nullptr ? Table6(run.what.setting) : PresetByName(imported->shape);
  settings.name = run.what.setting;
  settings.rules.interval_us = run.what.interval_min * kMinuteUs;
  settings.rules.limit_us = run.what.limit_min * kMinuteUs;
  settings.rules.availability = run.what.availability;
  settings.rules.start_on_meeting = MovesByCells(run.policy);
  settings.disturbances = DisturbancesOf(run.what.disturbance);
  if (imported == nullptr) return Generate(settings, run.seed);

  ImportRequest request;
  request.settings = settings;
  request.seed = run.seed;
  request.may_turn = true;
  if (run.what.setting == "haiti") {
    request.tasks.where = {ParseFilter("--tasks-where", "category=1*,2*,3*")};
    request.charging.where = {ParseFilter("--charging-where", "category=7*,2d")};
  }
  if (run.what.setting == "shenzhen-taxi") request.agents.at = {"ELat", "ELng"};
  return Import(Load(imported->file).table, request).scenario;
}

}  // namespace muster::tools
