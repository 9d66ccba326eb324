#include "tools/bench/bench_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/program.h"
#include "scheduler/policies/registry.h"
#include "tools/bench/paper_command.h"
#include "tools/bench/suites.h"

namespace muster::tools {
namespace {

void WriteWhole(const std::string& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.close();
  if (!out) throw SystemError(fmt::format("{}: cannot be written", file));
}

}  // namespace

int BenchCommand(int argc, const char* const* argv) {
  cxxopts::Options options("muster bench", "Times decisions; writes one CSV row a run.");
  options.add_options()(
      "suite",
      "decisions (of missions on the paper's data sets), scale (growing Random_29), paper (its "
      "experiments: completion rates) or paper-long (the runs of those that take longest)",
      cxxopts::value<std::string>()->default_value("decisions"),
      "SUITE")("instances", "Settings (default: all of the suite)",
               cxxopts::value<std::vector<std::string>>(),
               "NAME,...")("scales", "scale: times Random_29's size",
                           cxxopts::value<std::vector<double>>()->default_value("1,3,10,30,100"),
                           "X,...")("methods", "Policies (default: certified; paper: all)",
                                    cxxopts::value<std::vector<std::string>>(), "NAME,...")(
      "seeds", "Scenarios of each setting (default: 1; paper: 10)", cxxopts::value<int>(), "N")(
      "first-seed", "Their first seed", cxxopts::value<int>()->default_value("1"), "N")(
      "repetitions", "Runs of each decision", cxxopts::value<int>()->default_value("1"), "N")(
      "threads", "certified: 1 or 2", cxxopts::value<int>()->default_value("1"), "N")(
      "out", "CSV file; paper: folder for rows, tables and page", cxxopts::value<std::string>(),
      "FILE")("plot", "gnuplot script that draws time against size from the CSV file",
              cxxopts::value<std::string>(), "FILE");
  AddPaperOptions(&options);
  options.parse_positional({"merge"});
  const auto flags = ParseOptions(&options, argc, argv);
  if (!flags) return kExitOk;
  const auto suite = (*flags)["suite"].as<std::string>();
  if (suite == "paper" || suite == "paper-long") return PaperCommand(*flags);
  if (flags->count("merge") > 0) {
    throw InputError("options", "--merge", "suite " + suite, "--suite paper");
  }
  if (suite != "decisions" && suite != "scale") {
    throw InputError("options", "--suite", suite, "decisions, scale, paper or paper-long");
  }
  BenchOptions bench;
  bench.methods = {"certified"};
  if (flags->count("methods") > 0)
    bench.methods = (*flags)["methods"].as<std::vector<std::string>>();
  for (const std::string& method : bench.methods) scheduler::MakePolicy(method);
  if (flags->count("instances") > 0) {
    bench.instances = (*flags)["instances"].as<std::vector<std::string>>();
    for (const std::string& name : bench.instances) PresetByName(name);
  } else {
    for (const GeneratorSettings& preset : Presets()) bench.instances.push_back(preset.name);
  }
  bench.scales = (*flags)["scales"].as<std::vector<double>>();
  for (const double scale : bench.scales) {
    if (!(scale > 0 && scale <= 1000)) {
      throw InputError("options", "--scales", fmt::to_string(scale), "numbers above 0 up to 1000");
    }
  }
  if (flags->count("seeds") > 0) bench.seeds = PositiveOption(*flags, "seeds", 10000);
  bench.first_seed = PositiveOption(*flags, "first-seed", 1000000);
  bench.repetitions = PositiveOption(*flags, "repetitions", 10000);
  if (flags->count("availability") > 0) {
    const auto modes = (*flags)["availability"].as<std::vector<std::string>>();
    if (modes.size() != 1 || (modes[0] != "strict" && modes[0] != "overrun")) {
      throw InputError("options", "--availability", fmt::format("{}", fmt::join(modes, ",")),
                       "strict or overrun");
    }
    if (modes[0] == "overrun") bench.availability = Availability::kOverrun;
  }
  bench.threads = PositiveOption(*flags, "threads", 2);
  if (flags->count("plot") > 0 && flags->count("out") == 0) {
    throw InputError("options", "--out", "nothing", "the CSV file that --plot draws");
  }

  std::ofstream csv;
  if (flags->count("out") > 0) {
    const auto file = (*flags)["out"].as<std::string>();
    csv.open(file);
    if (!csv) throw SystemError(fmt::format("{}: cannot be written", file));
    csv << CsvHeader();
    if (flags->count("plot") > 0) {
      WriteWhole((*flags)["plot"].as<std::string>(), PlotScript(file, file + ".svg"));
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
