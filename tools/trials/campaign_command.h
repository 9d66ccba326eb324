#pragma once

namespace muster::tools {

/// muster faults soak.
int CampaignCommand(int argc, const char* const* argv);

}  // namespace muster::tools
