#pragma once

namespace muster::tools {

/// `muster run`: a whole mission as processes over LCM (docs/guide/running.md).
int RunCommand(int argc, const char* const* argv);

}  // namespace muster::tools
