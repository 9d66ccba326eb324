#include "tools/scenario/mission_options.h"

#include <algorithm>
#include <utility>

#include "model/scenario_json.h"
#include "scheduler/policies/registry.h"
#include "tools/scenario/order_text.h"

namespace muster::tools {
namespace {

constexpr NumberRange kMinutes = Above0(1e6);
constexpr std::size_t kMostRevisits = 100'000;

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
  options->Add(
      "orders", "FILE",
      "Orders to give in the course of the mission, a line of JSON each (docs/guide/orders.md); "
      "-: from stdin");
  options->Flag("emergencies-at-once",
                "Decide as soon as an emergency opens, not only at the next interval (default: as "
                "the scenario says)");
  options->Add("seed", "N", "Seed of the mission's random draws (default: the scenario's)").Seed();
  options->Out("DIR", "Run directory, new or empty");
  options->Quiet();
}

MissionOptions ReadMissionOptions(const Arguments& arguments, bool own_policy) {
  MissionOptions options = ReadRuleOptions(arguments);
  options.policy = scheduler::PolicyFrom(arguments);
  // An unknown name is an error before the first file.
  options.own_policy = own_policy;
  if (!own_policy) scheduler::MakePolicy(options.policy);
  arguments.Read("orders", &options.orders_file);
  options.emergencies_at_once = arguments.Has("emergencies-at-once");
  arguments.Read("seed", &options.seed);
  arguments.Read("out", &options.out);
  options.quiet = arguments.Has("quiet");
  return options;
}

namespace {

/// For what is done and wants to be done again.
std::size_t RoomToRevisit(const Scenario& scenario) {
  std::size_t room = 0;
  for (const Task& task : scenario.tasks) {
    if (task.revisit_us == kNever || task.reported_us >= scenario.rules.limit_us) continue;
    room += static_cast<std::size_t>((scenario.rules.limit_us - task.reported_us) /
                                     std::max(task.revisit_us, kSecondUs));
  }
  return std::min(room, kMostRevisits);
}

}  // namespace

Scenario ResolveScenario(const MissionOptions& options, std::vector<world::PlannedOrder>* orders) {
  Scenario scenario = LoadScenario(options.scenario_file);
  if (options.interval_min) scenario.rules.interval_us = MinutesToUs(*options.interval_min);
  if (options.limit_min) scenario.rules.limit_us = MinutesToUs(*options.limit_min);
  if (options.seed) scenario.seed = *options.seed;
  if (options.emergencies_at_once) scenario.rules.emergencies_at_once = true;
  if (options.availability) scenario.rules.availability = *options.availability;
  std::vector<world::PlannedOrder> given;
  if (!options.orders_file.empty()) given = ReadOrderFile(options.orders_file, scenario.origin);
  Room room = RoomFor(given);
  room.tasks += options.room.tasks + RoomToRevisit(scenario);
  for (const AgentKind kind : kAgentKinds) room.agents[kind] += options.room.agents[kind];
  // Orders that add nothing need a mission that takes any, too.
  if (!given.empty() && !room.any()) room.tasks = 1;
  ValidateScenario(scenario, options.scenario_file, room.tasks + scenario.room.tasks > 0);
  AddRoom(room, &scenario);
  if (orders != nullptr) *orders = std::move(given);
  if (!options.policy.empty() && !options.own_policy) {
    scheduler::MakePolicy(options.policy)->CheckScenario(scenario);
  }
  return scenario;
}

}  // namespace muster::tools
