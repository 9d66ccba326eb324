#pragma once

#include <string>

#include "tools/explain/phrases.h"
#include "tools/explain/story.h"

namespace muster::tools {

/// A chapter in horizon's terms.
void AddHorizon(const Chapter<scheduler::TaskAnswer>& chapter, Lines* lines);
void AddHorizon(const Chapter<scheduler::AgentAnswer>& chapter, AgentKind kind, Lines* lines);

/// "Of 18 decisions: done in 10, outbid in 3, ...", and where forcing it would have been cheapest.
std::string HorizonSummary(const TaskStory& story);

}  // namespace muster::tools
