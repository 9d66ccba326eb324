#pragma once

#include <muster/schedule_t.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "world/model/units.h"

namespace muster::tools {

/// Mission time as "0:42:30".
std::string ClockWords(TimeUs t);

/// Actions of a schedule that are not stays.
int MovesIn(const schedule_t& schedule);

/// An action as in report.json: kind by its number, ids (-1: none), weight; and its symbol.
nlohmann::ordered_json ActionJson(const action_t& action);

}  // namespace muster::tools
