#pragma once

#include <string>

#include "tools/record/run_record.h"

namespace muster::tools {

/// A run for people, a few lines of "name  value" ending in a newline: tasks done of total,
/// charges, distance, decisions and their time, whether the log is complete and, if not, what is
/// missing first.
std::string Summary(const RunRecord& record);

}  // namespace muster::tools
