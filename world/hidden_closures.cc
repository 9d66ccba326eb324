#include "world/hidden_closures.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <map>
#include <memory>
#include <utility>

#include "base/number_text.h"
#include "model/air_ways.h"

namespace muster::world {
namespace {

/// Each agent of those kinds, with its command where it has one, is asked whether it meets it.
template <typename Meets>
bool AnyMeets(std::initializer_list<AgentKind> kinds, const Scenario& scenario,
              const Agents& agents, const Commands& commands, const Meets& meets) {
  std::map<std::pair<AgentKind, std::int32_t>, const Action*> command_of;
  for (const Action& action : commands.actions) {
    for (const AgentKind kind : kinds) {
      if (const std::int32_t id = MemberOf(action, kind); id >= 0) command_of[{kind, id}] = &action;
    }
  }
  const auto meets_under_way = [&](AgentState agent) {
    const auto command = command_of.find({agent.kind, agent.id});
    if (command != command_of.end() && agent.idle(commands.at_us) &&
        !(IsPair(command->second->kind) &&
          MatchFails(*command->second, commands.decision, scenario.disturbances, scenario.seed))) {
      Begin(&agent, *command->second, commands.decision, commands.at_us, scenario.disturbances,
            scenario.seed);
    }
    return !agent.failed && meets(agent);
  };
  return std::any_of(kinds.begin(), kinds.end(), [&](AgentKind kind) {
    return std::any_of(agents[kind].begin(), agents[kind].end(), meets_under_way);
  });
}

/// Whether its way leads to what is closed by `closed` after from_us, and it has come there by t.
bool ComesTo(const Ways& closed, const AgentState& agent, TimeUs from_us, TimeUs t) {
  if (agent.action == ActionKind::kNone) return false;
  const auto at_us = BarredAt(agent, from_us, closed);
  return at_us && *at_us <= t;
}

}  // namespace

HiddenClosure HiddenIn(FaultKind kind, const RoadArea& circle, TimeUs from_us, TimeUs until_us,
                       std::string fault) {
  HiddenClosure closure{circle, from_us, until_us, std::move(fault)};
  if (kind == FaultKind::kZoneUnknown) {
    const auto& [centre, radius_m] = std::get<RoadArea::Circle>(circle.of);
    closure.of = Zone{{}, {CornersAround(centre, radius_m)}};
  }
  return closure;
}

bool IsPossible(const HiddenClosure& closure, const Scenario& scenario) {
  return std::holds_alternative<Zone>(closure.of) ? scenario.air != nullptr
                                                  : scenario.roads != nullptr;
}

bool IsToldOrMet(const HiddenClosure& closure, TimeUs t, const Scenario& scenario,
                 const Agents& agents, const Commands& commands) {
  if (t < closure.from_us || t >= closure.until_us) return false;
  if (t >= closure.from_us + kToldAfterUs) return true;
  if (const Zone* const zone = std::get_if<Zone>(&closure.of)) {
    const Airspace::Extent extent{scenario.width_m, scenario.height_m};
    const AirWays closed(scenario.ways,
                         std::make_shared<const LazyAirspace>(std::vector<Zone>{*zone},
                                                              scenario.air->margin_m, extent),
                         extent);
    return AnyMeets({AgentKind::kUav}, scenario, agents, commands, [&](const AgentState& uav) {
      return ComesTo(closed, uav, closure.from_us, t) || !closed.air().IsFree(PositionAt(uav, t));
    });
  }
  Scenario closed = scenario;
  const auto& area = std::get<RoadArea>(closure.of);
  closed.closures.push_back({"", "", t, RoadsIn(*scenario.roads->network, area)});
  ChangeWays(t, &closed);
  return AnyMeets(
      {AgentKind::kWorker, AgentKind::kVehicle}, scenario, agents, commands,
      [&](const AgentState& agent) { return ComesTo(*closed.ways, agent, closure.from_us, t); });
}

std::string OrderIdOf(const HiddenClosure& closure) { return "fault:" + closure.fault; }

std::string OrderOf(const HiddenClosure& closure, TimeUs t, const Rules& rules) {
  const std::string until =
      closure.until_us == kNever
          ? ""
          : fmt::format(", \"until_min\": {}", TimeToText(closure.until_us, kMinute));
  if (const Zone* const zone = std::get_if<Zone>(&closure.of)) {
    return fmt::format("{{\"order\": \"zone_add\", {}{}}}", ZoneToJson(*zone), until);
  }
  // Before the last tick nobody has come to them: it would have been found out.
  const TimeUs since_us = std::max({closure.from_us, t - rules.tick_us, TimeUs{0}});
  return fmt::format("{{\"order\": \"road_close\", {}, \"since_min\": {}{}}}",
                     RoadAreaToJson(std::get<RoadArea>(closure.of)), TimeToText(since_us, kMinute),
                     until);
}

}  // namespace muster::world
