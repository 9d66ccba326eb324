#pragma once

#include "base/options.h"

namespace muster::tools {

/// The options of `muster bench` that only its suites paper and paper-long have.
void AddPaperOptions(Options* options);

/// `muster bench --suite paper` or paper-long: an exit code.
int PaperCommand(const Arguments& arguments);

}  // namespace muster::tools
