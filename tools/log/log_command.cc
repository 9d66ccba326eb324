#include "tools/log/log_command.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <string_view>

#include "base/check.h"
#include "base/program.h"
#include "tools/log/export.h"
#include "tools/log/log_edit.h"
#include "tools/log/log_info.h"

namespace muster::tools {
namespace {

std::string RunOf(const cxxopts::ParseResult& parsed) {
  if (parsed.count("run") == 0) throw InputError("no RUN given: a run directory or a log file");
  return parsed["run"].as<std::string>();
}

std::string OutOf(const cxxopts::ParseResult& parsed) {
  if (parsed.count("out") == 0) throw InputError("command line", "--out", "nothing", "a new path");
  return parsed["out"].as<std::string>();
}

cxxopts::Options MakeOptions(const char* program, const char* what) {
  cxxopts::Options options(program, what);
  options.add_options()("run", "Run directory or log file", cxxopts::value<std::string>());
  options.parse_positional({"run"});
  options.positional_help("RUN");
  return options;
}

std::int64_t SecondsFlag(const cxxopts::ParseResult& parsed, const char* flag) {
  const double seconds = parsed[flag].as<double>();
  if (std::isnan(seconds)) {
    throw InputError("command line", fmt::format("--{}", flag), "nan", "seconds");
  }
  return seconds <= 0 ? 0 : ToUs(seconds);
}

int Info(int argc, const char* const* argv) {
  cxxopts::Options options = MakeOptions(argv[0], "Sums a log up by channel and sender.");
  options.add_options()("json", "Print as JSON");
  const auto parsed = ParseOptions(&options, argc, argv);
  if (!parsed) return kExitOk;
  const LogInfo info = ReadLogInfo(RunOf(*parsed));
  fmt::print("{}", parsed->count("json") > 0 ? ToJson(info).dump(2) + "\n" : ToText(info));
  return kExitOk;
}

int Repair(int argc, const char* const* argv) {
  cxxopts::Options options =
      MakeOptions(argv[0], "Writes one clean log of a damaged, doubled or split one.");
  options.add_options()("out", "New log file", cxxopts::value<std::string>(), "FILE");
  const auto parsed = ParseOptions(&options, argc, argv);
  if (!parsed) return kExitOk;
  LogSource source(RunOf(*parsed));
  const std::string out = OutOf(*parsed);
  const EditResult result = RepairLog(&source, out);
  fmt::print("{}: {} of {} messages, {} bytes of garbage left out\n", out, result.written,
             result.read, source.garbage_bytes());
  for (const auto& [key, sender] : ReadLogInfo(out).senders) {
    for (const IntervalSet::Range& gap : sender.Gaps()) {
      fmt::print("{} (start {}): seq {} to {} are lost\n", std::get<1>(key), std::get<2>(key),
                 gap.first, gap.last);
    }
  }
  return kExitOk;
}

int Cut(int argc, const char* const* argv) {
  cxxopts::Options options =
      MakeOptions(argv[0], "Copies the part of a log between two mission times, and the scenario.");
  options.add_options()("from", "Seconds of mission time",
                        cxxopts::value<double>()->default_value("0"), "S")(
      "to", "Seconds of mission time (default: the end)", cxxopts::value<double>(), "S")(
      "out", "New log file", cxxopts::value<std::string>(), "FILE");
  const auto parsed = ParseOptions(&options, argc, argv);
  if (!parsed) return kExitOk;
  const std::int64_t from_us = SecondsFlag(*parsed, "from");
  const std::int64_t to_us = parsed->count("to") > 0 ? SecondsFlag(*parsed, "to") : kNever;
  if (to_us < from_us) {
    throw InputError("command line", "--to", fmt::format("{}", (*parsed)["to"].as<double>()),
                     "at least --from");
  }
  LogSource source(RunOf(*parsed));
  const std::string out = OutOf(*parsed);
  const EditResult result = CutLog(&source, from_us, to_us, out);
  fmt::print("{}: {} of {} messages\n", out, result.written, result.read);
  return kExitOk;
}

std::optional<Origin> OriginFlag(const cxxopts::ParseResult& parsed) {
  if (parsed.count("origin") == 0) return {};
  const std::string text = parsed["origin"].as<std::string>();
  Origin origin;
  char end = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf%c", &origin.latitude_deg, &origin.longitude_deg, &end) !=
          2 ||
      !(std::abs(origin.latitude_deg) <= 90) || !(std::abs(origin.longitude_deg) <= 180)) {
    throw InputError("command line", "--origin", text, "latitude,longitude in degrees");
  }
  return origin;
}

int Export(int argc, const char* const* argv) {
  cxxopts::Options options =
      MakeOptions(argv[0], "Turns a run's log into tables, maps or an MCAP file.");
  options.add_options()("format", "csv, geojson or mcap", cxxopts::value<std::string>(), "NAME")(
      "out", "New folder (csv, geojson) or file (mcap)", cxxopts::value<std::string>(), "PATH")(
      "origin", "WGS84 of the south-west corner, for geojson of a scenario that names none",
      cxxopts::value<std::string>(), "LAT,LON");
  const auto parsed = ParseOptions(&options, argc, argv);
  if (!parsed) return kExitOk;
  const std::string format =
      parsed->count("format") > 0 ? (*parsed)["format"].as<std::string>() : "nothing";
  if (format != "csv" && format != "geojson" && format != "mcap") {
    throw InputError("command line", "--format", format, "csv, geojson or mcap");
  }
  const auto origin = OriginFlag(*parsed);
  LogSource source(RunOf(*parsed));
  const std::string out = OutOf(*parsed);
  if (format == "csv") ExportCsv(&source, out);
  if (format == "geojson") ExportGeoJson(&source, out, origin);
  if (format == "mcap") ExportMcap(&source, out);
  return kExitOk;
}

struct Subcommand {
  std::string_view name;
  std::string_view summary;
  int (*body)(int argc, const char* const* argv);
};
constexpr Subcommand kSubcommands[] = {
    {"info", "sums a log up by channel and sender", Info},
    {"repair", "writes one clean log of a damaged, doubled or split one", Repair},
    {"cut", "copies the part between two mission times", Cut},
    {"export", "to CSV, GeoJSON or MCAP", Export},
};

}  // namespace

int LogCommand(int argc, const char* const* argv) {
  const std::string_view name = argc > 1 ? argv[1] : "--help";
  if (name == "--help" || name == "-h") {
    fmt::print("Usage: muster log COMMAND RUN [OPTION...]\n\nCommands:\n");
    for (const Subcommand& s : kSubcommands) fmt::print("  {:<8} {}\n", s.name, s.summary);
    return argc > 1 ? kExitOk : kExitUsage;
  }
  for (const Subcommand& s : kSubcommands) {
    if (s.name != name) continue;
    const std::string program = fmt::format("muster log {}", name);
    std::vector<const char*> arguments(argv + 1, argv + argc);
    arguments[0] = program.c_str();
    return s.body(static_cast<int>(arguments.size()), arguments.data());
  }
  throw InputError(fmt::format("no command 'log {}' (see muster log --help)", name));
}

}  // namespace muster::tools
