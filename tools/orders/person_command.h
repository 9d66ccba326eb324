#pragma once

namespace muster::tools {

/// `muster person`: adds persons who may order to a file, takes them out, lists them.
int PersonCommand(int argc, const char* const* argv);

}  // namespace muster::tools
