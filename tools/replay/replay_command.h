#pragma once

namespace muster::tools {

/// `muster replay RUN`.
int ReplayCommand(int argc, const char* const* argv);

}  // namespace muster::tools
