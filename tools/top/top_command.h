#pragma once

namespace muster::tools {

/// `muster top`.
int TopCommand(int argc, const char* const* argv);

}  // namespace muster::tools
