#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/report/timeline.h"

namespace muster::tools {

/// Is told before each task that is explained: how many are, of how many.
using ReasonsProgress = std::function<void(std::size_t told, std::size_t of)>;

/// Why tasks were not done, for the page: {"undone": how many were not, "tasks": [[task, what
/// `muster explain --task` says], ...]} of the first `most` of them. Costs a TellTask each.
nlohmann::ordered_json Reasons(const std::string& run, const Timeline& timeline, std::size_t most,
                               const ReasonsProgress& progress);

}  // namespace muster::tools
