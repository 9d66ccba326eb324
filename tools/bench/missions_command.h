#pragma once

#include "base/options.h"

namespace muster::tools {

/// The options of `muster bench --suite missions`.
void AddMissionSuiteOptions(Options* options);
/// Runs it. Throws InputError, SystemError.
int MissionsCommand(const Arguments& arguments);

}  // namespace muster::tools
