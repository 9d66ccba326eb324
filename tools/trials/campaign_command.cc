#include "tools/trials/campaign_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <thread>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/text.h"
#include "model/scenario_json.h"
#include "protocol/run_process.h"
#include "scheduler/policies/registry.h"
#include "tools/files/run_directory.h"
#include "tools/files/scenario_file.h"
#include "tools/host/progress.h"
#include "tools/host/stop_signals.h"
#include "tools/host/worker_pool.h"
#include "tools/launch/fault_options.h"
#include "tools/scenario/order_text.h"
#include "tools/trials/campaign.h"
#include "tools/trials/shrink.h"

namespace muster::tools {
namespace {

/// More than any computer runs in a campaign's longest time.
constexpr std::size_t kEndless = 1'000'000'000;

struct CampaignOptions {
  CampaignSettings settings;
  std::string as_given;  ///< the settings, as on the command line
  std::uint64_t seed = 1;
  std::size_t missions = 0;
  TimeUs longest_us = kNever;
  int jobs = 1;
  std::string out;
  bool quiet = false;
};

void AddCampaignOptions(Options* options) {
  options->Positional("scenario", "[SCENARIO]");
  options
      ->Add("missions", "N", "How many (default: 500; with --hours as many as there is time for)")
      .Integer(1);
  options->Add("hours", "H", "Start no mission after that time").Number(Above0(1000));
  options->Add("seed", "N", "Seed of the first; the next one's is one more").Seed().Default(1);
  options->Add("preset", "NAME", "Scenarios of this preset, drawn; not with SCENARIO");
  options->Add("policy", "NAME", "How to decide (default: drawn among quick ones)");
  options->Add("rate", "R", "Faults per mission hour, on average").Number(Above0(1000)).Default(6);
  options
      ->Add("on-loss", "wait|continue|both",
            "When a process is lost: wait for it, continue without it, or both in turn")
      .OneOf({"wait", "continue", "both"})
      .Default("both");
  options->Add("schedulers", "N", "How many decide (default: drawn, one to three)")
      .Integer(1, world::kMostSchedulers);
  options->Add("kinds", "KIND,...", "Faults to draw from (default: all but corruption)").List();
  options
      ->Add("draw", "WHAT,...",
            "What missions may have besides, each by chance: roads, zones, orders, measured "
            "(agents), hosts (processes that die together), clocks (of hosts, wrong or set "
            "anew), decisions (between intervals), late_zones (that nobody knows of at first), "
            "not_ready (measured agents that cannot set out yet); or none (default: all nine)")
      .List();
  AddDropOption(options);
  options->Add("jobs", "N", "Missions at a time (default: one a core)").Integer(1, 256);
  options->Out(
      "DIR",
      "New or empty folder for the scenario and the smallest plan of the first mission that "
      "fails");
  options->Quiet();
}

std::set<Extra> ReadExtras(const std::vector<std::string>& words) {
  std::set<Extra> extras;
  if (words == std::vector<std::string>{"none"}) return extras;
  for (const std::string& word : words) {
    const auto found = std::find(kExtraNames.begin(), kExtraNames.end(), word);
    if (found == kExtraNames.end()) {
      throw InputError("command line", "--draw", word,
                       fmt::format("{}, or none alone", fmt::join(kExtraNames, ", ")));
    }
    extras.insert(static_cast<Extra>(found - kExtraNames.begin()));
  }
  return extras;
}

std::optional<CampaignOptions> ParseCampaignOptions(int argc, const char* const* argv) {
  Options parser("muster faults campaign",
                 "Runs and audits missions under random fault plans in virtual time, without a "
                 "socket: of SCENARIO, or drawn ones. Each is a function of its seed. When one of "
                 "them breaks a promise, looks for the smallest plan that does, and ends with exit "
                 "code 4.");
  AddCampaignOptions(&parser);
  const auto arguments = parser.Parse(argc, argv);
  if (!arguments) return {};
  CampaignOptions options;
  CampaignSettings& settings = options.settings;
  if (arguments->Has("scenario")) {
    options.as_given = " " + arguments->Get("scenario");
  }
  options.missions = arguments->Has("hours") ? kEndless : 500;
  arguments->Read("missions", &options.missions);
  if (arguments->Has("hours")) options.longest_us = ToUs(3600 * arguments->Get<double>("hours"));
  options.seed = arguments->Get<std::uint64_t>("seed");
  if (arguments->Has("scenario")) settings.scenario = LoadScenario(arguments->Get("scenario"));
  if (arguments->Has("preset")) {
    if (settings.scenario) {
      throw InputError("command line", "--preset", arguments->Get("preset"),
                       "not with SCENARIO, which is there already");
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
  if (arguments->Has("kinds")) {
    settings.kinds.clear();
    for (const std::string& name : arguments->All("kinds")) {
      settings.kinds.push_back(KindByName(name, "command line", "--kinds"));
    }
  }
  if (arguments->Has("draw")) settings.extras = ReadExtras(arguments->All("draw"));
  if (arguments->Has("schedulers")) settings.schedulers = arguments->Get<int>("schedulers");
  for (const char* name :
       {"preset", "policy", "rate", "on-loss", "schedulers", "kinds", "draw", "drop"}) {
    if (!arguments->Has(name)) continue;
    options.as_given += fmt::format(" --{} {}", name, fmt::join(arguments->All(name), ","));
  }
  options.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  arguments->Read("jobs", &options.jobs);
  if (arguments->Has("out")) options.out = arguments->Get("out");
  options.quiet = arguments->Has("quiet");
  return options;
}

/// "12 of 500", or without an end "12".
std::string OfAll(std::size_t done, const CampaignOptions& options) {
  return options.missions == kEndless ? fmt::format("{}", done)
                                      : fmt::format("{} of {}", done, options.missions);
}

/// What to call to see that mission again by `muster simulate`, with its files in `directory`.
std::string WriteMission(const VirtualMission& mission, const RunDirectory& directory) {
  WriteScenarioFile(mission.scenario, directory.File("scenario.json"));
  directory.Write("plan.json", ToJson(mission.faults));
  std::string orders;
  if (!mission.orders.empty()) {
    directory.Write("orders.jsonl", OrderLines(mission.orders));
    orders = fmt::format(" --orders {}/orders.jsonl", directory.path());
  }
  return fmt::format(
      "muster simulate {0}/scenario.json --faults {0}/plan.json --policy {1} --fault-seed {2} "
      "--on-loss {3} --lost-after {4} --schedulers {5} --processes {6}{7}{8} --out {0}/run --log",
      directory.path(), mission.policy, mission.fault_seed, mission.goes_on ? "continue" : "wait",
      ToSeconds(mission.lost_after_us), mission.schedulers, mission.per_class,
      mission.drop > 0 ? fmt::format(" --drop {}", mission.drop) : "", orders);
}

/// What a mission breaks, a line each; "": nothing. In a process of its own, so that a crash is a
/// finding, too.
std::string FindingsApart(const VirtualMission& mission) {
  std::string findings;
  RunInProcesses(
      1, 1, [&](std::size_t) { return fmt::format("{}", fmt::join(FindingsOf(mission), "\n")); },
      [&](std::size_t, const std::string& found) { findings = found; },
      [&](std::size_t, const std::string& why) { findings = "the simulation " + why; });
  return findings;
}

/// Prints what a mission that failed takes to fail in that way, and how to see it again.
void ReportSmallest(const VirtualMission& mission, const std::string& findings,
                    const RunDirectory* directory, const StopSignals& stop) {
  const auto first = [](const std::string& lines) { return lines.substr(0, lines.find('\n')); };
  const std::string kind = FindingKind(first(findings));
  const auto fails = [&](const VirtualMission& less) {
    for (const std::string& finding : Split(FindingsApart(less), '\n')) {
      if (FindingKind(finding) == kind) return true;
    }
    return false;
  };
  const VirtualMission smallest = Shrink(mission, fails, [&] { return stop.count() > 0; });
  fmt::print("smallest plan: {} of {} faults, {} of {} orders, {} scheduler{}, drop {}\n",
             smallest.faults.size(), mission.faults.size(), smallest.orders.size(),
             mission.orders.size(), smallest.schedulers, smallest.schedulers == 1 ? "" : "s",
             smallest.drop);
  for (const PlannedFault& fault : smallest.faults) {
    fmt::print("  {} {} at {:.1f} min\n", ToString<FaultKind>(fault.kind), fault.target,
               ToMinutes(fault.at_us));
  }
  for (const ClockJump& jump : smallest.clock_jumps) {
    fmt::print("  clock of {} set by {:+.1f} min after {:.3f} s\n", jump.process,
               ToMinutes(jump.by_us), ToSeconds(jump.at_us));
  }
  if (directory == nullptr) return;
  const std::string command = WriteMission(smallest, *directory);
  // Its drivers and clocks are drawn with it, and no program has them.
  if (!smallest.drivers && smallest.clock_jumps.empty()) fmt::print("again: {}\n", command);
}

}  // namespace

int CampaignCommand(int argc, const char* const* argv) {
  const auto options = ParseCampaignOptions(argc, argv);
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
    progress.Show(fmt::format("{} missions  {} failed  {:.0f} a minute", OfAll(done, *options),
                              failed.size(), rate()),
                  now_us);
  };
  RunInProcesses(
      options->missions, options->jobs,
      [&](std::size_t i) {
        const auto findings = FindingsOf(DrawMission(options->settings, options->seed + i));
        return fmt::format("{}", fmt::join(findings, "\n"));
      },
      take, [&](std::size_t i, const std::string& why) { take(i, "the simulation " + why); },
      [&] { return stop.count() > 0 || MonotonicUs() - begin_us > options->longest_us; });
  progress.Break();

  fmt::print("{} missions, {} failed, {:.0f} a minute\n", OfAll(done, *options), failed.size(),
             rate());
  if (!failed.empty()) {
    const auto& [seed, findings] = *failed.begin();
    fmt::print("seed {}:\n{}\nagain: muster faults campaign{} --missions 1 --seed {}\n", seed,
               findings, options->as_given, seed);
    ReportSmallest(DrawMission(options->settings, seed), findings,
                   directory ? &*directory : nullptr, stop);
    for (auto other = std::next(failed.begin()); other != failed.end(); ++other) {
      fmt::print("seed {}: {}\n", other->first, other->second.substr(0, other->second.find('\n')));
    }
  }
  if (stop.count() > 0) return kExitInterrupted;
  return failed.empty() ? kExitOk : kExitCheckFailed;
}

}  // namespace muster::tools
