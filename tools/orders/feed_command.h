#pragma once

namespace muster::tools {

/// `muster feed`: gives a running mission what comes in a file or on stdin.
int FeedCommand(int argc, const char* const* argv);

}  // namespace muster::tools
