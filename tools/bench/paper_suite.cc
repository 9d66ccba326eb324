#include "tools/bench/paper_suite.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <map>
#include <set>

#include "base/check.h"
#include "base/say.h"
#include "protocol/run_process.h"
#include "tools/bench/paper_page.h"
#include "tools/bench/paper_rows.h"
#include "tools/bench/paper_scenarios.h"
#include "tools/bench/sheet.h"
#include "tools/host/progress.h"
#include "tools/host/worker_pool.h"
#include "tools/record/report_json.h"

namespace muster::tools {
namespace {

std::string FileIn(const std::string& folder, const char* name) {
  return (std::filesystem::path(folder) / name).string();
}

constexpr const char* kRows = "runs.csv";

void CheckSame(const std::string& file, const PaperRun& run, const char* what,
               const std::string& found, const std::string& expected) {
  if (found == expected) return;
  throw InputError(file, fmt::format("{} of {}", what, NameOf(run)), found,
                   expected +
                       ": rows of different programs or places do not mix; take another "
                       "--out folder or delete this one");
}

void WriteResults(const PaperOptions& options, const PaperRows& rows) {
  WriteFile(FileIn(options.out, kRows), PaperCsv(rows));
  const auto note =
      WritePaperPage(rows, FileIn(options.out, "results.md"), FileIn(options.out, "results.html"));
  if (!note.empty()) Say("{}\n", note);
}

/// What of the suite can be flown here; says what not.
std::vector<PaperRun> PlanOf(const PaperOptions& options, const PaperScenarios& scenarios) {
  PaperFilter filter = options.filter;
  filter.with_imports = scenarios.HasImports();
  if (!filter.with_imports) {
    Say("without --data: drawn places only, not {}\n", fmt::join(ImportedSettings::Names(), ", "));
  }
  std::vector<PaperRun> plan = PlanRuns(filter);
  if (plan.empty()) throw InputError("options", "filters", "no run", "settings of the suite");
  return plan;
}

/// The rows that `file` has from before. Throws InputError where they are not of this build and
/// these places.
PaperRows RowsOf(const std::string& file, const std::string& build,
                 const std::set<std::string>& settings, PaperScenarios* scenarios) {
  PaperRows rows = ReadPaperCsv(file);
  for (const auto& [run, row] : rows) {
    CheckSame(file, run, "build", row.build, build);
    if (settings.contains(run.what.setting)) {
      CheckSame(file, run, "places", row.places, scenarios->PlacesOf(run.what.setting));
    }
  }
  return rows;
}

/// Of the runs of a setting and a policy: the folder that a job writes to.
std::string JobName(const std::string& setting, const std::string& policy) {
  return fmt::format("{}.{}", setting, policy);
}

void CheckNoneIsMissing(const std::vector<PaperRun>& plan, const PaperRows& rows) {
  std::size_t missing = 0;
  std::set<std::string> jobs;
  std::string first;
  for (const PaperRun& run : plan) {
    if (rows.contains(run)) continue;
    ++missing;
    if (first.empty()) first = NameOf(run);
    jobs.insert(JobName(run.what.setting, run.policy));
  }
  if (missing == 0) return;
  throw InputError(
      "command line", "--merge",
      fmt::format("{} of {} runs missing, the first {}", missing, plan.size(), first),
      fmt::format("the rows of all runs: run these jobs again: {}", fmt::join(jobs, ", ")));
}

/// All policies on one mission: making a scenario from a table of places takes longer than most of
/// the missions.
using PaperJob = std::vector<PaperRun>;

/// The runs of `plan` that have no row yet.
std::vector<PaperJob> JobsOf(const std::vector<PaperRun>& plan, const PaperRows& rows) {
  std::vector<PaperJob> jobs;
  for (const PaperRun& run : plan) {
    if (rows.contains(run)) continue;
    if (jobs.empty() || jobs.back()[0].what != run.what || jobs.back()[0].seed != run.seed) {
      jobs.emplace_back();
    }
    jobs.back().push_back(run);
  }
  return jobs;
}

/// How many of the runs have ended, on stderr.
class SuiteProgress {
 public:
  SuiteProgress(std::size_t runs, bool quiet)
      : style_(StyleFor(stderr, quiet)), progress_(stderr, style_), runs_(runs) {}

  void Ended(const PaperJob& job) {
    ended_ += job.size();
    const TimeUs took = MonotonicUs() - start_us_;
    // Hours of lines in a file are to be read, too.
    const TimeUs rarely_us = style_ == ProgressPrinter::Style::kLines ? 30 * kSecondUs : 0;
    if (!progress_.due(took) || (took - shown_us_ < rarely_us && ended_ < runs_)) return;
    shown_us_ = took;
    const double all =
        static_cast<double>(took) * static_cast<double>(runs_) / static_cast<double>(ended_);
    progress_.Show(fmt::format("{} of {} runs, {} gone, about {} left", ended_, runs_,
                               ClockText(took), ClockText(static_cast<TimeUs>(all) - took)),
                   took);
  }
  void Failed(const PaperJob& job, const std::string& why) {
    Break();
    Say("{}, and the other runs of that mission that were left: {}\n", NameOf(job[0]), why);
    Ended(job);
  }
  void Break() { progress_.Break(); }

 private:
  const ProgressPrinter::Style style_;
  ProgressPrinter progress_;
  const std::size_t runs_;
  std::size_t ended_ = 0;
  TimeUs shown_us_ = 0;
  const TimeUs start_us_ = MonotonicUs();
};

/// The rows of one job.
std::string Fly(const PaperJob& job, const std::string& build, PaperScenarios* scenarios) {
  Scenario scenario = scenarios->Make(job[0]);
  std::string lines;
  for (const PaperRun& run : job) {
    scenario.rules.start_on_meeting = MovesByCells(run.policy);
    PaperRow row = FlyPaperRun(run, scenario);
    row.build = build;
    row.places = scenarios->PlacesOf(run.what.setting);
    lines += PaperCsvLine(run, row);
  }
  return lines;
}

}  // namespace

bool RunPaperSuite(const PaperOptions& options) {
  PaperScenarios scenarios(options.data);
  const std::vector<PaperRun> plan = PlanOf(options, scenarios);
  std::set<std::string> settings;
  for (const PaperRun& run : plan) settings.insert(run.what.setting);
  for (const std::string& setting : settings) scenarios.Prepare(setting);

  std::filesystem::create_directories(options.out);
  const std::string file = FileIn(options.out, kRows);
  const std::string build = BuildName();
  const PaperRows before = RowsOf(file, build, settings, &scenarios);
  const std::vector<PaperJob> jobs = JobsOf(plan, before);
  std::size_t left = 0, failures = 0;
  for (const PaperJob& job : jobs) left += job.size();
  if (left < plan.size() && !options.quiet) {
    Say("{}: {} of {} runs are done already\n", file, plan.size() - left, plan.size());
  }
  {
    WriteFile(file, PaperCsv(before));
    RowFile journal(file, "");
    SuiteProgress progress(left, options.quiet);
    RunInProcesses(
        jobs.size(), options.jobs,
        [&](std::size_t job) { return Fly(jobs[job], build, &scenarios); },
        [&](std::size_t job, const std::string& lines) {
          journal.Add(lines);
          progress.Ended(jobs[job]);
        },
        [&](std::size_t job, const std::string& why) {
          failures += jobs[job].size();
          progress.Failed(jobs[job], why);
        });
    progress.Break();
  }
  WriteResults(options, ReadPaperCsv(file));
  fmt::print("{} runs, {} failed; rows, tables and page: {}\n", plan.size(), failures, options.out);
  return failures == 0;
}

void ListPaperJobs(const PaperOptions& options, const std::string& program) {
  std::set<std::pair<std::string, std::string>> jobs;
  std::set<std::string> availability;
  for (const PaperRun& run : PlanOf(options, PaperScenarios(options.data))) {
    jobs.emplace(run.what.setting, run.policy);
    availability.emplace(NameOf(run.what.availability));
  }
  const PaperFilter& filter = options.filter;
  for (const auto& [setting, policy] : jobs) {
    fmt::print(
        "{} bench --suite {} --instances {} --methods {} --availability {} --first-seed {} "
        "--seeds {}{} --jobs 1 --quiet --out {}\n",
        program, filter.longer ? "paper-long" : "paper", setting, policy,
        fmt::join(availability, ","), filter.first_seed, filter.seeds,
        options.data.empty() ? "" : " --data " + options.data,
        FileIn(options.out, JobName(setting, policy).c_str()));
  }
}

void MergePaperRuns(const PaperOptions& options, const std::vector<std::string>& folders) {
  PaperRows all;
  std::map<PaperRun, std::string> files;
  std::map<std::string, std::string> places;  // by setting
  for (const std::string& folder : folders) {
    const std::string file = FileIn(folder, kRows);
    const PaperRows rows = ReadPaperCsv(file);
    if (rows.empty()) throw InputError(file, "rows", "none", "those of a finished job");
    for (const auto& [run, row] : rows) {
      CheckSame(file, run, "build", row.build, all.empty() ? row.build : all.begin()->second.build);
      CheckSame(file, run, "places", row.places,
                places.emplace(run.what.setting, row.places).first->second);
      const auto [at, added] = all.emplace(run, row);
      if (!added) CheckSame(file, run, "digest", row.digest, at->second.digest);
      if (!files.emplace(run, file).second) {
        throw InputError(file, NameOf(run), "the same run in " + files[run], "each run once");
      }
    }
  }
  CheckNoneIsMissing(PlanOf(options, PaperScenarios(options.data)), all);
  std::filesystem::create_directories(options.out);
  WriteResults(options, all);
  fmt::print("{} runs of {} folders; rows, tables and page: {}\n", all.size(), folders.size(),
             options.out);
}

}  // namespace muster::tools
