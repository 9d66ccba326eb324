#pragma once

namespace muster::tools {

/// A subcommand of `muster`. argv[0] is "muster NAME"; returns the exit code, throws as GuardedMain
/// in base/program.h expects.
using CommandBody = int (*)(int argc, const char* const* argv);

}  // namespace muster::tools
