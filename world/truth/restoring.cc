#include "world/truth/restoring.h"

#include <algorithm>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::world {

Restoring::Restoring(const Scenario& scenario, std::int64_t run_id)
    : scenario_(scenario), limits_(scenario), run_id_(run_id) {
  for (const AgentKind kind : kAgentKinds) {
    ticks_[static_cast<int>(kind)].assign(scenario.agents(kind).size(), -1);
  }
}

bool Restoring::Take(const restore_t& restore) {
  for (const AgentKind kind : kAgentKinds) {
    if (restore.channel != ChannelOf(kind)) continue;
    if (restore.data.empty()) {
      not_begun_ = true;
      return true;
    }
    const auto states = DecodeValid<agent_states_t>(restore.data);
    if (!states || states->header.run_id != run_id_ ||
        static_cast<AgentKind>(states->kind) != kind ||
        states->tick > scenario_.rules.last_tick()) {
      return false;
    }
    auto& ticks = ticks_[static_cast<int>(kind)];
    for (const agent_t& wire : states->agents) {
      if (wire.id < 0 || static_cast<std::size_t>(wire.id) >= ticks.size()) return false;
    }
    applied_[states->tick] = states->applied_decision;
    for (const agent_t& wire : states->agents) {
      auto& tick = ticks[static_cast<std::size_t>(wire.id)];
      tick = std::max(tick, states->tick);
    }
  }
  if (restore.data.empty()) return true;
  if (restore.channel == channel::kWorld) {
    auto world = DecodeValid<world_state_t>(restore.data);
    if (!world || world->header.run_id != run_id_) return false;
    worlds_.emplace(world->tick, std::move(*world));
  }
  if (restore.channel == channel::kRulings) {
    auto rulings = DecodeValid<rulings_t>(restore.data);
    if (!rulings || rulings->header.run_id != run_id_) return false;
    rulings_.emplace(rulings->tick, std::move(*rulings));
  }
  return true;
}

std::optional<Restoring::State> Restoring::Newest() const {
  State state;
  if (not_begun_) return state;
  state.tick = scenario_.rules.last_tick();
  for (const auto& ticks : ticks_) {
    for (const std::int64_t tick : ticks) state.tick = std::min(state.tick, tick);
  }
  if (state.tick < 0) return {};
  if (state.tick == 0) return state;
  const auto world = worlds_.find(state.tick - 1);
  const auto rulings = rulings_.find(state.tick - 1);
  if (world == worlds_.end() || rulings == rulings_.end() ||
      world->second.task_status.size() != scenario_.tasks.size()) {
    return {};
  }
  state.applied_decision = applied_.at(state.tick);
  for (const std::int8_t status : world->second.task_status) {
    state.task_status.push_back(static_cast<TaskStatus>(status));
  }
  for (const activity_t& wire : world->second.activities) {
    if (const auto activity = FromWire(wire, limits_)) state.activities.push_back(*activity);
  }
  for (const ruling_t& wire : rulings->second.rulings) {
    if (const auto ruling = FromWire(wire, limits_)) state.rulings.push_back(*ruling);
  }
  return state;
}

}  // namespace muster::world
