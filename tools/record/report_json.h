#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/files/pending_file.h"
#include "tools/record/run_record.h"

namespace muster::tools {

inline constexpr int kReportVersion = 1;

/// report.json of a run (docs/reference/report-format.md): what was decided, what came of it, how
/// complete its log is. `muster run` and `muster simulate` write the same. Numbers are written with
/// as many digits as reading them back bit for bit takes; an unknown bound is null.
nlohmann::ordered_json Report(const RunRecord& record);

/// Name of an event kind in reports: "sensing_done", ...; the number when unknown.

/// Decision time of one run, median and largest, in seconds; both 0 without decisions.
struct DecisionTime {
  double median_s = 0;
  double max_s = 0;
};
DecisionTime DecisionTimeOf(const RunRecord& record);

}  // namespace muster::tools
