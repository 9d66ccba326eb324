#pragma once

namespace muster::tools {

/// `muster explain RUN --task N | --agent CLASS:N`: why something was or was not done.
int ExplainCommand(int argc, const char* const* argv);

}  // namespace muster::tools
