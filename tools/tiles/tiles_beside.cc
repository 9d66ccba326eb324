#include "tools/tiles/tiles_beside.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

/// The scenario that the run was started with, as far as its manifest tells; "": it does not.
fs::path ScenarioOfManifest(const fs::path& directory) {
  std::ifstream in(directory / "manifest.json");
  const auto manifest = nlohmann::json::parse(in, nullptr, false);
  if (!manifest.is_object()) return {};
  const auto text = [](const nlohmann::json& of, const char* key) -> std::string {
    const auto found = of.find(key);
    return found != of.end() && found->is_string() ? *found : "";
  };
  const auto scenario = manifest.find("scenario");
  const std::string file =
      scenario != manifest.end() && scenario->is_object() ? text(*scenario, "file") : "";
  return file.empty() ? fs::path() : fs::path(text(manifest, "folder")) / file;
}

}  // namespace

std::string TilesBeside(const std::string& scenario_file) {
  if (scenario_file.empty()) return "";
  for (const char* const extension : {".mbtiles", ".pmtiles"}) {
    const fs::path file = fs::path(scenario_file).replace_extension(extension);
    std::error_code none;
    if (fs::is_regular_file(file, none)) return file.string();
  }
  return "";
}

std::string TilesOfRun(const std::string& run) {
  std::error_code none;
  const fs::path directory =
      fs::is_directory(run, none) ? fs::path(run) : fs::path(run).parent_path();
  const std::string own = TilesBeside((directory / "scenario.json").string());
  return own.empty() ? TilesBeside(ScenarioOfManifest(directory).string()) : own;
}

}  // namespace muster::tools
