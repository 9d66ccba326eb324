#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/moment.h"
#include "model/generator.h"
#include "tools/scenario/fields.h"
#include "tools/scenario/fleet.h"
#include "tools/scenario/table.h"

namespace muster::tools {

/// Which rows become tasks, charging points or agents, and where they are.
struct ImportRole {
  std::optional<std::pair<std::string, std::string>> at;  ///< columns, if not the table's own
  std::vector<RowFilter> where;                           ///< beside ImportRequest::where
};

struct ImportWindow {
  Origin corner;  ///< south-west
  double width_km = 0;
  double height_km = 0;
};

struct ImportRequest {
  /// Columns of the place and the time, found by common names when not given. A time column that is
  /// given but empty: times are not used.
  std::optional<std::string> latitude, longitude, time;
  std::vector<RowFilter> where;
  ImportRole tasks, charging, agents;
  std::optional<ImportWindow> window;  ///< else the densest of the settings' area
  /// Columns of the tasks' priority, name and external id.
  std::optional<std::string> priority, task_name, task_note, external_id;
  bool are_reports = false;            ///< each task is a row that is reported at the row's time
  bool may_turn = false;               ///< the densest window may also be height by width
  bool may_shrink = false;             ///< to what the places need, where that is less
  std::optional<TimeUs> start;         ///< mission start, time of day; else the busiest period
  std::optional<Moment> start_moment;  ///< the scenario's start; `start` is its time of day
  /// Minutes east of UTC of the mission's clocks: times without an offset are theirs, others are
  /// put on them. Else all times count as they are written.
  std::optional<int> offset_min;
  std::vector<FleetAgent> fleet;  ///< the agents; empty: they are drawn
  std::vector<Depot> depots;      ///< the charging points; empty: they are cells with rows
  GeneratorSettings settings;     ///< counts, area, speeds, ...
  std::uint64_t seed = 1;
};

struct ImportResult {
  Scenario scenario;
  std::vector<std::string> summary;  ///< what was made from what, in lines
};

/// Makes a scenario from a table of places. Source: ours, after the paper's "discretise, filter,
/// classify" (appendix B, Real Datasets).
/// - Places are projected to local ENU at the window's south-west corner, which is the scenario's
///   origin, and counted in 1 km cells.
/// - Tasks are the cells with the most rows, charging points those with the most among the cells
///   that are no tasks (then among tasks); ties: the southern, then the western cell first.
/// - With `are_reports` tasks are rows instead, drawn from the rows of the mission's period of the
///   day, which is then the busiest period of the tasks. Each task is in its cell's centre (with
///   Placement::kContinuous: at its own place) and is reported at its row's time. With the same
///   seed, a larger number of tasks includes those of a smaller number.
/// - A task has the priority, name and external id of its row; a cell's task has those of the
/// cell's
///   most urgent row (of several, the first). A blank priority is drawn.
/// - Each agent stands where a row drawn for it is. With times, rows are of the mission's period of
///   the day, and an agent comes online at its row's part of the period: that part of [0, limit] or
///   of [0, limit - its online time] (Uptime). Without, its uptime is drawn as in Generate.
/// - The scenario's start is where the period begins, on the day of which it has most rows (the
///   first of them), with the rows' offset. Where rows have no date, or neither they nor the
///   request an offset, it has none.
/// Throws InputError when a column is missing, a priority is none, or nothing is left to
/// make a class from.
ImportResult Import(const Table& table, const ImportRequest& request);

}  // namespace muster::tools
