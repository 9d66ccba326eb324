#include "tools/bench/bench_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "scheduler/policies/registry.h"
#include "tools/bench/arrivals_suite.h"
#include "tools/bench/hard_suite.h"
#include "tools/bench/mission_suite.h"
#include "tools/bench/missions_command.h"
#include "tools/bench/paper_command.h"
#include "tools/bench/suites.h"
#include "tools/host/progress.h"

namespace muster::tools {
namespace {

void WriteWhole(const std::string& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.close();
  if (!out) throw SystemError(fmt::format("{}: cannot be written", file));
}

void AddBenchOptions(Options* options) {
  options
      ->Add(
          "suite", "SUITE",
          "decisions (of missions on the paper's data sets), scale (growing Random_29), hard "
          "(families that are hard to prove), random (drawn settings), missions (whole ones over "
          "LCM), arrivals (tasks that are reported meanwhile), paper (its experiments: completion "
          "rates) or paper-long (the runs of those that take longest)")
      .OneOf(
          {"decisions", "scale", "hard", "random", "missions", "arrivals", "paper", "paper-long"})
      .Default("decisions");
  options->Add("instances", "NAME,...", "Settings (default: all of the suite)").List();
  options->Add("scales", "X,...", "scale, missions: times Random_29's size")
      .List()
      .Number(Above0(1000))
      .Default("1,3,10,30,100");
  options
      ->Add("loads", "X,...", "arrivals: tasks, times those of Random_1 or of the data set's shape")
      .List()
      .Number(Above0(100))
      .Default("0.5,1,2");
  options->Add("methods", "NAME,...", "Policies (default: certified; paper, arrivals: several)")
      .List();
  options->Add("seeds", "N", "Scenarios of each setting (default: 1; paper, arrivals: 10)")
      .Integer(1, 10'000);
  options->Add("cbc", "WHAT", "hard: what COIN-OR CBC is asked for, where it is installed")
      .OneOf({"nothing", "relaxation", "optimum"})
      .Default("optimum");
  options->Add("first-seed", "N", "Their first seed").Integer(1, 1'000'000).Default(1);
  options->Add("repetitions", "N", "Runs of each decision").Integer(1, 10'000).Default(1);
  options->Add("threads", "N", "certified: 1 or 2").Integer(1, 2).Default(1);
  options->Out("FILE", "CSV file; paper: folder for rows, tables and page");
  options->Add("plot", "FILE", "gnuplot script that draws time against size from the CSV file");
}

BenchOptions ReadBenchOptions(const Arguments& arguments) {
  BenchOptions bench;
  bench.methods = arguments.All("methods");
  if (bench.methods.empty()) bench.methods = {"certified"};
  for (const std::string& method : bench.methods) scheduler::MakePolicy(method);
  bench.instances = arguments.All("instances");
  for (const std::string& name : bench.instances) PresetByName(name);
  if (bench.instances.empty()) {
    for (const GeneratorSettings& preset : Presets()) bench.instances.push_back(preset.name);
  }
  bench.scales = arguments.All<double>("scales");
  arguments.Read("seeds", &bench.seeds);
  bench.first_seed = arguments.Get<int>("first-seed");
  bench.repetitions = arguments.Get<int>("repetitions");
  bench.threads = arguments.Get<int>("threads");
  if (arguments.Has("availability")) {
    const auto modes = arguments.All("availability");
    if (modes.size() != 1) {
      throw InputError("command line", "--availability", fmt::format("{}", fmt::join(modes, ",")),
                       "strict or overrun");
    }
    if (modes[0] == "overrun") bench.availability = Availability::kOverrun;
  }
  return bench;
}

int HardCommand(const Arguments& arguments, const std::string& suite) {
  HardOptions options;
  arguments.Read("seeds", &options.seeds);
  options.first_seed = arguments.Get<int>("first-seed");
  options.threads = arguments.Get<int>("threads");
  const auto ask = arguments.Get("cbc");
  options.ask = ask == "nothing"      ? AskCbc::kNothing
                : ask == "relaxation" ? AskCbc::kRelaxation
                                      : AskCbc::kOptimum;
  std::ofstream csv;
  if (arguments.Has("out")) {
    csv.open(arguments.Get("out"));
    if (!csv) throw SystemError(fmt::format("{}: cannot be written", arguments.Get("out")));
    csv << HardCsvHeader();
  }
  std::vector<HardRow> rows;
  const auto report = [&](const HardRow& row) {
    rows.push_back(row);
    if (csv.is_open()) csv << ToCsv(row) << std::flush;
  };
  fmt::print("seeds {} to {}; times are processor time\n", options.first_seed,
             options.first_seed + options.seeds - 1);
  if (suite == "hard") {
    for (const HardFamily& family : HardFamilies()) {
      fmt::print("{}: {}\n", family.name, family.flags);
    }
    if (!RunHard(options, report)) {
      fmt::print("COIN-OR CBC (libCbcSolver.so.3) is not installed: nothing to compare with\n");
    }
  } else {
    fmt::print("{}", RandomSettingsLimits());
    RunRandomSettings(options, report);
  }
  if (csv.is_open() && !csv) throw SystemError("the CSV file cannot be written");
  fmt::print("{}", SummaryOf(rows));
  return kExitOk;
}

int ArrivalsCommand(const Arguments& arguments) {
  ArrivalsOptions options;
  options.policies = arguments.All("methods");
  if (options.policies.empty()) {
    options.policies = {"kwta", "mpq", "certified", "horizon", "rollout", "rollout-steps"};
  }
  for (const std::string& policy : options.policies) scheduler::MakePolicy(policy);
  arguments.Read("data", &options.data);
  options.instances = arguments.All("instances");
  const auto known = ArrivalsInstances(!options.data.empty());
  for (const std::string& name : options.instances) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw InputError("command line", "--instances", name,
                     fmt::format("{}{}", fmt::join(known, ", "),
                                 options.data.empty() ? "; with --data those of its tables" : ""));
  }
  if (options.instances.empty()) options.instances = known;
  options.loads = arguments.All<double>("loads");
  arguments.Read("seeds", &options.seeds);
  options.first_seed = arguments.Get<int>("first-seed");
  std::string csv = ArrivalsCsvHeader();
  std::vector<ArrivalsRow> rows;
  ProgressPrinter progress(stderr, StyleFor(stderr, false));
  const std::size_t n = options.instances.size() * options.loads.size() *
                        static_cast<std::size_t>(options.seeds) * options.policies.size();
  const auto start = std::chrono::steady_clock::now();
  RunArrivals(options, [&](const ArrivalsRow& row) {
    rows.push_back(row);
    csv += ToCsv(row);
    const auto took_us = std::chrono::duration_cast<std::chrono::microseconds>(
                             std::chrono::steady_clock::now() - start)
                             .count();
    if (progress.due(took_us)) {
      progress.Show(fmt::format("{} of {} missions", rows.size(), n), took_us);
    }
  });
  progress.Break();
  if (arguments.Has("out")) {
    const auto file = arguments.Get("out");
    WriteWhole(file, csv);
    if (arguments.Has("plot")) {
      WriteWhole(arguments.Get("plot"), ArrivalsPlot(rows, file + ".svg"));
    }
  }
  fmt::print("{}", SummaryOf(rows));
  return kExitOk;
}

}  // namespace

int BenchCommand(int argc, const char* const* argv) {
  Options options("muster bench", "Times decisions and missions; writes one CSV row a run.");
  AddBenchOptions(&options);
  AddMissionSuiteOptions(&options);
  AddPaperOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const auto suite = arguments->Get("suite");
  if (suite == "paper" || suite == "paper-long") return PaperCommand(*arguments);
  if (arguments->Has("merge")) {
    throw InputError("command line", "--merge", "suite " + suite, "--suite paper");
  }
  if (suite == "hard" || suite == "random") return HardCommand(*arguments, suite);
  if (arguments->Has("plot") && !arguments->Has("out")) {
    throw InputError("command line", "--out", "nothing", "the CSV file that --plot draws");
  }
  if (suite == "arrivals") return ArrivalsCommand(*arguments);
  if (suite == "missions") {
    if (arguments->Has("plot")) {
      const auto file = arguments->Get("out");
      const auto processes = arguments->All<double>("processes");
      WriteWhole(arguments->Get("plot"),
                 MissionPlotScript(
                     file, file + ".svg",
                     static_cast<int>(*std::max_element(processes.begin(), processes.end()))));
    }
    return MissionsCommand(*arguments);
  }
  const BenchOptions bench = ReadBenchOptions(*arguments);

  std::ofstream csv;
  if (arguments->Has("out")) {
    const auto file = arguments->Get("out");
    csv.open(file);
    if (!csv) throw SystemError(fmt::format("{}: cannot be written", file));
    csv << CsvHeader();
    if (arguments->Has("plot")) {
      WriteWhole(arguments->Get("plot"), PlotScript(file, file + ".svg"));
    }
  }
  std::vector<BenchRow> rows;
  const auto report = [&](const BenchRow& row) {
    rows.push_back(row);
    if (csv.is_open()) csv << ToCsv(row) << std::flush;
  };
  if (suite == "decisions") {
    RunDecisions(bench, report);
  } else {
    RunScale(bench, report);
  }
  if (csv.is_open() && !csv) throw SystemError("the CSV file cannot be written");
  fmt::print("{}", SummaryOf(rows));
  return kExitOk;
}

}  // namespace muster::tools
