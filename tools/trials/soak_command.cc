#include "tools/trials/soak_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <thread>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "model/scenario_json.h"
#include "protocol/run_process.h"
#include "scheduler/policies/registry.h"
#include "tools/files/run_directory.h"
#include "tools/files/scenario_file.h"
#include "tools/host/progress.h"
#include "tools/host/stop_signals.h"
#include "tools/host/worker_pool.h"
#include "tools/launch/fault_options.h"
#include "tools/trials/soak.h"

namespace muster::tools {
namespace {

struct SoakOptions {
  SoakSettings settings;
  std::string as_given;  ///< the settings, as on the command line
  std::uint64_t seed = 1;
  std::size_t missions = 0;
  int jobs = 1;
  std::string out;
  bool quiet = false;
};

void AddSoakOptions(Options* options) {
  options->Add("missions", "N", "How many").Integer(1).Default(500);
  options->Add("seed", "N", "Seed of the first; the next one's is one more").Seed().Default(1);
  options->Add("scenario", "FILE", "Scenario file (default: drawn)");
  options->Add("preset", "NAME", "Scenarios of this preset, drawn");
  options->Add("policy", "NAME", "How to decide (default: drawn among quick ones)");
  options->Add("rate", "R", "Faults per mission hour, on average").Number(Above0(1000)).Default(6);
  options
      ->Add("on-loss", "wait|continue|both",
            "When a process is lost: wait for it, continue without it, or both in turn")
      .OneOf({"wait", "continue", "both"})
      .Default("both");
  options->Add("schedulers", "N", "How many decide (default: drawn, one to three)")
      .Integer(1, world::kMostSchedulers);
  AddDropOption(options);
  options->Add("jobs", "N", "Missions at a time (default: one a core)").Integer(1, 256);
  options->Out("DIR", "Where scenario and plan of the first that fails go, new or empty");
  options->Quiet();
}

std::optional<SoakOptions> ParseSoakOptions(int argc, const char* const* argv) {
  Options parser("muster faults soak",
                 "Runs and audits missions under random fault plans in virtual time, without a "
                 "socket. Exit code 4 when one of them breaks a promise; each is a function of its "
                 "seed.");
  AddSoakOptions(&parser);
  const auto arguments = parser.Parse(argc, argv);
  if (!arguments) return {};
  SoakOptions options;
  SoakSettings& settings = options.settings;
  options.missions = arguments->Get<std::uint64_t>("missions");
  options.seed = arguments->Get<std::uint64_t>("seed");
  if (arguments->Has("scenario")) settings.scenario = LoadScenario(arguments->Get("scenario"));
  if (arguments->Has("preset")) {
    if (settings.scenario) {
      throw InputError("command line", "--preset", arguments->Get("preset"),
                       "not with --scenario, which is there already");
    }
    settings.preset = PresetByName(arguments->Get("preset"));
  }
  if (arguments->Has("policy")) {
    settings.policy = arguments->Get("policy");
    scheduler::MakePolicy(settings.policy);
  }
  settings.rate_per_hour = arguments->Get<double>("rate");
  const std::string on_loss = arguments->Get("on-loss");
  if (on_loss != "both") settings.goes_on = on_loss == "continue";
  settings.drop = arguments->Get<double>("drop");
  if (arguments->Has("schedulers")) settings.schedulers = arguments->Get<int>("schedulers");
  for (const char* name :
       {"scenario", "preset", "policy", "rate", "on-loss", "schedulers", "drop"}) {
    if (arguments->Has(name)) {
      options.as_given += fmt::format(" --{} {}", name, arguments->Get(name));
    }
  }
  options.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  arguments->Read("jobs", &options.jobs);
  if (arguments->Has("out")) options.out = arguments->Get("out");
  options.quiet = arguments->Has("quiet");
  return options;
}

/// What to call to see that mission again by `muster simulate`, with its files in `directory`.
std::string WriteMission(const VirtualMission& mission, const RunDirectory& directory) {
  WriteScenarioFile(mission.scenario, directory.File("scenario.json"));
  directory.Write("plan.json", ToJson(mission.faults));
  return fmt::format(
      "muster simulate {0}/scenario.json --faults {0}/plan.json --policy {1} --fault-seed {2} "
      "--on-loss {3} --lost-after {4} --schedulers {5}{6} --out {0}/run --log",
      directory.path(), mission.policy, mission.fault_seed, mission.goes_on ? "continue" : "wait",
      ToSeconds(mission.lost_after_us), mission.schedulers,
      mission.drop > 0 ? fmt::format(" --drop {}", mission.drop) : "");
}

}  // namespace

int SoakCommand(int argc, const char* const* argv) {
  const auto options = ParseSoakOptions(argc, argv);
  if (!options) return kExitOk;
  std::optional<RunDirectory> directory;
  if (!options->out.empty()) directory = RunDirectory::Take(options->out);
  const StopSignals stop;
  ProgressPrinter progress(stderr, StyleFor(stderr, options->quiet));
  const TimeUs begin_us = MonotonicUs();
  std::size_t done = 0;
  std::map<std::uint64_t, std::string> failed;  // by seed
  const auto rate = [&] {
    return static_cast<double>(done) / std::max(ToMinutes(MonotonicUs() - begin_us), 1e-6);
  };
  const auto take = [&](std::size_t i, const std::string& findings) {
    ++done;
    if (!findings.empty()) failed[options->seed + i] = findings;
    const TimeUs now_us = MonotonicUs();
    if (!progress.due(now_us)) return;
    progress.Show(fmt::format("{} of {} missions  {} failed  {:.0f} a minute", done,
                              options->missions, failed.size(), rate()),
                  now_us);
  };
  RunInProcesses(
      options->missions, options->jobs,
      [&](std::size_t i) {
        const auto findings = FindingsOf(DrawMission(options->settings, options->seed + i));
        return fmt::format("{}", fmt::join(findings, "\n"));
      },
      take, [&](std::size_t i, const std::string& why) { take(i, "the simulation " + why); },
      [&] { return stop.count() > 0; });
  progress.Break();

  fmt::print("{} of {} missions, {} failed, {:.0f} a minute\n", done, options->missions,
             failed.size(), rate());
  if (!failed.empty()) {
    const auto& [seed, findings] = *failed.begin();
    fmt::print("seed {}:\n{}\nagain: muster faults soak --missions 1 --seed {}{}\n", seed, findings,
               seed, options->as_given);
    if (directory) {
      fmt::print("or: {}\n", WriteMission(DrawMission(options->settings, seed), *directory));
    }
    for (auto other = std::next(failed.begin()); other != failed.end(); ++other) {
      fmt::print("seed {}: {}\n", other->first, other->second.substr(0, other->second.find('\n')));
    }
  }
  if (stop.count() > 0) return kExitInterrupted;
  return failed.empty() ? kExitOk : kExitCheckFailed;
}

}  // namespace muster::tools
