#pragma once

namespace muster::tools {

/// `muster doctor`: looks whether this host can run missions and prints a table of what it found
/// and what to do. Returns 0, or 4 when a check failed.
int DoctorCommand(int argc, const char* const* argv);

}  // namespace muster::tools
