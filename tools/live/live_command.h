#pragma once

namespace muster::tools {

/// `muster live`.
int LiveCommand(int argc, const char* const* argv);

}  // namespace muster::tools
