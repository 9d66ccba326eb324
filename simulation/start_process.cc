#include "simulation/start_process.h"

#include "agents/core/agent_process.h"
#include "base/check.h"

namespace muster::simulation {

std::vector<std::string> ProcessNames(int schedulers) {
  std::vector<std::string> names = {process_name::kWorld};
  for (const AgentKind kind : kAgentKinds) names.emplace_back(ToString(kind));
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
    if (identity.name != ToString(kind)) continue;
    return std::make_unique<agents::AgentProcess>(
        identity, settings.window, kind, agents::IdRange(), settings.most_whole,
        settings.drivers ? settings.drivers(kind) : nullptr);
  }
  MUSTER_CHECK(false, "{}", identity.name);
  return nullptr;
}

}  // namespace muster::simulation
