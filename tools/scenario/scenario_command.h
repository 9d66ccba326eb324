#pragma once

namespace muster::tools {

/// `muster scenario`: writes a random scenario, or lists the presets (--list).
int ScenarioCommand(int argc, const char* const* argv);

}  // namespace muster::tools
