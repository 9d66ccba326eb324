#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/explain/story.h"
#include "tools/report/timeline.h"

namespace muster::tools {

/// Why tasks were not done, for the page: {"undone": how many were not, "tasks": [[task, what
/// `muster explain --task` says], ...]} of the first `most` of them. Costs what TellTasks does.
nlohmann::ordered_json Reasons(const std::string& run, const Timeline& timeline, std::size_t most,
                               const DecisionProgress& progress);

}  // namespace muster::tools
