#include "tools/trials/faults_command.h"

#include <fmt/format.h>

#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <string_view>
#include <thread>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tools/faults/random_plan.h"
#include "tools/faults/score.h"
#include "tools/files/run_directory.h"
#include "tools/host/child.h"
#include "tools/host/stop_signals.h"
#include "tools/log/log_source.h"
#include "tools/record/digest.h"
#include "tools/trials/campaign_command.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

/// Runs `muster run` and waits for it; a signal to us is handed on.
int RunMuster(std::vector<std::string> arguments, const std::string& output_file,
              const StopSignals& stop) {
  arguments.insert(arguments.begin(), "/proc/self/exe");
  Child child({"muster", std::move(arguments), output_file});
  int told = 0;
  while (!child.Poll()) {
    for (; told < stop.count(); ++told) child.Signal(SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const int status = child.Poll()->wait_status;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kExitInternal;
}

FaultEvidence ReadEvidence(const std::string& run, bool undisturbed) {
  FaultEvidence evidence;
  LogSource log(run);
  while (const auto event = log.NextEvent()) evidence.Add(event->packet);
  const RunRecord& record = evidence.record;
  if (undisturbed && record.scenario() && !record.schedules().empty()) {
    RunRecord simulated;
    Simulate(TextOf(*record.scenario()), record.schedules().begin()->second.policy,
             [&](const Packet& packet) { simulated.Add(packet); });
    evidence.undisturbed_digest = Digest(simulated);
  }
  return evidence;
}

int Run(int argc, const char* const* argv) {
  // What follows -- is for muster run.
  const auto end = std::find(argv, argv + argc, std::string_view("--"));
  const std::vector<std::string> more(end == argv + argc ? end : end + 1, argv + argc);
  Options options("muster faults run",
                  "Runs a mission under each fault plan and scores what the plan expects.\n"
                  "Exit code 4 when something is missed, or a fault had no visible effect.");
  options.Scenario();
  options.Positional("plans", "PLAN... [-- OPTION of muster run...]")
      .Repeated()
      .Required("a scenario file and fault plans");
  options.Out("DIR", "Where the run directories go, new or empty").Default("runs/faults");
  const auto arguments = options.Parse(static_cast<int>(end - argv), argv);
  if (!arguments) return kExitOk;
  const std::string scenario = arguments->Get("scenario");
  const auto files = arguments->All("plans");
  std::vector<FaultPlan> plans;
  for (const std::string& file : files) plans.push_back(LoadFaultPlan(file));
  const StopSignals stop;
  LoadScenario(scenario);  // what cannot be is said before the first file
  const RunDirectory out = RunDirectory::Take(arguments->Get("out"));

  std::size_t missed = 0;
  for (std::size_t i = 0; i < plans.size() && stop.count() == 0; ++i) {
    const std::string name = fmt::format("{}-{}", i + 1, fs::path(files[i]).stem().string());
    const std::string run = out.File(name);
    const std::string said = out.File(name + ".txt");
    std::vector<std::string> command = {"run",   scenario, "--faults", files[i],
                                        "--out", run,      "--quiet"};
    command.insert(command.end(), more.begin(), more.end());
    const int code = RunMuster(std::move(command), said, stop);
    if (stop.count() > 0) break;
    if (code == kExitUsage || !fs::exists(fs::path(run) / "report.json")) {
      Say("{}\n", LastLines(said, 3));
      return code == kExitOk ? kExitInternal : code;
    }
    const bool undisturbed =
        std::any_of(plans[i].begin(), plans[i].end(),
                    [](const PlannedFault& fault) { return fault.expect.same_decisions; });
    const FaultEvidence evidence = ReadEvidence(run, undisturbed);
    std::vector<FaultScore> scores = ScoreFaults(plans[i], evidence);
    const bool complete = evidence.record.CheckComplete().complete;
    scores.push_back({"mission", "log complete", "yes", complete ? "yes" : "no", complete, ""});
    const auto missed_here = static_cast<std::size_t>(std::count_if(
        scores.begin(), scores.end(), [](const FaultScore& score) { return !score.met; }));
    missed += missed_here;
    fmt::print("{} in {}\n{}", files[i], run, ToTable(scores));
    if (code != kExitOk && missed_here == 0) {
      fmt::print("muster run ended with exit code {}:\n{}\n", code, LastLines(said, 5));
      ++missed;
    }
    std::fflush(stdout);
  }
  if (stop.count() > 0) return kExitInterrupted;
  fmt::print("{}\n", missed == 0 ? "all met" : fmt::format("{} missed", missed));
  return missed == 0 ? kExitOk : kExitCheckFailed;
}

int Draw(int argc, const char* const* argv) {
  Options options("muster faults random",
                  "Draws a fault plan for a scenario and writes it to stdout.");
  options.Scenario();
  options.Add("seed", "N", "Seed of the draw").Seed().Default(1);
  options.Add("rate", "R", "Faults per mission hour, on average").Number(Above0(1000)).Default(4);
  options.Add("kinds", "KIND,...", "Kinds to draw from (default: all but corruption)").List();
  options
      .Add("on-loss", "wait|continue",
           "What the mission will be run with: with continue some faults last in mission time")
      .OneOf({"wait", "continue"})
      .Default("wait");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  RandomPlanSettings settings;
  settings.seed = arguments->Get<std::uint64_t>("seed");
  settings.rate_per_hour = arguments->Get<double>("rate");
  settings.goes_on = arguments->Get("on-loss") == "continue";
  settings.kinds = AllSurvivableKinds();
  if (arguments->Has("kinds")) {
    settings.kinds.clear();
    for (const std::string& name : arguments->All("kinds")) {
      settings.kinds.push_back(KindByName(name, "command line", "--kinds"));
    }
  }
  const Scenario scenario = LoadScenario(arguments->Get("scenario"));
  fmt::print("{}", ToJson(DrawPlan(scenario, settings)));
  return kExitOk;
}

int Drop(int argc, const char* const* argv) {
  Options options("muster faults drop",
                  "Writes a plan by which a share of all agents fails for good at once.");
  options.Scenario();
  options.Add("share", "P", "Share of each class, 0 to 1").Number({0, 1}).Required("a share");
  options.Add("at-min", "T", "When, mission minutes").Number().Required("mission minutes");
  options.Add("seed", "N", "Seed of the draw of the agents that fail").Seed().Default(1);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const Scenario scenario = LoadScenario(arguments->Get("scenario"));
  const auto at_min = arguments->Get<double>("at-min");
  if (!(at_min >= 0 && at_min < ToMinutes(scenario.rules.limit_us))) {
    throw InputError(
        "command line", "--at-min", fmt::to_string(at_min),
        fmt::format("from 0 to below the limit, {} min", ToMinutes(scenario.rules.limit_us)));
  }
  fmt::print("{}", ToJson(DropPlan(scenario, arguments->Get<double>("share"), ToUs(at_min * 60),
                                   arguments->Get<std::uint64_t>("seed"))));
  return kExitOk;
}

}  // namespace

int FaultsCommand(int argc, const char* const* argv) {
  static const std::vector<Command> commands = {
      {"run", "runs a mission under fault plans and scores what they expect", Run},
      {"random", "draws a fault plan", Draw},
      {"drop", "writes a plan by which a share of all agents fails", Drop},
      {"campaign", "audits missions under random plans, and finds the smallest plan that fails",
       CampaignCommand},
  };
  return RunCommandOf(argv[0], "Faults on purpose (docs/guide/faults.md)", commands, argc, argv);
}

}  // namespace muster::tools
