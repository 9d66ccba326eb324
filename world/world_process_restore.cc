// A world that starts again in a mission under way.
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "world/world_process.h"

namespace muster::world {

void WorldProcess::AskForState(const Now& now) {
  // What the others say of agents can be read with the orders alone.
  if (desk_.book().takes_orders() && !restoring_.book()) {
    return Request(channel::kOrders, 0, now);
  }
  for (const std::string_view name : {channel::kUavs, channel::kWorkers, channel::kVehicles,
                                      channel::kWorld, channel::kRulings, channel::kClock}) {
    Request(name, 0, now);
  }
  if (desk_.book().takes_orders()) Request(channel::kOrders, 0, now);
}

bool WorldProcess::RestoreState(const Now& now) {
  const TimeUs listened_us = attendance_.peers().AwaitedUs(now.monotonic_us);
  std::optional<Restoring::State> state =
      options_.goes_on ? restoring_.NewestWithoutLost() : restoring_.Newest();
  if (!state && options_.goes_on && listened_us >= GiveUpUs(options_.lost_after_us)) {
    state = restoring_.NewestWithoutLost(Restoring::Gap::kAccept);
  }
  if (!state || listened_us < ListenUs(*state, options_.goes_on, options_.lost_after_us)) {
    return false;
  }
  if (desk_.book().takes_orders() && state->tick > 0) {
    // A process that has reported this tick has heard the orders taken at it.
    if (!desk_.book().complete(state->tick)) return false;
  }
  if (state->tick > 0) {
    referee_.Restore(clock_.TimeOf(state->tick - 1), state->task_status, state->verdict);
    clock_.Restore(state->tick, state->applied_decision, state->next_decision, now.monotonic_us);
    set_state(ProcessState::kRunning);
  }
  for (const AgentKind kind : kAgentKinds) {
    for (std::size_t i = 0; i < agents_[kind].size(); ++i) {
      const auto id = static_cast<std::int32_t>(i);
      attendance_.SetOwner(kind, id, restoring_.OwnerOf(kind, id));
    }
  }
  for (const std::string& name : state->given_up) {
    SayOfProcess(Event::Kind::kStateUnknown, name, now);
  }
  TakeOrders(now);
  Begin(now);
  // This tick may have been judged before, with what its reporters can no longer repeat.
  for (const Packet& packet : state->reports) {
    if (const auto states = DecodeValid<agent_states_t>(packet.bytes)) Take(*states, &packet);
  }
  for (const Restoring::Lost& lost : state->lost) RestoreLost(lost);
  return true;
}

void WorldProcess::RestoreLost(const Restoring::Lost& lost) {
  const AgentKind kind = lost.agent.kind;
  const std::string& owner = attendance_.OwnerOf(kind, lost.agent.id);
  if (!lost.returns) {
    agents_.at(kind, lost.agent.id) = lost.agent;
    attendance_.Excuse(kind, lost.agent.id);
  }
  Peers& peers = attendance_.peers();
  peers.set_presence(owner, lost.returns || peers.heard(owner) ? Peers::Presence::kReturning
                                                               : Peers::Presence::kLost);
  referee_.Add({kind, lost.agent.id, lost.from_us, kNever, FailureReason::LossOf(owner)});
}

}  // namespace muster::world
