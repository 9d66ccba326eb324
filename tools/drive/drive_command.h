#pragma once

namespace muster::tools {

/// `muster drive --check COMMAND`: plays a mission's part against a driver (docs/guide/drivers.md)
/// and says what it does wrong. Exit code 4 when something is.
int DriveCommand(int argc, const char* const* argv);

}  // namespace muster::tools
