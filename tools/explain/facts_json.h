#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scheduler/explain/explain.h"

namespace muster::tools {

/// Seconds of the mission; null: not known.
nlohmann::ordered_json Seconds(TimeUs t);

/// Actions with the keys of report.json.
nlohmann::ordered_json ActionsJson(const std::vector<Action>& actions);

/// "worker:7", "vehicle:7"
std::string PartnerName(bool charging, std::int32_t id);

/// Facts that are told in whosever terms: what `weight` weighs is the story's.
nlohmann::ordered_json FactJson(const scheduler::PairLook& pair, bool charging);
nlohmann::ordered_json FactJson(const scheduler::PlaceLook& look);
nlohmann::ordered_json FactJson(const std::vector<scheduler::AgentAnswer::Blocked>& blocked);
nlohmann::ordered_json FactJson(const Activity& activity);
/// What a busy agent does.
nlohmann::ordered_json FactJson(const AgentState& state);

}  // namespace muster::tools
