#pragma once

namespace muster::tools {

/// `muster bench`: times decisions and writes one CSV row a run.
int BenchCommand(int argc, const char* const* argv);

}  // namespace muster::tools
