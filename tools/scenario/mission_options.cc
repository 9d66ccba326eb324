#include "tools/scenario/mission_options.h"

#include "model/scenario_json.h"
#include "scheduler/policies/registry.h"

namespace muster::tools {
namespace {

constexpr NumberRange kMinutes = Above0(1e6);

TimeUs MinutesToUs(double minutes) { return ToUs(minutes * 60); }

}  // namespace

void AddRuleOptions(Options* options) {
  options->Scenario();
  options->Add("interval", "MIN", "Minutes between decisions (default: the scenario's)")
      .Number(kMinutes);
  options->Add("limit", "MIN", "Minutes of mission (default: the scenario's)").Number(kMinutes);
  options
      ->Add("availability", "MODE",
            "strict: no action that may end after a participant's time or the limit; overrun: it "
            "may (default: the scenario's)")
      .OneOf({"strict", "overrun"});
}

MissionOptions ReadRuleOptions(const Arguments& arguments) {
  MissionOptions options;
  options.scenario_file = arguments.Get("scenario");
  arguments.Read("interval", &options.interval_min);
  arguments.Read("limit", &options.limit_min);
  if (arguments.Has("availability")) {
    options.availability =
        arguments.Get("availability") == "strict" ? Availability::kStrict : Availability::kOverrun;
  }
  return options;
}

void AddMissionOptions(Options* options) {
  AddRuleOptions(options);
  scheduler::AddPolicyOption(options);
  options->Add("seed", "N", "Seed of the mission's chances (default: the scenario's)").Seed();
  options->Out("DIR", "Run directory, new or empty");
  options->Quiet();
}

MissionOptions ReadMissionOptions(const Arguments& arguments, bool own_policy) {
  MissionOptions options = ReadRuleOptions(arguments);
  options.policy = arguments.Get("policy");
  // An unknown name is an error before the first file.
  if (!own_policy) scheduler::MakePolicy(options.policy);
  arguments.Read("seed", &options.seed);
  arguments.Read("out", &options.out);
  options.quiet = arguments.Has("quiet");
  return options;
}

Scenario ResolveScenario(const MissionOptions& options) {
  Scenario scenario = LoadScenario(options.scenario_file);
  if (options.interval_min) scenario.rules.interval_us = MinutesToUs(*options.interval_min);
  if (options.limit_min) scenario.rules.limit_us = MinutesToUs(*options.limit_min);
  if (options.seed) scenario.seed = *options.seed;
  if (options.availability) scenario.rules.availability = *options.availability;
  ValidateScenario(scenario, options.scenario_file);
  return scenario;
}

}  // namespace muster::tools
