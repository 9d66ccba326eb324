#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "tools/audit/auditor.h"

namespace muster::tools::audit {

/// Compares a report.json (docs/reference/report-format.md) with what the log shows: every number
/// that is about decisions and outcomes, and the digest, computed here once more from its
/// description. Violations carry the mission time of what differs, 0 where there is none.
std::vector<Violation> CheckReportFile(const nlohmann::json& report, const Facts& facts);

}  // namespace muster::tools::audit
