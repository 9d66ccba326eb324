#pragma once

#include <muster/schedule_t.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/units.h"
#include "model/agent.h"
#include "scheduler/explain/look.h"

namespace muster::tools {

/// "uav:3"
std::string AgentName(AgentKind kind, std::int32_t id);

/// What an action is, without jargon: "uav:3 and worker:7 sense task:4".
std::string Words(const Action& action);

/// Actions of `some` that `others` do not have, whatever they weigh, without stays.
std::vector<Action> OnlyIn(const std::vector<Action>& some, const std::vector<Action>& others);

/// Actions of a schedule that are not stays.
int MovesIn(const schedule_t& schedule);

/// An action as in report.json: kind by its number, ids (-1: none), weight; and its symbol.
nlohmann::ordered_json ActionJson(const action_t& action);

/// "12.34 km"
std::string Km(double metres);

/// "0:42:30", or that it is not known.
std::string Until(TimeUs t);

/// "1 pair", "2 pairs"
std::string Plural(int n, const char* what);

/// " (free at 0:50:00)"; empty for an idle agent.
std::string FreeWords(const std::optional<TimeUs>& free_us);

/// "worker:7", "vehicle:7"
std::string PartnerOf(const scheduler::PairLook& pair, bool charging);

/// "uav:3 and worker:7", with when they will be free.
std::string PairWords(const scheduler::PairLook& pair, bool charging);

/// Why no pair is possible at a place, with the one that comes nearest.
std::string ObstacleWords(const scheduler::PlaceLook& look);

/// "not 3 tasks: at task:4, which comes nearest, range (constraint 6): ..."
std::string BlockedWords(int places, const scheduler::PlaceLook& nearest);

/// "under way: uav:3 and worker:7 sense it from 0:10:00 to 0:15:00"
std::string UnderWayWords(const std::optional<Activity>& activity);

/// "busy until 0:15:00: uav:3 and worker:7 sense task:4 (since decision 1)"
std::string BusyWords(AgentKind kind, const AgentState& state);

}  // namespace muster::tools
