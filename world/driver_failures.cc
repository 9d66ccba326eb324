#include "world/driver_failures.h"

namespace muster::world {
namespace {

constexpr int kMostAwaited = 3;

}  // namespace

void DriverFailures::Hear(const event_t& event) {
  if (event.kind != EventKind::kDriverFailed) return;
  for (const auto& [kind, id] :
       {Key(AgentKind::kUav, event.uav_id), Key(AgentKind::kWorker, event.worker_id),
        Key(AgentKind::kVehicle, event.vehicle_id)}) {
    const auto& agents = scenario_.agents(kind);
    if (id < 0 || static_cast<std::size_t>(id) >= agents.size()) continue;
    if (agents[static_cast<std::size_t>(id)].measured) said_.try_emplace({kind, id}, event.detail);
  }
}

bool DriverFailures::Awaits(const AgentState& agent) {
  const Key key(agent.kind, agent.id);
  return !said_.contains(key) && ++awaited_[key] <= kMostAwaited;
}

std::string DriverFailures::Why(const AgentState& agent) const {
  const auto found = said_.find({agent.kind, agent.id});
  return found == said_.end() ? "its driver has failed" : found->second;
}

}  // namespace muster::world
