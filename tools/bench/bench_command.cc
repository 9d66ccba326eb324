#include "tools/bench/bench_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "base/text.h"
#include "protocol/run_process.h"
#include "scheduler/policies/registry.h"
#include "tools/bench/arrivals_suite.h"
#include "tools/bench/hard_suite.h"
#include "tools/bench/mission_suite.h"
#include "tools/bench/paper_command.h"
#include "tools/bench/random_missions.h"
#include "tools/bench/roads_suite.h"
#include "tools/bench/sheet.h"
#include "tools/bench/small_missions.h"
#include "tools/bench/suites.h"
#include "tools/files/pending_file.h"
#include "tools/host/progress.h"
#include "tools/host/stop_signals.h"

namespace muster::tools {
namespace {

constexpr int kMostProcesses = 64;

void AddBenchOptions(Options* options) {
  options
      ->Add("suite", "SUITE",
            "decisions (of missions on the paper's data sets), scale (decisions of ever larger "
            "Random_29), hard (families that are hard to prove), random (drawn settings), "
            "random-missions (all decisions of missions of drawn settings), small-missions "
            "(missions of up to 8 UAVs beside the best that is possible), missions "
            "(whole ones over LCM), arrivals (tasks that are reported while missions run), "
            "roads (by road, in straight lines, with closed roads), paper "
            "(the paper's experiments: completion rates) or paper-long (those of them that take "
            "longest)")
      .OneOf({"decisions", "scale", "hard", "random", "random-missions", "small-missions",
              "missions", "arrivals", "roads", "paper", "paper-long"})
      .Default("decisions");
  options->Add("instances", "NAME,...", "Settings (default: all of the suite)").List();
  options->Add("scales", "X,...", "scale, missions: sizes, as multiples of Random_29")
      .List()
      .Number(Above0(1000))
      .Default("1,3,10,30,100");
  options
      ->Add("loads", "X,...",
            "arrivals: numbers of tasks, as multiples of those of Random_1 or of the data set's "
            "shape")
      .List()
      .Number(Above0(100))
      .Default("0.5,1,2");
  options
      ->Add("scenarios", "FILE,...",
            "roads: scenarios with roads; those of one name are compared as seeds")
      .List();
  options->Add("closed", "PERCENT,...", "roads: how much of the roads' length is closed")
      .List()
      .Number(Above0(100))
      .Default("5,20");
  options
      ->Add("methods", "NAME,...",
            "Policies (default: certified; small-missions, paper, arrivals, roads: several)")
      .List();
  options
      ->Add("seeds", "N",
            "Scenarios of each setting (default: 10; small-missions: 30; decisions, scale: 1)")
      .Integer(1, 10'000);
  options->Add("cbc", "WHAT", "hard: what COIN-OR CBC is asked for, where it is installed")
      .OneOf({"nothing", "relaxation", "optimum"})
      .Default("optimum");
  options->Add("first-seed", "N", "First seed of the scenarios").Integer(1, 1'000'000).Default(1);
  options->Add("repetitions", "N", "Runs of each decision").Integer(1, 10'000).Default(1);
  options->Add("threads", "N", "Threads of certified, 1 or 2").Integer(1, 2).Default(1);
  options->Out("FILE", "CSV file; paper: folder for rows, tables and page");
  options->Add("plot", "FILE", "gnuplot script that draws the results, with --out");
  options->Group("Suite missions");
  options->Add("processes", "N,...", "Processes of each agent class")
      .List()
      .Integer(1, kMostProcesses)
      .Default("1,2,4,12");
  options
      ->Add("runs", "HOW,...",
            "muster, lcm: over LCM, with muster-recorder or lcm-logger for the log; none: over LCM "
            "without a log; simulate: in one process")
      .List()
      .OneOf({"muster", "lcm", "none", "simulate"})
      .Default("simulate,muster,none");
  options->Add("limit", "MIN", "Minutes of mission (default: the setting's)")
      .Number(Above0(100'000));
  AddPaperOptions(options);
}

/// `methods`, `seeds`: where the command line does not say them.
BenchOptions ReadBenchOptions(const Arguments& arguments, const std::vector<std::string>& methods,
                              int seeds) {
  BenchOptions bench;
  bench.methods = arguments.Has("methods") ? arguments.All("methods") : methods;
  for (const std::string& method : bench.methods) scheduler::MakePolicy(method);
  bench.instances = arguments.All("instances");
  bench.scales = arguments.All<double>("scales");
  bench.loads = arguments.All<double>("loads");
  bench.scenarios = arguments.All("scenarios");
  bench.closed_percent = arguments.All<double>("closed");
  bench.seeds = seeds;
  arguments.Read("seeds", &bench.seeds);
  bench.first_seed = arguments.Get<int>("first-seed");
  bench.repetitions = arguments.Get<int>("repetitions");
  bench.threads = arguments.Get<int>("threads");
  arguments.Read("data", &bench.data);
  for (const double n : arguments.All<double>("processes")) {
    bench.processes.push_back(static_cast<int>(n));
  }
  bench.runs = arguments.All("runs");
  arguments.Read("limit", &bench.limit_min);
  return bench;
}

/// One value of an option that takes several in other suites.
void CheckOne(const std::vector<std::string>& values, const char* option, const char* expected) {
  if (values.size() == 1) return;
  throw InputError("command line", option, fmt::format("{}", fmt::join(values, ",")), expected);
}

/// Hands `run` what takes its rows: each goes to the CSV file at once. Prints their summary.
template <class Row, class Run>
std::vector<Row> RunSuite(const Arguments& arguments, const std::string& csv_header,
                          const Run& run) {
  RowFile csv(arguments.Has("out") ? arguments.Get("out") : "", csv_header);
  std::vector<Row> rows;
  run([&](const Row& row) {
    rows.push_back(row);
    csv.Add(ToCsv(row));
  });
  fmt::print("{}", SummaryOf(rows));
  return rows;
}

/// The same, showing how many of the `n` missions are flown.
template <class Row, class Run>
std::vector<Row> RunShowingProgress(const Arguments& arguments, const std::string& csv_header,
                                    std::size_t n, const Run& run) {
  ProgressPrinter progress(stderr, StyleFor(stderr, arguments.Has("quiet")));
  const TimeUs start_us = MonotonicUs();
  std::size_t flown = 0;
  return RunSuite<Row>(arguments, csv_header, [&](const auto& report) {
    run([&](const Row& row) {
      report(row);
      const TimeUs took_us = MonotonicUs() - start_us;
      ++flown;
      if (progress.due(took_us)) progress.Show(fmt::format("{} of {} missions", flown, n), took_us);
    });
    progress.Break();
  });
}

/// `script`: of the names of CSV and SVG file.
template <class Script>
void WritePlot(const Arguments& arguments, const Script& script) {
  if (!arguments.Has("plot")) return;
  const auto csv = arguments.Get("out");
  WriteFile(arguments.Get("plot"), script(csv, csv + ".svg"));
}

int DecisionsCommand(const Arguments& arguments, bool scale) {
  BenchOptions bench = ReadBenchOptions(arguments, {"certified"}, 1);
  for (const std::string& name : bench.instances) PresetByName(name);
  if (bench.instances.empty()) {
    for (const GeneratorSettings& preset : Presets()) bench.instances.push_back(preset.name);
  }
  if (arguments.Has("availability")) {
    const auto modes = arguments.All("availability");
    CheckOne(modes, "--availability", "strict or overrun");
    if (modes[0] == "overrun") bench.availability = Availability::kOverrun;
  }
  WritePlot(arguments, &PlotScript);
  RunSuite<BenchRow>(arguments, CsvHeader(), [&](const auto& report) {
    scale ? RunScale(bench, report) : RunDecisions(bench, report);
  });
  return kExitOk;
}

int HardCommand(const Arguments& arguments, bool random) {
  BenchOptions bench = ReadBenchOptions(arguments, {"certified"}, 10);
  const auto ask = arguments.Get("cbc");
  if (ask == "nothing") bench.ask = AskCbc::kNothing;
  if (ask == "relaxation") bench.ask = AskCbc::kRelaxation;
  fmt::print("seeds {} to {}; times are processor time\n", bench.first_seed,
             bench.first_seed + bench.seeds - 1);
  if (random) fmt::print("{}", RandomSettingsLimits());
  for (const HardFamily& family : HardFamilies()) {
    if (!random) fmt::print("{}: {}\n", family.name, family.flags);
  }
  RunSuite<HardRow>(arguments, HardCsvHeader(), [&](const auto& report) {
    if (random) {
      RunRandomSettings(bench, report);
    } else if (!RunHard(bench, report)) {
      fmt::print("COIN-OR CBC (libCbcSolver.so.3) is not installed: nothing to compare with\n");
    }
  });
  return kExitOk;
}

int RandomMissionsCommand(const Arguments& arguments) {
  const BenchOptions bench = ReadBenchOptions(arguments, {"certified"}, 10);
  fmt::print("seeds {} to {}; times are wall time\n{}", bench.first_seed,
             bench.first_seed + bench.seeds - 1, RandomMissionsLimits());
  RunSuite<HardRow>(arguments, HardCsvHeader(),
                    [&](const auto& report) { RunRandomMissions(bench, report); });
  return kExitOk;
}

int SmallMissionsCommand(const Arguments& arguments) {
  const BenchOptions bench = ReadBenchOptions(
      arguments, {"kwta", "mpq", "certified", "horizon", "rollout", "rollout-steps"}, 30);
  fmt::print("seeds {} to {}\n{}", bench.first_seed, bench.first_seed + bench.seeds - 1,
             SmallMissionsLimits());
  const std::size_t n = static_cast<std::size_t>(bench.seeds) * bench.methods.size();
  RunShowingProgress<SmallRow>(arguments, SmallCsvHeader(), n,
                               [&](const auto& report) { RunSmallMissions(bench, report); });
  return kExitOk;
}

int MissionsCommand(const Arguments& arguments) {
  BenchOptions bench = ReadBenchOptions(arguments, {"certified"}, 1);
  CheckOne(bench.methods, "--methods", "one policy");
  if (!arguments.Has("scales")) bench.scales.clear();
  if (bench.instances.empty() && bench.scales.empty()) bench.instances = {"Random_1", "Random_29"};
  for (const std::string& name : bench.instances) PresetByName(name);
  const int most = *std::max_element(bench.processes.begin(), bench.processes.end());
  WritePlot(arguments,
            [&](const auto& csv, const auto& svg) { return MissionPlotScript(csv, svg, most); });
  const StopSignals stop;
  const auto rows = RunSuite<MissionRow>(arguments, MissionCsvHeader(), [&](const auto& report) {
    RunMissionSuite(
        bench,
        [&](const MissionRow& row) {
          report(row);
          if (arguments.Has("quiet")) return;
          Say("{}, {} a class, {}: {:.2f} s, {}\n", row.instance, row.processes, row.run,
              row.figures.wall_s, row.figures.end);
        },
        [&] { return stop.count() > 0; });
  });
  const std::vector<std::string> problems = ProblemsOf(rows);
  for (const std::string& problem : problems) fmt::print("{}\n", problem);
  if (stop.count() > 0) return kExitInterrupted;
  return problems.empty() ? kExitOk : kExitCheckFailed;
}

int ArrivalsCommand(const Arguments& arguments) {
  BenchOptions bench = ReadBenchOptions(
      arguments, {"kwta", "mpq", "certified", "horizon", "rollout", "rollout-steps"}, 10);
  const auto known = ArrivalsInstances(!bench.data.empty());
  for (const std::string& name : bench.instances) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw InputError("command line", "--instances", name,
                     fmt::format("{}{}", fmt::join(known, ", "),
                                 bench.data.empty() ? "; with --data those of its tables" : ""));
  }
  if (bench.instances.empty()) bench.instances = known;
  const std::size_t n = bench.instances.size() * bench.loads.size() *
                        static_cast<std::size_t>(bench.seeds) * bench.methods.size();
  const auto rows = RunShowingProgress<ArrivalsRow>(
      arguments, ArrivalsCsvHeader(), n, [&](const auto& report) { RunArrivals(bench, report); });
  WritePlot(arguments, [&](const auto&, const auto& svg) { return ArrivalsPlot(rows, svg); });
  return kExitOk;
}

int RoadsCommand(const Arguments& arguments) {
  const BenchOptions bench = ReadBenchOptions(
      arguments,
      {"kwta", "mpq", "certified", "horizon", "horizon-steps", "rollout-steps",
       "certified-without-roads", "horizon-without-roads", "rollout-steps-without-roads"},
      1);
  if (bench.scenarios.empty()) {
    throw InputError("command line", "--scenarios", "nothing", "files of scenarios with roads");
  }
  const std::size_t n =
      bench.scenarios.size() * bench.methods.size() * (2 + 2 * bench.closed_percent.size());
  RunShowingProgress<RoadsRow>(arguments, RoadsCsvHeader(), n,
                               [&](const auto& report) { RunRoads(bench, report); });
  return kExitOk;
}

/// Which suites take an option; all take --out and --quiet.
constexpr std::pair<const char*, const char*> kTakenBy[] = {
    {"instances", "decisions missions arrivals paper paper-long"},
    {"scales", "scale missions"},
    {"loads", "arrivals"},
    {"scenarios", "roads"},
    {"closed", "roads"},
    {"methods", "decisions scale small-missions missions arrivals roads paper paper-long"},
    {"seeds",
     "decisions scale hard random random-missions small-missions arrivals paper paper-long"},
    {"cbc", "hard"},
    {"repetitions", "decisions scale missions"},
    {"threads", "decisions scale hard random"},
    {"plot", "decisions scale missions arrivals"},
    {"processes", "missions"},
    {"runs", "missions"},
    {"limit", "missions"},
    {"availability", "scale paper paper-long"},
    {"data", "arrivals paper paper-long"},
    {"jobs", "paper paper-long"},
    {"list-jobs", "paper paper-long"},
    {"merge", "paper paper-long"},
};

/// Throws InputError where an option is given that the suite does not take.
void CheckTaken(const std::string& suite, const Arguments& arguments) {
  for (const auto& [option, suites] : kTakenBy) {
    const std::vector<std::string> takers = Split(suites, ' ');
    if (!arguments.Has(option) || std::count(takers.begin(), takers.end(), suite) > 0) continue;
    throw InputError("command line", fmt::format("--{}", option), "suite " + suite,
                     fmt::format("--suite {}", fmt::join(takers, ", ")));
  }
  if (arguments.Has("plot") && !arguments.Has("out")) {
    throw InputError("command line", "--out", "nothing", "the CSV file that --plot draws");
  }
}

}  // namespace

int BenchCommand(int argc, const char* const* argv) {
  Options options("muster bench", "Times decisions and missions; writes one CSV row a run.");
  AddBenchOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const auto suite = arguments->Get("suite");
  CheckTaken(suite, *arguments);
  if (suite == "decisions" || suite == "scale")
    return DecisionsCommand(*arguments, suite == "scale");
  if (suite == "hard" || suite == "random") return HardCommand(*arguments, suite == "random");
  if (suite == "random-missions") return RandomMissionsCommand(*arguments);
  if (suite == "small-missions") return SmallMissionsCommand(*arguments);
  if (suite == "missions") return MissionsCommand(*arguments);
  if (suite == "arrivals") return ArrivalsCommand(*arguments);
  if (suite == "roads") return RoadsCommand(*arguments);
  return PaperCommand(*arguments);
}

}  // namespace muster::tools
