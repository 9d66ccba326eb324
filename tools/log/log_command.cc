#include "tools/log/log_command.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <string_view>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "base/text.h"
#include "tools/files/pending_file.h"
#include "tools/files/scenario_file.h"
#include "tools/log/export.h"
#include "tools/log/log_edit.h"
#include "tools/log/log_info.h"
#include "tools/log/log_merge.h"
#include "tools/log/log_orders.h"

namespace muster::tools {
namespace {

constexpr double kMostSeconds = 1e9;

Options MakeOptions(const char* program, const char* what) {
  Options options(program, what);
  options.Run();
  return options;
}

int Info(int argc, const char* const* argv) {
  Options options = MakeOptions(argv[0], "Sums a log up by channel and sender.");
  options.Json();
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const LogInfo info = ReadLogInfo(arguments->Get("run"));
  fmt::print("{}", arguments->Has("json") ? ToJson(info).dump(2) + "\n" : ToText(info));
  return kExitOk;
}

/// Says what is missing in a log; returns the exit code.
int SayGaps(const std::string& log) {
  int code = kExitOk;
  for (const auto& [key, sender] : ReadLogInfo(log).senders) {
    for (const IntervalSet::Range& gap : sender.Gaps()) {
      code = kExitCheckFailed;
      fmt::print("{} (start {}): seq {} to {} are lost\n", std::get<1>(key), std::get<2>(key),
                 gap.first, gap.last);
    }
  }
  return code;
}

int Repair(int argc, const char* const* argv) {
  Options options =
      MakeOptions(argv[0], "Writes one clean log from a damaged one, from copies or from parts.");
  options.Out("FILE", "New log file").Required("a new path");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  LogSource source(arguments->Get("run"));
  source.ShowProgress("repair");
  const std::string out = arguments->Get("out");
  const EditResult result = RepairLog(&source, out);
  fmt::print("{}: {} of {} messages, {} bytes of garbage left out\n", out, result.written,
             result.read, source.garbage_bytes());
  SayGaps(out);
  return kExitOk;
}

int Merge(int argc, const char* const* argv) {
  Options options(argv[0],
                  "Makes one log of several of the same mission, such as those of two recorders. "
                  "Exit code 4 if a message is in none of them.");
  options.Positional("run", "RUN RUN...").Repeated().Required("run directories or log files");
  options.Out("FILE", "New log file").Required("a new path");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::vector<std::string> runs = arguments->All("run");
  const std::string out = arguments->Get("out");
  const MergeResult result = MergeLogs(runs, out);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    fmt::print("{}: {} messages{}\n", runs[i], result.added[i],
               i == 0 ? "" : " that those before it lack");
  }
  const int code = SayGaps(out);
  fmt::print("{}: {} messages, {}\n", out, result.written,
             code == kExitOk ? "no gap in any sender's numbers" : "with gaps");
  return code;
}

int Cut(int argc, const char* const* argv) {
  Options options =
      MakeOptions(argv[0], "Copies the part of a log between two mission times, and the scenario.");
  options.Add("from", "S", "Seconds of mission time").Number({0, kMostSeconds}).Default(0);
  options.Add("to", "S", "Seconds of mission time (default: the end)").Number({0, kMostSeconds});
  options.Out("FILE", "New log file").Required("a new path");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::int64_t from_us = ToUs(arguments->Get<double>("from"));
  const std::int64_t to_us = arguments->Has("to") ? ToUs(arguments->Get<double>("to")) : kNever;
  if (to_us < from_us) {
    throw InputError("command line", "--to", arguments->Get("to"), "at least --from");
  }
  LogSource source(arguments->Get("run"));
  source.ShowProgress("cut");
  const std::string out = arguments->Get("out");
  const EditResult result = CutLog(&source, from_us, to_us, out);
  fmt::print("{}: {} of {} messages\n", out, result.written, result.read);
  return kExitOk;
}

std::optional<Origin> OriginFlag(const Arguments& arguments) {
  if (!arguments.Has("origin")) return {};
  const std::string text = arguments.Get("origin");
  const std::vector<std::string> parts = Split(text, ',');
  const auto latitude = ToNumber(parts.front());
  const auto longitude = ToNumber(parts.back());
  if (parts.size() != 2 || !latitude || !longitude || std::abs(*latitude) > 90 ||
      std::abs(*longitude) > 180) {
    throw InputError("command line", "--origin", fmt::format("'{}'", text),
                     "latitude,longitude in degrees");
  }
  return Origin{*latitude, *longitude};
}

int Export(int argc, const char* const* argv) {
  Options options = MakeOptions(argv[0], "Turns a run's log into tables, maps or an MCAP file.");
  options.Add("format", "NAME", "csv, geojson, mcap or volumes")
      .OneOf({"csv", "geojson", "mcap", "volumes"})
      .Required("csv, geojson, mcap or volumes");
  options.Out("PATH", "New folder (csv, geojson) or file (mcap, volumes)").Required("a new path");
  options.Add("origin", "LAT,LON",
              "South-west corner in WGS84 degrees, for geojson and volumes of a scenario without "
              "an origin");
  options.Add("ground", "M", "Height of the ground above the WGS84 ellipsoid, for volumes")
      .Number({-500, 9000})
      .Default(0);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string format = arguments->Get("format");
  const auto origin = OriginFlag(*arguments);
  LogSource source(arguments->Get("run"));
  source.ShowProgress("export");
  const std::string out = arguments->Get("out");
  if (format == "csv") ExportCsv(&source, out);
  if (format == "geojson") ExportGeoJson(&source, out, origin);
  if (format == "mcap") ExportMcap(&source, out);
  if (format == "volumes") ExportVolumes(&source, out, origin, arguments->Get<double>("ground"));
  return kExitOk;
}

int Orders(int argc, const char* const* argv) {
  Options options = MakeOptions(
      argv[0],
      "Prints the orders that a mission took, a line of JSON each: muster run --orders gives them "
      "again.");
  options.Add("scenario", "FILE", "Write the scenario as it was before any order");
  options.Add(
      "with-orders", "FILE",
      "Write a scenario with the tasks and agents that orders added, as if the file had had "
      "them");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  LogSource source(arguments->Get("run"));
  source.ShowProgress("orders");
  const CapturedOrders captured = CaptureOrders(&source);
  fmt::print("{}", captured.lines);
  if (arguments->Has("scenario")) {
    WriteScenarioFile(*captured.scenario, arguments->Get("scenario"));
  }
  if (arguments->Has("with-orders")) {
    WriteScenarioFile(*captured.with, arguments->Get("with-orders"));
    if (captured.left_out > 0) {
      Say("muster: {} of {} orders have no place in a scenario: those that cancel, hold or resume "
          "a "
          "task, end an agent's stay or ask for a decision\n",
          captured.left_out, captured.taken);
    }
  }
  return kExitOk;
}

}  // namespace

int LogCommand(int argc, const char* const* argv) {
  static const std::vector<Command> commands = {
      {"info", "sums a log up by channel and sender", Info},
      {"repair", "writes one clean log from a damaged one, from copies or from parts", Repair},
      {"merge", "makes one log of those of two recorders", Merge},
      {"cut", "copies the part between two mission times", Cut},
      {"orders", "prints the orders that a mission took", Orders},
      {"export", "to CSV, GeoJSON or MCAP", Export},
  };
  return RunCommandOf(argv[0], "Sums up, repairs, merges, cuts and exports the logs of runs",
                      commands, argc, argv);
}

}  // namespace muster::tools
