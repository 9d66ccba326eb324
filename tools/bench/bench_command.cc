#include "tools/bench/bench_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "lcmtypes/protocol/program.h"
#include "scheduler/policy.h"
#include "tools/bench/suites.h"
#include "world/model/check.h"

namespace muster::tools {
namespace {

int Positive(const cxxopts::ParseResult& flags, const char* name, int most) {
  const int value = flags[name].as<int>();
  if (value < 1 || value > most) {
    throw InputError("options", std::string("--") + name, fmt::to_string(value),
                     fmt::format("a number from 1 to {}", most));
  }
  return value;
}

void WriteWhole(const std::string& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.close();
  if (!out) throw SystemError(fmt::format("{}: cannot be written", file));
}

}  // namespace

int BenchCommand(int argc, const char* const* argv) {
  cxxopts::Options options("muster bench", "Times decisions; writes one CSV row a run.");
  const auto list = [](const char* text) {
    return cxxopts::value<std::vector<std::string>>()->default_value(text);
  };
  options.add_options()(
      "suite", "decisions (of missions on the paper's data sets) or scale (growing Random_29)",
      cxxopts::value<std::string>()->default_value("decisions"),
      "SUITE")("instances", "decisions: presets (default: all 32)",
               cxxopts::value<std::vector<std::string>>(),
               "NAME,...")("scales", "scale: times Random_29's size",
                           cxxopts::value<std::vector<double>>()->default_value("1,3,10,30,100"),
                           "X,...")("methods", "Policies to time", list("certified"), "NAME,...")(
      "seeds", "Scenarios of each setting: seeds 1 to N", cxxopts::value<int>()->default_value("1"),
      "N")("repetitions", "Runs of each decision", cxxopts::value<int>()->default_value("1"), "N")(
      "threads", "certified: 1 or 2", cxxopts::value<int>()->default_value("1"), "N")(
      "out", "CSV file", cxxopts::value<std::string>(), "FILE")(
      "plot", "gnuplot script that draws time against size from the CSV file",
      cxxopts::value<std::string>(), "FILE");
  const auto flags = ParseOptions(&options, argc, argv);
  if (!flags) return kExitOk;
  const auto suite = (*flags)["suite"].as<std::string>();
  if (suite != "decisions" && suite != "scale") {
    throw InputError("options", "--suite", suite, "decisions or scale");
  }
  BenchOptions bench;
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
  bench.seeds = Positive(*flags, "seeds", 10000);
  bench.repetitions = Positive(*flags, "repetitions", 10000);
  bench.threads = Positive(*flags, "threads", 2);
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
