#include "tools/bench/paper_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "base/check.h"
#include "base/program.h"
#include "scheduler/policies/registry.h"
#include "tools/bench/paper_suite.h"

namespace muster::tools {
namespace {

std::vector<std::string> List(const cxxopts::ParseResult& flags, const char* name) {
  if (flags.count(name) == 0) return {};
  return flags[name].as<std::vector<std::string>>();
}

}  // namespace

int PositiveOption(const cxxopts::ParseResult& flags, const char* name, int most) {
  const int value = flags[name].as<int>();
  if (value < 1 || value > most) {
    throw InputError("options", std::string("--") + name, fmt::to_string(value),
                     fmt::format("a number from 1 to {}", most));
  }
  return value;
}

void AddPaperOptions(cxxopts::Options* options) {
  const auto cores = std::max(1U, std::thread::hardware_concurrency());
  options->add_options("Suites paper, paper-long")(
      "jobs", "Missions at a time", cxxopts::value<int>()->default_value(std::to_string(cores)),
      "N")("availability", "Modes",
           cxxopts::value<std::vector<std::string>>()->default_value("strict,overrun"),
           "MODE,...")("data", "Folder with the tables of imported places (docs/import.md)",
                       cxxopts::value<std::string>()->default_value("../shared/data"), "DIR")(
      "paper", "The paper's own figures",
      cxxopts::value<std::string>()->default_value("../shared/paper/results.csv"), "FILE")(
      "list-jobs", "Print the runs as commands, one a line, for GNU parallel or a Slurm array")(
      "merge", "Put the rows of such jobs' folders together",
      cxxopts::value<std::vector<std::string>>(),
      "DIR...")("q,quiet", "No progress on stderr, only errors");
}

int PaperCommand(const cxxopts::ParseResult& flags) {
  PaperOptions options;
  options.filter.longer = flags["suite"].as<std::string>() == "paper-long";
  options.filter.settings = List(flags, "instances");
  options.filter.policies = List(flags, "methods");
  for (const std::string& policy : options.filter.policies) {
    if (policy != kUpperBound) scheduler::MakePolicy(policy);
  }
  options.filter.availability = List(flags, "availability");
  for (const std::string& mode : options.filter.availability) {
    if (mode != "strict" && mode != "overrun") {
      throw InputError("options", "--availability", mode, "strict, overrun or both");
    }
  }
  if (flags.count("seeds") > 0) options.filter.seeds = PositiveOption(flags, "seeds", 10000);
  options.filter.first_seed =
      static_cast<std::uint64_t>(PositiveOption(flags, "first-seed", 1000000));
  options.jobs = PositiveOption(flags, "jobs", 1000);
  options.data = flags["data"].as<std::string>();
  options.published = flags["paper"].as<std::string>();
  options.quiet = flags.count("quiet") > 0;
  if (flags.count("out") == 0) {
    throw InputError("options", "--out", "nothing", "a folder for rows, tables and page");
  }
  options.out = flags["out"].as<std::string>();

  if (flags.count("list-jobs") > 0) {
    ListPaperJobs(options, "muster");
    return kExitOk;
  }
  if (flags.count("merge") > 0) {
    MergePaperRuns(options, List(flags, "merge"));
    return kExitOk;
  }
  return RunPaperSuite(options) ? kExitOk : kExitCheckFailed;
}

}  // namespace muster::tools
