#include "world/hidden_closures.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "base/number_text.h"

namespace muster::world {

bool IsToldOrMet(const HiddenClosure& closure, TimeUs t, const Scenario& scenario,
                 const Agents& agents, const Commands& commands) {
  if (t < closure.from_us || t >= closure.until_us) return false;
  if (t >= closure.from_us + kToldAfterUs) return true;
  Scenario closed = scenario;
  closed.closures.push_back({"", "", t, RoadsIn(*scenario.roads->network, closure.area)});
  ChangeWays(t, &closed);
  std::map<std::pair<AgentKind, std::int32_t>, const Action*> command_of;
  for (const Action& action : commands.actions) {
    for (const AgentKind kind : {AgentKind::kWorker, AgentKind::kVehicle}) {
      if (const std::int32_t id = MemberOf(action, kind); id >= 0) command_of[{kind, id}] = &action;
    }
  }
  const auto meets = [&](AgentState agent) {
    const auto command = command_of.find({agent.kind, agent.id});
    if (command != command_of.end() && agent.idle(commands.at_us) &&
        !(IsPair(command->second->kind) &&
          MatchFails(*command->second, commands.decision, scenario.disturbances, scenario.seed))) {
      Begin(&agent, *command->second, commands.decision, commands.at_us, scenario.disturbances,
            scenario.seed);
    }
    if (agent.failed || agent.action == ActionKind::kNone) return false;
    const auto at_us = BarredAt(agent, closure.from_us, *closed.ways);
    return at_us && *at_us <= t;
  };
  return std::any_of(agents.workers.begin(), agents.workers.end(), meets) ||
         std::any_of(agents.vehicles.begin(), agents.vehicles.end(), meets);
}

std::string OrderIdOf(const HiddenClosure& closure) { return "fault:" + closure.fault; }

std::string OrderToClose(const HiddenClosure& closure, TimeUs t, const Rules& rules) {
  // Before the last tick nobody has come to them: it would have been found out.
  const TimeUs since_us = std::max({closure.from_us, t - rules.tick_us, TimeUs{0}});
  const std::string until =
      closure.until_us == kNever
          ? ""
          : fmt::format(", \"until_min\": {}", TimeToText(closure.until_us, kMinute));
  return fmt::format("{{\"order\": \"road_close\", {}, \"since_min\": {}{}}}",
                     RoadAreaToJson(closure.area), TimeToText(since_us, kMinute), until);
}

}  // namespace muster::world
