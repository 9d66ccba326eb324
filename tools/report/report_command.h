#pragma once

namespace muster::tools {

/// `muster report`.
int ReportCommand(int argc, const char* const* argv);

}  // namespace muster::tools
