#include "simulation/start_process.h"

#include <fmt/format.h>

#include <algorithm>

#include "agents/core/agent_process.h"
#include "base/check.h"

namespace muster::simulation {

std::vector<std::string> ProcessNames(int schedulers, int per_class) {
  std::vector<std::string> names = {process_name::kWorld};
  for (const AgentKind kind : kAgentKinds) {
    for (int i = 1; i <= per_class; ++i) {
      names.push_back(per_class == 1 ? std::string(ToString(kind))
                                     : fmt::format("{}-{}", ToString(kind), i));
    }
  }
  for (const std::string& name : world::SchedulerNames(schedulers)) names.push_back(name);
  return names;
}

std::unique_ptr<Process> StartProcess(const Identity& identity, const ProcessSettings& settings) {
  if (identity.name == process_name::kWorld) {
    return std::make_unique<world::WorldProcess>(identity, settings.world_window, settings.scenario,
                                                 settings.world);
  }
  if (process_name::IsScheduler(identity.name)) {
    return std::make_unique<scheduler::SchedulerProcess>(identity, settings.window, settings.policy,
                                                         settings.stopwatch);
  }
  for (const AgentKind kind : kAgentKinds) {
    const std::size_t dash = std::min(identity.name.find('-'), identity.name.size());
    if (identity.name.substr(0, dash) != ToString(kind)) continue;
    agents::IdRange ids;
    if (settings.per_class > 1) {
      const int i = std::stoi(identity.name.substr(dash + 1));
      const int n = settings.agents[kind];
      ids.emplace(n * (i - 1) / settings.per_class, n * i / settings.per_class - 1);
    }
    return std::make_unique<agents::AgentProcess>(
        identity, settings.window, kind, ids, settings.most_whole,
        settings.drivers ? settings.drivers(kind) : nullptr);
  }
  MUSTER_CHECK(false, "{}", identity.name);
  return nullptr;
}

}  // namespace muster::simulation
