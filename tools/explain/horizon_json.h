#pragma once

#include <nlohmann/json.hpp>

#include "tools/explain/story.h"

namespace muster::tools {

/// Adds what a chapter tells in horizon's terms.
void AddHorizon(const HorizonChapter<scheduler::TaskAnswer>& chapter, nlohmann::ordered_json* json);
void AddHorizon(const HorizonChapter<scheduler::AgentAnswer>& chapter,
                nlohmann::ordered_json* json);

}  // namespace muster::tools
