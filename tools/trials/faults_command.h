#pragma once

namespace muster::tools {

/// muster faults run | random.
int FaultsCommand(int argc, const char* const* argv);

}  // namespace muster::tools
