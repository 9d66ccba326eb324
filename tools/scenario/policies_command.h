#pragma once

namespace muster::tools {

/// `muster policies`: which policy to take for what, ablations included.
int PoliciesCommand(int argc, const char* const* argv);

}  // namespace muster::tools
