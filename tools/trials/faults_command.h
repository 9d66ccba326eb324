#pragma once

namespace muster::tools {

/// muster faults run | random | drop | soak.
int FaultsCommand(int argc, const char* const* argv);

}  // namespace muster::tools
