#pragma once

#include <functional>
#include <string_view>
#include <vector>

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
/// InputError 2, SystemError 3, anything else 1. What the body has printed must have reached
/// stdout: else 3 in the place of 0 and 4. SIGPIPE and SIGXFSZ are ignored from here on, so that a
/// write fails instead.
int GuardedMain(const char* program, const std::function<int()>& body);

/// A command of a program, "run" of "muster" or "info" of "muster log".
struct Command {
  std::string_view name;
  std::string_view summary;  ///< a line for --help
  /// argv[0] is "muster run". Returns the exit code, throws as GuardedMain expects.
  int (*body)(int argc, const char* const* argv);
};

/// Runs the command that argv[1] names. `--help`, `-h` and `help` list the commands below a line
/// "Commands:", which completion and the manual pages read; `help NAME...` is `NAME... --help`;
/// `--version` and `-v` tell the version. Throws InputError on an unknown name.
int RunCommandOf(std::string_view program, std::string_view purpose,
                 const std::vector<Command>& commands, int argc, const char* const* argv);

}  // namespace muster
