#include "tools/scenario/import_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "base/text.h"
#include "tools/map/roads_option.h"
#include "tools/map/zones_option.h"
#include "tools/scenario/import.h"
#include "tools/scenario/settings_options.h"

namespace muster::tools {
namespace {

/// All filters of a flag that may be given several times.
std::vector<RowFilter> Filters(const Arguments& arguments, const std::string& name) {
  std::vector<RowFilter> filters;
  for (const std::string& text : arguments.All(name)) {
    filters.push_back(ParseFilter("--" + name, text));
  }
  return filters;
}

ImportRole ImportRoleOf(const Arguments& arguments, const std::string& role) {
  ImportRole result;
  result.where = Filters(arguments, role + "-where");
  if (arguments.Has(role + "-at")) {
    const std::string at = arguments.Get(role + "-at");
    const std::vector<std::string> columns = Split(at, ',');
    if (columns.size() != 2) {
      throw InputError("command line", "--" + role + "-at", "'" + at + "'", "LATITUDE,LONGITUDE");
    }
    result.at = {columns[0], columns[1]};
  }
  return result;
}

ImportWindow ParseWindow(const std::string& text) {
  constexpr std::string_view kExpected =
      "LAT,LON,W,H: degrees of the south-west corner and kilometres, like 18.4,-72.5,30,30";
  const std::vector<std::string> parts = Split(text, ',');
  const auto fail = [&] {
    throw InputError("command line", "--window", "'" + text + "'", kExpected);
  };
  if (parts.size() != 4) fail();
  double numbers[4];
  for (std::size_t i = 0; i < 4; ++i) {
    const auto number = ToNumber(parts[i]);
    if (!number) fail();
    numbers[i] = *number;
  }
  constexpr double kMaxSideKm = 1000;  // beyond, a flat map is none
  for (const double side_km : {numbers[2], numbers[3]}) {
    if (side_km <= 0 || side_km > kMaxSideKm) fail();
  }
  if (std::abs(numbers[0]) > 90 || std::abs(numbers[1]) > 180) fail();
  return {{numbers[0], numbers[1]}, numbers[2], numbers[3]};
}

void ReadStart(const Arguments& arguments, ImportRequest* request) {
  if (arguments.Has("utc-offset")) {
    request->offset_min = ParseOffset(arguments.Get("utc-offset"));
    if (!request->offset_min) {
      throw InputError("command line", "--utc-offset", "'" + arguments.Get("utc-offset") + "'",
                       "an offset like -05:00 or 05:30, at most 14:00");
    }
  }
  if (!arguments.Has("start")) return;
  const std::string text = arguments.Get("start");
  request->start = TimeOfDay(text);
  // With a date it is no time of day alone: an offset left out is an error then.
  if (const auto time = ReadTime(text, DateOrder::kUnknown); time && time->day) {
    request->start_moment = ParseMoment(text);
    request->start = request->start_moment ? request->start : std::nullopt;
  }
  if (!request->start) {
    throw InputError("command line", "--start", "'" + text + "'",
                     fmt::format("a time of day like 7:30, or {}", kMomentExpected));
  }
  if (!request->start_moment) return;
  if (request->offset_min && request->offset_min != request->start_moment->offset_min) {
    throw InputError(
        "command line", "--utc-offset", "'" + arguments.Get("utc-offset") + "'",
        fmt::format("{}, that of --start", OffsetText(request->start_moment->offset_min)));
  }
  request->offset_min = request->start_moment->offset_min;
}

void AddImportOptions(Options* options) {
  options->Positional("points", "FILE").Required("a table of places (see --help)");
  options
      ->Add("shape", "NAME",
            "Take area and numbers from this data set of the paper (see muster scenario --list)")
      .Default("Random_1");
  options->Quiet();
  options->Group("Table");
  options->Add("lat", "COLUMN", "Column of latitudes, WGS84 degrees (default: found by name)");
  options->Add("lon", "COLUMN", "Column of longitudes (default: found by name)");
  options->Add(
      "time", "COLUMN",
      "Column of times (clock, ISO 8601, Unix seconds or ms), or none (default: found by name)");
  options
      ->Add("where", "COLUMN=VALUE[,VALUE...]",
            "Use only rows with one of the values; a value may end in *; a field may hold several, "
            "joined by ';'; may be given again, then all must hold")
      .Repeated();
  options->Add("tasks-where", "...", "Rows that become tasks").Repeated();
  options->Add("charging-where", "...", "Rows that become charging points").Repeated();
  options->Add("agents-where", "...", "Rows where agents start").Repeated();
  options->Add("tasks-at", "LAT,LON", "Columns of the tasks' places, when not --lat and --lon");
  options->Add("charging-at", "LAT,LON", "Columns of the charging points' places");
  options->Add("agents-at", "LAT,LON", "Columns of the agents' places");
  options->Add("fleet", "FILE",
               "The agents, a row each: class (uav, worker, vehicle), latitude, longitude and, if "
               "you know them, speed_km_per_min, full_range_km, range_km, charge_km_per_min, "
               "online_from_min, online_until_min");
  options->Add(
      "depots", "FILE",
      "The charging points, a row each: latitude, longitude and, if you know it, capacity");
  options->Add("window", "LAT,LON,W,H",
               "South-west corner in degrees, width and height in km (default: the densest of the "
               "area, or with neither --area nor --shape a smaller one around all places)");
  options->Add(
      "priority", "COLUMN",
      "Column of the tasks' priorities: 0 to 3, or low, normal, high, emergency; a blank one "
      "is drawn (--priorities)");
  options->Add("task-name", "COLUMN", "Column of the tasks' names");
  options->Add("task-note", "COLUMN", "Column of what people should know of each task");
  options->Add("external-id", "COLUMN", "Column of the tasks' names in another system");
  options->Add(
      "start", "H:MM|TIME",
      "Time of day of the mission's start (default: the busiest), or the scenario's start, "
      "like 2010-01-16T09:00:00-05:00");
  options->Add(
      "utc-offset", "HH:MM",
      "Offset of the place's clocks from UTC, like -05:00: times without an offset are read as "
      "such, others are converted");
  options->Group("");
}

}  // namespace

int ImportCommand(int argc, const char* const* argv) {
  Options options(
      "muster import",
      "Makes a scenario from a table of places: CSV, or GeoJSON when FILE ends in .json "
      "or .geojson.");
  AddImportOptions(&options);
  AddSettingsOptions(&options, true);
  AddRoadsOptions(&options);
  AddZonesOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string file = arguments->Get("points");

  ImportRequest request;
  GeneratorSettings base = PresetByName(arguments->Get("shape"));
  if (!arguments->Has("shape")) base.name = std::filesystem::path(file).stem().string();
  request.settings = SettingsFrom(*arguments, base, true);
  request.seed = arguments->Get<std::uint64_t>("seed");
  arguments->Read("lat", &request.latitude);
  arguments->Read("lon", &request.longitude);
  arguments->Read("time", &request.time);
  if (request.time == "none") request.time = "";
  request.where = Filters(*arguments, "where");
  request.tasks = ImportRoleOf(*arguments, "tasks");
  request.charging = ImportRoleOf(*arguments, "charging");
  request.agents = ImportRoleOf(*arguments, "agents");
  if (arguments->Has("window")) request.window = ParseWindow(arguments->Get("window"));
  arguments->Read("priority", &request.priority);
  arguments->Read("task-name", &request.task_name);
  arguments->Read("task-note", &request.task_note);
  arguments->Read("external-id", &request.external_id);
  request.are_reports = arguments->Has("arrivals") && arguments->Get("arrivals") == kArrivalsOfRows;
  request.may_turn = !arguments->Has("area");
  request.may_shrink =
      !arguments->Has("area") && !arguments->Has("shape") && !arguments->Has("scale");
  ReadStart(*arguments, &request);

  for (const char* const count : {"uavs", "workers", "vehicles"}) {
    if (!arguments->Has("fleet") || !arguments->Has(count)) continue;
    throw InputError("command line", fmt::format("--{}", count), arguments->Get(count),
                     "nothing beside --fleet, which has all agents");
  }
  if (arguments->Has("depots") && arguments->Has("charging-points")) {
    throw InputError("command line", "--charging-points", arguments->Get("charging-points"),
                     "nothing beside --depots, which has all of them");
  }
  std::vector<std::string> left_out;
  const auto table_of = [&](const char* option) {
    Table table = ReadTable(arguments->Get(option));
    if (const auto unused = UnusedColumns(table); !unused.empty()) {
      left_out.push_back(fmt::format("{}: columns that nothing is made of: {}", table.file,
                                     fmt::join(unused, ", ")));
    }
    return table;
  };
  if (arguments->Has("fleet")) request.fleet = ReadFleet(table_of("fleet"), request.settings);
  if (arguments->Has("depots")) request.depots = ReadDepots(table_of("depots"), request.settings);

  ImportResult result = Import(ReadTable(file), request);
  for (std::string& line : left_out) result.summary.push_back(std::move(line));
  for (std::string& line : TakeRoads(*arguments, &result.scenario)) {
    result.summary.push_back(std::move(line));
  }
  for (std::string& line : TakeZones(*arguments, &result.scenario)) {
    result.summary.push_back(std::move(line));
  }
  WriteScenario(result.scenario, *arguments);
  if (!arguments->Has("quiet")) {
    for (const std::string& line : result.summary) Say("{}\n", line);
  }
  return kExitOk;
}

}  // namespace muster::tools
