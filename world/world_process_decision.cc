// How a decision comes into force: that of one scheduler as it is heard, one of the proposals of
// several.
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "scheduler/checker.h"
#include "scheduler/fusion.h"
#include "world/world_process.h"

namespace muster::world {

namespace {

/// What a scheduler may tell of its decision.
bool IsOfDecision(const event_t& event) {
  return event.kind == EventKind::kAnswerRefused || event.kind == EventKind::kDirectiveUnkept ||
         event.kind == EventKind::kActionWithheld;
}

}  // namespace

std::optional<std::vector<Action>> WorldProcess::ActionsOf(const schedule_t& schedule) const {
  std::vector<Action> actions;
  for (const action_t& wire : schedule.actions) {
    const std::optional<Action> action = FromWire(wire, limits_);
    if (!action) return {};
    actions.push_back(*action);
  }
  return actions;
}

void WorldProcess::Take(const clearances_t& clearances, const Packet& packet) {
  if (options_.schedulers > 1 || scenario_.separation() == nullptr || wait_ != Wait::kSchedule ||
      clearances.decision != clock_.decision() || clearances.tick != clock_.tick()) {
    return;
  }
  if (!FromWire(clearances, limits_)) return inbox().Reject();
  next_clearances_packet_ = std::make_shared<const Packet>(packet);
  next_clearances_decision_ = clearances.decision;
}

void WorldProcess::Take(const schedule_t& schedule, const Packet& packet, const Now& now) {
  if (options_.schedulers > 1 || wait_ != Wait::kSchedule ||
      schedule.decision != clock_.decision() || schedule.tick != clock_.tick()) {
    return;
  }
  // Altitudes that were lost on the way come again with the schedule, when it is asked for again.
  if (scenario_.separation() != nullptr && next_clearances_decision_ != schedule.decision) return;
  std::optional<std::vector<Action>> actions = ActionsOf(schedule);
  if (!actions) return inbox().Reject();
  const std::string& name = schedule.header.sender;
  attendance_.Join(name);
  if (attendance_.peers().presence(name) != Peers::Presence::kThere) {
    attendance_.peers().set_presence(name, Peers::Presence::kThere);
    SayOfProcess(Event::Kind::kProcessBack, name, now);
  }
  schedule_packet_ = std::make_shared<const Packet>(packet);
  PutInForce(schedule.decision, std::move(*actions), now);
}

void WorldProcess::PutInForce(std::int32_t decision, std::vector<Action> actions, const Now& now) {
  referee_.Take(decision, actions);
  commanded_ = std::move(actions);
  clearances_packet_ = next_clearances_packet_;
  clearances_decision_ = next_clearances_decision_;
  schedule_tick_ = clock_.tick();
  schedule_time_.Note(now.monotonic_us - asked_us_);
  clock_.Require(decision);
  StopWaiting();
}

void WorldProcess::Take(const proposal_t& proposal, const Now& now) {
  const std::string& name = proposal.header.sender;
  const schedule_t& schedule = proposal.schedule;
  if (!ballot_.IsOf(name) || wait_ == Wait::kRestore) return;
  const bool has_altitudes = !proposal.clearances.empty();
  if (!Possible(schedule, scenario_) || !ActionsOf(schedule) ||
      has_altitudes != (scenario_.separation() != nullptr) ||
      (has_altitudes && !FromWire(proposal.clearances.front(), limits_))) {
    return inbox().Reject();
  }
  attendance_.Join(name);
  if (attendance_.peers().presence(name) != Peers::Presence::kThere) {
    attendance_.peers().set_presence(name, Peers::Presence::kThere);
    SayOfProcess(Event::Kind::kProcessBack, name, now);
  }
  if (wait_ == Wait::kSchedule && schedule.decision == clock_.decision() &&
      schedule.tick == clock_.tick()) {
    return ballot_.Cast(name, proposal, now.monotonic_us);
  }
  SayOfDispute(ballot_.Late(name, proposal, now.monotonic_us), now);
}

bool WorldProcess::IsSound(const proposal_t& proposal, const Now& now) const {
  scheduler::Fusion fusion(desk_.book().scenario());
  fusion.Start(clock_.tick(), clock_.sim_us(), clock_.decision());
  for (const AgentKind kind : kAgentKinds) {
    for (const auto& bytes : handover_.StatesOf(kind, identity(), now)) {
      if (const auto states = DecodeValid<agent_states_t>(bytes)) {
        static_cast<void>(fusion.Take(*states));
      }
    }
  }
  static_cast<void>(fusion.Take(*DecodeValid<world_state_t>(world_packet_->bytes)));
  static_cast<void>(fusion.Take(*DecodeValid<rulings_t>(rulings_packet_->bytes)));
  if (!fusion.complete()) return false;
  return scheduler::CheckActions(fusion.Fuse(desk_.book()), *ActionsOf(proposal.schedule)).empty();
}

void WorldProcess::CloseBallot(const Now& now) {
  const auto result = ballot_.Close(
      now.monotonic_us, [&](const proposal_t& proposal) { return IsSound(proposal, now); });
  if (!result) return;
  SayOfDispute(result->dispute, now);
  for (const event_t& event : result->proposal.events) {
    if (IsOfDecision(event)) sender().Send(channel::kEvent, event, clock_.sim_us(), now);
  }
  const std::int32_t decision = result->proposal.schedule.decision;
  for (const clearances_t& clearances : result->proposal.clearances) {
    next_clearances_packet_ = sender().Send(channel::kClearances, clearances, clock_.sim_us(), now);
    next_clearances_decision_ = decision;
  }
  schedule_packet_ =
      sender().Send(channel::kSchedule, result->proposal.schedule, clock_.sim_us(), now);
  PutInForce(decision, *ActionsOf(result->proposal.schedule), now);
}

void WorldProcess::SayOfDispute(const std::string& dispute, const Now& now) {
  if (dispute.empty()) return;
  event_t event{};
  event.kind = NumberOf(EventKind::kDecisionsDiffer);
  event.at_us = clock_.sim_us();
  event.uav_id = event.worker_id = event.vehicle_id = event.task_id = event.charge_id = -1;
  event.detail = dispute;
  sender().Send(channel::kEvent, std::move(event), clock_.sim_us(), now);
}

}  // namespace muster::world
