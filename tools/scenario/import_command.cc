#include "tools/scenario/import_command.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "base/check.h"
#include "base/program.h"
#include "tools/scenario/import.h"
#include "tools/scenario/settings_options.h"

namespace muster::tools {
namespace {

std::optional<std::string> Text(const cxxopts::ParseResult& flags, const std::string& name) {
  if (flags.count(name) == 0) return std::nullopt;
  return flags[name].as<std::string>();
}

/// All filters of a flag that may be given several times.
std::vector<RowFilter> Filters(const cxxopts::ParseResult& flags, const std::string& name) {
  std::vector<RowFilter> filters;
  for (const cxxopts::KeyValue& argument : flags.arguments()) {
    if (argument.key() == name) filters.push_back(ParseFilter("--" + name, argument.value()));
  }
  return filters;
}

ImportRole Role(const cxxopts::ParseResult& flags, const std::string& role) {
  ImportRole result;
  result.where = Filters(flags, role + "-where");
  if (const auto at = Text(flags, role + "-at")) {
    const std::vector<std::string> columns = Split(*at, ',');
    if (columns.size() != 2) {
      throw InputError("command line", "--" + role + "-at", "'" + *at + "'", "LATITUDE,LONGITUDE");
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
  for (std::size_t i = 0; i < 4; ++i) numbers[i] = ParseNumber("window", parts[i], kExpected);
  constexpr double kMaxSideKm = 1000;  // beyond, a flat map is none
  for (const double side_km : {numbers[2], numbers[3]}) {
    if (side_km <= 0 || side_km > kMaxSideKm) fail();
  }
  if (std::abs(numbers[0]) > 90 || std::abs(numbers[1]) > 180) fail();
  return {{numbers[0], numbers[1]}, numbers[2], numbers[3]};
}

}  // namespace

int ImportCommand(int argc, const char* const* argv) {
  cxxopts::Options options(
      "muster import",
      "Makes a scenario from a table of places: CSV, or GeoJSON when FILE ends "
      "in .json or .geojson.");
  const auto text = [] { return cxxopts::value<std::string>(); };
  options.add_options()("points", "The table", text(), "FILE")(
      "shape", "Take area and numbers from this data set of the paper (see muster scenario --list)",
      cxxopts::value<std::string>()->default_value("Random_1"),
      "NAME")("quiet", "Do not print what was made from what");
  options.add_options("Table")("lat", "Column of latitudes, WGS84 degrees (default: found by name)",
                               text(), "COLUMN")(
      "lon", "Column of longitudes (default: found by name)", text(), "COLUMN")(
      "time", "Column of times, or none (default: found by name)", text(), "COLUMN")(
      "where",
      "Use only rows with one of the values; a value may end in *; a field may hold several, "
      "joined "
      "by ';'; may be given again, then all must hold",
      text(), "COLUMN=VALUE[,VALUE...]")("tasks-where", "Rows that become tasks", text(), "...")(
      "charging-where", "Rows that become charging points", text(), "...")(
      "agents-where", "Rows where agents start", text(), "...")(
      "tasks-at", "Columns of the tasks' places, when not --lat and --lon", text(), "LAT,LON")(
      "charging-at", "Columns of the charging points' places", text(), "LAT,LON")(
      "agents-at", "Columns of the agents' places", text(), "LAT,LON")(
      "window", "South-west corner in degrees, width and height in km (default: the densest)",
      text(), "LAT,LON,W,H")("start", "Time of day of the mission's start (default: the busiest)",
                             text(), "H:MM");
  AddSettingsOptions(&options);
  options.parse_positional({"points"});
  options.positional_help("FILE");
  const auto flags = ParseOptions(&options, argc, argv);
  if (!flags) return kExitOk;
  const auto file = Text(*flags, "points");
  if (!file) throw InputError("command line", "FILE", "nothing", "a table of places (see --help)");

  ImportRequest request;
  GeneratorSettings base = PresetByName((*flags)["shape"].as<std::string>());
  if (flags->count("shape") == 0) base.name = std::filesystem::path(*file).stem().string();
  request.settings = SettingsFrom(*flags, base);
  request.seed = SeedFrom(*flags);
  request.latitude = Text(*flags, "lat");
  request.longitude = Text(*flags, "lon");
  request.time = Text(*flags, "time");
  if (request.time == "none") request.time = "";
  request.where = Filters(*flags, "where");
  request.tasks = Role(*flags, "tasks");
  request.charging = Role(*flags, "charging");
  request.agents = Role(*flags, "agents");
  if (const auto window = Text(*flags, "window")) request.window = ParseWindow(*window);
  request.may_turn = flags->count("area") == 0;
  if (const auto start = Text(*flags, "start")) {
    request.start = TimeOfDay(*start);
    if (!request.start) {
      throw InputError("command line", "--start", "'" + *start + "'", "a time of day like 7:30");
    }
  }

  const ImportResult result = Import(ReadTable(*file), request);
  WriteScenario(result.scenario, *flags);
  if (flags->count("quiet") == 0) {
    for (const std::string& line : result.summary) fmt::print(stderr, "{}\n", line);
  }
  return kExitOk;
}

}  // namespace muster::tools
