#include "tools/scenario/policies_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "base/options.h"
#include "base/program.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "scheduler/policies/registry.h"
#include "simulation/simulator.h"
#include "tools/record/run_record.h"

namespace muster::tools {

int PoliciesCheck(int argc, const char* const* argv) {
  Options options("muster policies check",
                  "Plays a mission's first decisions with a scheduler of yours and says what it "
                  "does wrong (docs/guide/external-schedulers.md).");
  options.Positional("command", "COMMAND").Required("a program and its arguments");
  options.Add("scenario", "FILE", "Scenario (default: Random_1, as muster scenario draws it)");
  options.Add("decisions", "N", "Decisions to ask for").Integer(1, 10'000).Default(6);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string policy = "external:" + arguments->Get("command");
  scheduler::MakePolicy(policy);  // an error before all else
  Scenario scenario = arguments->Has("scenario") ? LoadScenario(arguments->Get("scenario"))
                                                 : Generate(PresetByName("Random_1"), 1);
  Rules& rules = scenario.rules;
  rules.limit_us =
      std::min(rules.limit_us, rules.interval_us * arguments->Get<std::int64_t>("decisions"));
  RunRecord record;
  Simulate(TextOf(scenario), policy, [&](const Packet& packet) { record.Add(packet); });
  for (const auto& [index, schedule] : record.schedules()) {
    const auto pairs = std::count_if(
        schedule.actions.begin(), schedule.actions.end(),
        [](const action_t& action) { return IsPair(static_cast<ActionKind>(action.kind)); });
    fmt::print("decision {:>3}  {:>4} actions, {:>3} of them pairs  {:.3f} s\n", index,
               schedule.actions.size(), pairs, ToSeconds(schedule.solve_us));
  }
  int refused = 0, done = 0;
  for (const event_t& event : record.events()) {
    done += event.kind == EventKind::kSensingDone ? 1 : 0;
    if (event.kind != EventKind::kAnswerRefused) continue;
    ++refused;
    fmt::print("REFUSED  {}\n", event.detail);
  }
  fmt::print("{} of {} answers refused, {} of {} tasks done by {:.0f} min\n", refused,
             record.schedules().size(), done, scenario.tasks.size(), ToMinutes(rules.limit_us));
  return refused == 0 ? kExitOk : kExitCheckFailed;
}

}  // namespace muster::tools
