#pragma once

#include <muster/schedule_t.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "base/units.h"
#include "model/action.h"
#include "model/scenario.h"

namespace muster::tools {

/// Mission time as "0:42:30".
std::string ClockWords(TimeUs t);

/// "uav:3"
std::string AgentName(AgentKind kind, std::int32_t id);

/// What an action is, without jargon: "uav:3 and worker:7 sense task:4".
std::string Words(const Action& action);

/// Actions of a schedule that are not stays.
int MovesIn(const schedule_t& schedule);

/// An action as in report.json: kind by its number, ids (-1: none), weight; and its symbol.
nlohmann::ordered_json ActionJson(const action_t& action);

}  // namespace muster::tools
