#pragma once

namespace muster::tools {

/// `muster redecide RUN [--policy P]`: makes a run's decisions again from its log. Exit code 4 when
/// the log's own policy decides differently.
int RedecideCommand(int argc, const char* const* argv);

}  // namespace muster::tools
