#pragma once

namespace muster::tools {

/// muster faults soak.
int SoakCommand(int argc, const char* const* argv);

}  // namespace muster::tools
