#pragma once

namespace muster::tools {

/// `muster resume`: goes on with a mission whose launcher has gone (docs/guide/resuming.md).
int ResumeCommand(int argc, const char* const* argv);

}  // namespace muster::tools
