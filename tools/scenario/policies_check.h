#pragma once

namespace muster::tools {

/// `muster policies check COMMAND`: plays the first decisions of a mission with an outside
/// scheduler and says what it does wrong. argv[0] is "check". Exit code 4 when an answer is
/// refused.
int PoliciesCheck(int argc, const char* const* argv);

}  // namespace muster::tools
