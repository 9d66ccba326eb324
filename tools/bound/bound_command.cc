#include "tools/bound/bound_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "protocol/run_process.h"
#include "tools/bound/schedule_bound.h"
#include "tools/bound/upper_bound.h"
#include "tools/host/progress.h"
#include "tools/scenario/mission_options.h"

namespace muster::tools {
namespace {

constexpr std::int64_t kMostEffort = 1000, kRoundsEach = 100;
/// Beyond, ways between tasks take gigabytes.
constexpr std::size_t kMostTasks = 5000;

/// The bound of ScheduleBound() in whole tasks, with its progress on stderr.
std::int64_t Search(const Scenario& scenario, std::int64_t effort) {
  if (scenario.n_tasks() > kMostTasks) {
    throw InputError("command line", "--effort", fmt::format("{} tasks", scenario.n_tasks()),
                     fmt::format("a scenario of at most {} tasks", kMostTasks));
  }
  if (scenario.rules.start_on_meeting) {
    throw InputError("command line", "--effort", "a scenario with start_on_meeting",
                     "a scenario without it");
  }
  ProgressPrinter printer(stderr, StyleFor(stderr, false));
  const double bound =
      ScheduleBound(scenario, effort * kRoundsEach, [&](std::int64_t round, double best) {
        const TimeUs now_us = MonotonicUs();
        if (!printer.due(now_us)) return;
        printer.Show(
            fmt::format("round {} of {}: at most {:.1f}", round, effort * kRoundsEach, best),
            now_us);
      });
  printer.Break();
  return WholeTasks(bound);
}

}  // namespace

int BoundCommand(int argc, const char* const* argv) {
  Options options("muster bound",
                  "Tells how many of a scenario's tasks any policy could do at most, even one that "
                  "knows everything beforehand.");
  AddRuleOptions(&options);
  options
      .Add("effort", "N",
           "Search for a tighter bound, which counts ways between tasks, range and charging")
      .Integer(1, kMostEffort);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const Scenario scenario = ResolveScenario(ReadRuleOptions(*arguments));
  std::int64_t bound = UpperBound(scenario);
  if (arguments->Has("effort")) {
    bound = std::min(bound, Search(scenario, arguments->Get<std::int64_t>("effort")));
  }
  const std::size_t tasks = scenario.n_tasks();
  fmt::print("at most {} of {} tasks ({:.1f} %)\n", bound, tasks,
             tasks == 0 ? 0.0 : 100.0 * static_cast<double>(bound) / static_cast<double>(tasks));
  return kExitOk;
}

}  // namespace muster::tools
