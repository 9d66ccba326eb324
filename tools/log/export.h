#pragma once

#include <optional>
#include <string>

#include "model/scenario.h"
#include "tools/log/log_source.h"

namespace muster::tools {

/// Writes tables into the new folder `out` (docs/guide/logs.md): agents.csv, decisions.csv,
/// actions.csv, events.csv, tasks.csv, processes.csv, ways.csv (the ways that agents went) and,
/// where there are roads, closed_roads.csv. RFC 4180, a header line each, SI units, mission time in
/// seconds. Throws InputError when `out` exists or the log has no scenario.
void ExportCsv(LogSource* source, const std::string& out);

/// Writes sites.geojson (tasks with the time each was done, charging points), positions.geojson
/// (points with a time, for QGIS' temporal controller), ways.geojson (the ways that agents went),
/// where there are roads roads.geojson (with the times for which each was closed), and
/// trips.geojson (lines whose coordinates carry a Unix time, for kepler.gl) into the new folder
/// `out`. WGS84, from the scenario's origin or, where it has none, `origin`; without either an
/// InputError.
void ExportGeoJson(LogSource* source, const std::string& out, std::optional<Origin> origin);

/// Writes each flight of the UAVs as volumes in space and time (Volume4D of ASTM F3548-21) into one
/// JSON file, for missions that keep UAVs apart. Altitudes are WGS84: those of the mission and
/// `ground_m`, the height of the ground. The origin as above.
void ExportVolumes(LogSource* source, const std::string& out, std::optional<Origin> origin,
                   double ground_m);

/// Writes one MCAP file: every message of the mission as JSON with a JSON schema, log time is the
/// mission's, and on topic /scene agents and tasks as foxglove.SceneUpdate for the 3D panel.
void ExportMcap(LogSource* source, const std::string& out);

}  // namespace muster::tools
