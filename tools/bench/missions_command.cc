#include "tools/bench/missions_command.h"

#include <fmt/format.h>

#include <fstream>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/program.h"
#include "base/say.h"
#include "model/generator.h"
#include "scheduler/policies/registry.h"
#include "tools/bench/mission_suite.h"
#include "tools/host/stop_signals.h"

namespace muster::tools {
namespace {

constexpr int kMostProcesses = 64;

MissionSuite ReadSuite(const Arguments& arguments) {
  MissionSuite suite;
  suite.instances = arguments.All("instances");
  if (arguments.Has("scales")) suite.scales = arguments.All<double>("scales");
  if (suite.instances.empty() && suite.scales.empty()) suite.instances = {"Random_1", "Random_29"};
  for (const std::string& name : suite.instances) PresetByName(name);
  for (const double n : arguments.All<double>("processes")) {
    suite.processes.push_back(static_cast<int>(n));
  }
  suite.runs = arguments.All("runs");
  const std::vector<std::string> policies = arguments.All("methods");
  if (policies.size() > 1) {
    throw InputError("command line", "--methods", fmt::format("{}", fmt::join(policies, ",")),
                     "one policy");
  }
  suite.policy = policies.empty() ? "certified" : policies.front();
  scheduler::MakePolicy(suite.policy);
  arguments.Read("limit", &suite.limit_min);
  suite.repetitions = arguments.Get<int>("repetitions");
  suite.seed = arguments.Get<std::uint64_t>("first-seed");
  return suite;
}

}  // namespace

void AddMissionSuiteOptions(Options* options) {
  options->Group("Suite missions");
  options->Add("processes", "N,...", "Processes of each agent class")
      .List()
      .Integer(1, kMostProcesses)
      .Default("1,2,4,12");
  options
      ->Add(
          "runs", "HOW,...",
          "muster, lcm: over LCM, and who writes the log; none: over LCM without a log; simulate: "
          "in one process")
      .List()
      .OneOf({"muster", "lcm", "none", "simulate"})
      .Default("simulate,muster,none");
  options->Add("limit", "MIN", "Minutes of mission (default: the setting's)")
      .Number(Above0(100'000));
}

int MissionsCommand(const Arguments& arguments) {
  const MissionSuite suite = ReadSuite(arguments);
  std::ofstream csv;
  if (arguments.Has("out")) {
    csv.open(arguments.Get("out"));
    if (!csv) throw SystemError(fmt::format("{}: cannot be written", arguments.Get("out")));
    csv << MissionCsvHeader() << std::flush;
  }
  const StopSignals stop;
  std::vector<MissionRow> rows;
  RunMissionSuite(
      suite,
      [&](const MissionRow& row) {
        rows.push_back(row);
        if (csv.is_open()) csv << ToCsv(row) << std::flush;
        if (!arguments.Has("quiet")) {
          Say("{}, {} a class, {}: {:.2f} s, {}\n", row.instance, row.processes, row.run,
              row.figures.wall_s, row.figures.end);
        }
      },
      [&] { return stop.count() > 0; });
  if (csv.is_open() && !csv) throw SystemError("the CSV file cannot be written");
  fmt::print("{}", SummaryOf(rows));
  const std::vector<std::string> problems = ProblemsOf(rows);
  for (const std::string& problem : problems) fmt::print("{}\n", problem);
  if (stop.count() > 0) return kExitInterrupted;
  return problems.empty() ? kExitOk : kExitCheckFailed;
}

}  // namespace muster::tools
