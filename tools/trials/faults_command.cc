#include "tools/trials/faults_command.h"

#include <fmt/format.h>

#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cxxopts.hpp>
#include <filesystem>
#include <string_view>
#include <thread>

#include "base/check.h"
#include "base/program.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tools/faults/random_plan.h"
#include "tools/faults/score.h"
#include "tools/files/run_directory.h"
#include "tools/host/child.h"
#include "tools/host/stop_signals.h"
#include "tools/log/log_source.h"
#include "tools/record/digest.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUsage =
    "Faults on purpose (docs/faults.md)\n\n"
    "Usage: muster faults run SCENARIO PLAN... [OPTION...] [-- OPTION of muster run...]\n"
    "       muster faults random SCENARIO [OPTION...]\n"
    "       muster faults drop SCENARIO --share P --at-min T [--seed N]\n";

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
  while (const auto message = log.Next()) evidence.Add(message->packet);
  const RunRecord& record = evidence.record;
  if (undisturbed && record.scenario() && !record.schedules().empty()) {
    RunRecord simulated;
    Simulate(ScenarioToJson(*record.scenario()), record.schedules().begin()->second.policy,
             [&](const Packet& packet) { simulated.Add(packet); });
    evidence.undisturbed_digest = Digest(simulated);
  }
  return evidence;
}

int Run(int argc, const char* const* argv) {
  // What follows -- is for muster run.
  const auto end = std::find(argv, argv + argc, std::string_view("--"));
  const std::vector<std::string> more(end == argv + argc ? end : end + 1, argv + argc);
  cxxopts::Options parser(
      "muster faults run",
      "Runs a mission under each fault plan and scores what the plan expects.\n"
      "Exit code 4 when something is missed, or a fault had no visible effect.");
  parser.add_options()("scenario", "Scenario file", cxxopts::value<std::string>())(
      "plans", "Fault plans", cxxopts::value<std::vector<std::string>>())(
      "out", "Where the run directories go, new or empty",
      cxxopts::value<std::string>()->default_value("runs/faults"), "DIR");
  parser.positional_help("SCENARIO PLAN... [-- OPTION of muster run...]");
  parser.parse_positional({"scenario", "plans"});
  const auto result = ParseOptions(&parser, static_cast<int>(end - argv), argv);
  if (!result) return kExitOk;
  if (result->count("scenario") == 0 || result->count("plans") == 0) {
    throw InputError("command line", "PLAN", "nothing", "a scenario file and fault plans");
  }
  const std::string scenario = (*result)["scenario"].as<std::string>();
  const auto files = (*result)["plans"].as<std::vector<std::string>>();
  std::vector<FaultPlan> plans;
  for (const std::string& file : files) plans.push_back(LoadFaultPlan(file));
  const StopSignals stop;
  const RunDirectory out = RunDirectory::Take((*result)["out"].as<std::string>());

  std::size_t missed = 0;
  for (std::size_t i = 0; i < plans.size() && stop.count() == 0; ++i) {
    const std::string name = fmt::format("{}-{}", i + 1, fs::path(files[i]).stem().string());
    const std::string run = out.File(name);
    const std::string said = out.File(name + ".txt");
    std::vector<std::string> arguments = {"run",   scenario, "--faults", files[i],
                                          "--out", run,      "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const int code = RunMuster(std::move(arguments), said, stop);
    if (stop.count() > 0) break;
    if (code == kExitUsage || !fs::exists(fs::path(run) / "report.json")) {
      fmt::print(stderr, "{}\n", LastLines(said, 3));
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
  cxxopts::Options parser("muster faults random",
                          "Draws a fault plan for a scenario and writes it to stdout.");
  parser.add_options()("scenario", "Scenario file", cxxopts::value<std::string>())(
      "seed", "Seed of the draw", cxxopts::value<std::uint64_t>()->default_value("1"), "N")(
      "rate", "Faults per mission hour, on average", cxxopts::value<double>()->default_value("4"),
      "R")("kinds", "Kinds to draw from (default: all but corruption)",
           cxxopts::value<std::vector<std::string>>(), "KIND,...")(
      "on-loss",
      "What the mission will be run with: with continue some faults last in mission time",
      cxxopts::value<std::string>()->default_value("wait"), "wait|continue");
  parser.positional_help("SCENARIO");
  parser.parse_positional("scenario");
  const auto result = ParseOptions(&parser, argc, argv);
  if (!result) return kExitOk;
  if (result->count("scenario") == 0) {
    throw InputError("command line", "SCENARIO", "nothing", "a scenario file");
  }
  RandomPlanSettings settings;
  settings.seed = (*result)["seed"].as<std::uint64_t>();
  settings.rate_per_hour = (*result)["rate"].as<double>();
  if (!(settings.rate_per_hour > 0 && settings.rate_per_hour <= 1000)) {
    throw InputError("command line", "--rate", fmt::to_string(settings.rate_per_hour),
                     "a number above 0 to 1000");
  }
  const std::string on_loss = (*result)["on-loss"].as<std::string>();
  if (on_loss != "wait" && on_loss != "continue") {
    throw InputError("command line", "--on-loss", on_loss, "wait or continue");
  }
  settings.goes_on = on_loss == "continue";
  settings.kinds = AllSurvivableKinds();
  if (result->count("kinds") > 0) {
    settings.kinds.clear();
    for (const std::string& name : (*result)["kinds"].as<std::vector<std::string>>()) {
      settings.kinds.push_back(KindByName(name, "command line", "--kinds"));
    }
  }
  const Scenario scenario = LoadScenario((*result)["scenario"].as<std::string>());
  fmt::print("{}", ToJson(DrawPlan(scenario, settings)));
  return kExitOk;
}

int Drop(int argc, const char* const* argv) {
  cxxopts::Options parser("muster faults drop",
                          "Writes a plan by which a share of all agents fails for good at once.");
  parser.add_options()("scenario", "Scenario file", cxxopts::value<std::string>())(
      "share", "Share of each class, 0 to 1", cxxopts::value<double>(), "P")(
      "at-min", "When, mission minutes", cxxopts::value<double>(), "T")(
      "seed", "Seed of who fails", cxxopts::value<std::uint64_t>()->default_value("1"), "N");
  parser.positional_help("SCENARIO");
  parser.parse_positional("scenario");
  const auto result = ParseOptions(&parser, argc, argv);
  if (!result) return kExitOk;
  for (const char* key : {"scenario", "share", "at-min"}) {
    if (result->count(key) == 0) throw InputError("command line", key, "nothing", "a value");
  }
  const double share = (*result)["share"].as<double>();
  if (!(share >= 0 && share <= 1)) {
    throw InputError("command line", "--share", fmt::to_string(share), "a share in [0, 1]");
  }
  const Scenario scenario = LoadScenario((*result)["scenario"].as<std::string>());
  const double at_min = (*result)["at-min"].as<double>();
  if (!(at_min >= 0 && at_min < ToMinutes(scenario.rules.limit_us))) {
    throw InputError(
        "command line", "--at-min", fmt::to_string(at_min),
        fmt::format("from 0 to below the limit, {} min", ToMinutes(scenario.rules.limit_us)));
  }
  fmt::print("{}", ToJson(DropPlan(scenario, share, ToUs(at_min * 60),
                                   (*result)["seed"].as<std::uint64_t>())));
  return kExitOk;
}

}  // namespace

int FaultsCommand(int argc, const char* const* argv) {
  const std::string_view name = argc > 1 ? argv[1] : "";
  if (name == "run") return Run(argc - 1, argv + 1);
  if (name == "random") return Draw(argc - 1, argv + 1);
  if (name == "drop") return Drop(argc - 1, argv + 1);
  if (name == "--help" || name == "-h") {
    fmt::print("{}", kUsage);
    return kExitOk;
  }
  throw InputError("command line", "faults", name.empty() ? "nothing" : name,
                   "run, random or drop");
}

}  // namespace muster::tools
