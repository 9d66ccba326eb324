#pragma once

namespace muster::tools {

/// `muster simulate`.
int SimulateCommand(int argc, const char* const* argv);

}  // namespace muster::tools
