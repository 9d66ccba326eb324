#include "world/driver_words.h"

namespace muster::world {
namespace {

constexpr int kMostAwaited = 3;
constexpr std::size_t kMostMessages = 1000;  ///< of an agent in a mission, and calls for help

}  // namespace

std::optional<DriverWords::Key> DriverWords::AgentOf(const event_t& event) const {
  for (const auto& [kind, id] :
       {Key(AgentKind::kUav, event.uav_id), Key(AgentKind::kWorker, event.worker_id),
        Key(AgentKind::kVehicle, event.vehicle_id)}) {
    const auto& agents = scenario_.agents(kind);
    if (id < 0 || static_cast<std::size_t>(id) >= agents.size()) continue;
    if (agents[static_cast<std::size_t>(id)].measured) return Key(kind, id);
  }
  return {};
}

bool DriverWords::Hear(const event_t& event) {
  const auto agent = AgentOf(event);
  if (!agent) return false;
  if (event.kind == EventKind::kDriverSays || event.kind == EventKind::kDriverCalls) {
    auto& said = messages_[{*agent, event.kind}];
    return said.size() < kMostMessages && said.emplace(event.at_us, event.detail).second;
  }
  if (event.kind == EventKind::kDriverFailed) failures_.try_emplace(*agent, event.detail);
  if (event.kind != EventKind::kDriverWaits) return false;
  const auto [said_us, is_first] = waits_said_us_.try_emplace(*agent, event.at_us);
  if (!is_first && event.at_us <= said_us->second) return false;
  said_us->second = event.at_us;
  return true;
}

bool DriverWords::Awaits(const AgentState& agent) {
  const Key key(agent.kind, agent.id);
  return !failures_.contains(key) && ++awaited_[key] <= kMostAwaited;
}

std::string DriverWords::WhyFailed(const AgentState& agent) const {
  const auto found = failures_.find({agent.kind, agent.id});
  return found == failures_.end() ? "its driver has failed" : found->second;
}

}  // namespace muster::world
