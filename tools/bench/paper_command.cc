#include "tools/bench/paper_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "scheduler/policies/registry.h"
#include "tools/bench/paper_suite.h"

namespace muster::tools {
void AddPaperOptions(Options* options) {
  const auto cores = std::max(1U, std::thread::hardware_concurrency());
  options->Group("Suites paper, paper-long");
  options->Add("jobs", "N", "Missions at a time").Integer(1, 1000).Default(cores);
  options->Add("availability", "MODE,...", "Modes")
      .List()
      .OneOf({"strict", "overrun"})
      .Default("strict,overrun");
  options->Add(
      "data", "DIR",
      "also arrivals: folder with the tables of imported places (docs/guide/import.md); without "
      "it drawn places only");
  options->Flag("list-jobs",
                "Print the runs as commands, one a line, for GNU parallel or a Slurm array");
  options->Add("merge", "DIR...", "Put the rows that such jobs wrote into these folders together")
      .List();
  options->RestBelongsTo("merge");
  options->Quiet();
}

int PaperCommand(const Arguments& arguments) {
  PaperOptions options;
  options.filter.longer = arguments.Get("suite") == "paper-long";
  options.filter.settings = arguments.All("instances");
  options.filter.policies = arguments.All("methods");
  for (const std::string& policy : options.filter.policies) {
    const std::vector<std::string> learned = LearnedColumns();
    const bool is_model = std::find(learned.begin(), learned.end(), policy) != learned.end();
    if (policy != kUpperBound && !is_model) scheduler::MakePolicy(policy);
  }
  if (arguments.Has("availability")) options.filter.availability = arguments.All("availability");
  arguments.Read("seeds", &options.filter.seeds);
  options.filter.first_seed = arguments.Get<std::uint64_t>("first-seed");
  options.jobs = arguments.Get<int>("jobs");
  arguments.Read("data", &options.data);
  options.quiet = arguments.Has("quiet");
  if (!arguments.Has("out")) {
    throw InputError("command line", "--out", "nothing", "a folder for rows, tables and page");
  }
  options.out = arguments.Get("out");

  if (arguments.Has("list-jobs")) {
    ListPaperJobs(options, "muster");
    return kExitOk;
  }
  if (arguments.Has("merge")) {
    MergePaperRuns(options, arguments.All("merge"));
    return kExitOk;
  }
  return RunPaperSuite(options) ? kExitOk : kExitCheckFailed;
}

}  // namespace muster::tools
