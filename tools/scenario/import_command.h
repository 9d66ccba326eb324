#pragma once

namespace muster::tools {

/// `muster import`: makes a scenario from a CSV or GeoJSON table of places; says on stderr what was
/// made from what.
int ImportCommand(int argc, const char* const* argv);

}  // namespace muster::tools
