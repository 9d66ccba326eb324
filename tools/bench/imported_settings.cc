#include "tools/bench/imported_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>

#include "base/check.h"
#include "base/sha256.h"
#include "tools/files/pending_file.h"
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

const Imported& RowOf(const std::string& name) {
  const auto* at = std::find_if(std::begin(kImported), std::end(kImported),
                                [&](const Imported& row) { return row.name == name; });
  MUSTER_CHECK(at != std::end(kImported), "{}", name);
  return *at;
}

}  // namespace

ImportedSettings::ImportedSettings(std::string data_folder) : data_folder_(std::move(data_folder)) {
  if (!HasData()) return;
  for (const Imported& row : kImported) {
    if (std::filesystem::exists(std::filesystem::path(data_folder_) / row.file)) continue;
    throw InputError("options", "--data", data_folder_, fmt::format("a folder with {}", row.file));
  }
}

std::vector<std::string> ImportedSettings::Names() {
  std::vector<std::string> names;
  for (const Imported& row : kImported) names.emplace_back(row.name);
  return names;
}

bool ImportedSettings::Has(const std::string& name) {
  return std::any_of(std::begin(kImported), std::end(kImported),
                     [&](const Imported& row) { return row.name == name; });
}

GeneratorSettings ImportedSettings::ShapeOf(const std::string& name) {
  GeneratorSettings settings = PresetByName(RowOf(name).shape);
  settings.name = name;
  return settings;
}

const ImportedSettings::Places& ImportedSettings::Load(const std::string& name) {
  const std::string file = RowOf(name).file;
  const auto known = places_.find(file);
  if (known != places_.end()) return known->second;
  const std::string path = (std::filesystem::path(data_folder_) / file).string();
  return places_.emplace(file, Places{ReadTable(path), Sha256(ReadFile(path))}).first->second;
}

Scenario ImportedSettings::Make(const std::string& name, const GeneratorSettings& settings,
                                std::uint64_t seed, bool are_reports) {
  ImportRequest request;
  request.settings = settings;
  request.seed = seed;
  request.may_turn = true;
  request.are_reports = are_reports;
  if (name == "haiti") {
    request.tasks.where = {ParseFilter("--tasks-where", "category=1*,2*,3*")};
    request.charging.where = {ParseFilter("--charging-where", "category=7*,2d")};
  }
  if (name == "shenzhen-taxi") request.agents.at = {"ELat", "ELng"};
  return Import(Load(name).table, request).scenario;
}

}  // namespace muster::tools
