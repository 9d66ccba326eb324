#pragma once

namespace muster::tools {

/// `muster train`. Its body is a program of its own, muster-train, so that no other command loads
/// libtorch.
int TrainCommand(int argc, const char* const* argv);

}  // namespace muster::tools
