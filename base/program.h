#pragma once

#include <cxxopts.hpp>
#include <functional>
#include <optional>

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
/// InputError and bad options 2, SystemError 3, anything else 1.
int GuardedMain(const char* program, const std::function<int()>& body);

/// Adds --help and --version, parses, and answers those two: then it returns no value and the
/// program should exit with 0. Positional arguments that no option takes are an InputError.
/// Durations on command lines are in the unit that the flag's help names.
std::optional<cxxopts::ParseResult> ParseOptions(cxxopts::Options* options, int argc,
                                                 const char* const* argv);

}  // namespace muster
