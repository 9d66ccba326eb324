#pragma once

namespace muster::tools {

/// `muster bound`.
int BoundCommand(int argc, const char* const* argv);

}  // namespace muster::tools
