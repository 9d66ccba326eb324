#pragma once

#include <string>

namespace muster::tools {

/// In the place of a file of tiles: there is to be no base map.
inline constexpr const char* kNoTiles = "none";

/// The file of tiles that lies beside a scenario and has its name: haiti.mbtiles or haiti.pmtiles
/// beside haiti.json; "": none.
std::string TilesBeside(const std::string& scenario_file);

/// The same of a run directory, or of a log file in one: beside its own scenario.json, or else
/// beside the scenario that its manifest.json names.
std::string TilesOfRun(const std::string& run);

}  // namespace muster::tools
