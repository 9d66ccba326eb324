#pragma once

namespace muster::tools {

/// `muster log info|repair|cut|export`.
int LogCommand(int argc, const char* const* argv);

}  // namespace muster::tools
