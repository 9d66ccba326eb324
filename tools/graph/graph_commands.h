#pragma once

namespace muster::tools {

/// `muster export-graph`: writes one decision's conflict graph.
int ExportGraphCommand(int argc, const char* const* argv);

/// `muster check-solution`: verifies another solver's answer on it. Exit code 4 when the chosen
/// nodes conflict.
int CheckSolutionCommand(int argc, const char* const* argv);

}  // namespace muster::tools
