#pragma once

#include <functional>

namespace muster {

enum ExitCode : int {
  kExitOk = 0,
  kExitInternal = 1,
  kExitUsage = 2,
  kExitSystem = 3,
  kExitCheckFailed = 4,
  kExitInterrupted = 130,
};

/// Runs a program's body and turns what it throws into one line on stderr and an exit code:
/// InputError 2, SystemError 3, anything else 1.
int GuardedMain(const char* program, const std::function<int()>& body);

}  // namespace muster
