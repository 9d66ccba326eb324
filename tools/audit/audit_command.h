#pragma once

namespace muster::tools {

/// `muster audit RUN`. Returns 4 when an invariant is broken.
int AuditCommand(int argc, const char* const* argv);

}  // namespace muster::tools
