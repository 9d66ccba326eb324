#include "scheduler/process/scheduler_process.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "scheduler/policies/directives/directing.h"
#include "scheduler/separation/keep_apart.h"

namespace muster::scheduler {
namespace {

/// Of altitudes that are kept: the decision in force is one of the last two, or older where some
/// were not made in time; those are asked for.
constexpr std::size_t kMostClearances = 4;
/// A clock heard so often: who has gone on can no longer repeat what it reported of that tick.
constexpr int kManyRepeats = 20;
constexpr std::array kReportChannels = {channel::kUavs, channel::kWorkers, channel::kVehicles};

}  // namespace

SchedulerProcess::SchedulerProcess(const Identity& identity, int window, std::string policy_name,
                                   std::unique_ptr<Policy> policy, Stopwatch stopwatch)
    : Follower(identity, window),
      policy_name_(std::move(policy_name)),
      policy_(std::move(policy)),
      stopwatch_(stopwatch) {}

SchedulerProcess::SchedulerProcess(const Identity& identity, int window, const std::string& policy,
                                   Stopwatch stopwatch, std::optional<double> deadline_ms)
    : SchedulerProcess(identity, window, policy, MakePolicy(policy, deadline_ms), stopwatch) {}

void SchedulerProcess::OnScenario() {
  policy_->CheckScenario(*scenario());
  fusion_.emplace(scenario());
  set_state(ProcessState::kReady);
}

void SchedulerProcess::OnMissionMessage(const Message& message, const Packet&, const Now&) {
  const auto take = [&](const auto& m) {
    if (Collects() && !fusion_->Take(m)) Reject();
  };
  Handle(
      message, [&](const clock_t& clock) { Take(clock); },
      [&](const clearances_t& clearances) { Take(clearances); },
      [&](const answer_t& answer) { Take(answer); },
      [&](const agent_states_t& states) { take(states); },
      [&](const world_state_t& world) { take(world); },
      [&](const rulings_t& rulings) { take(rulings); });
}

bool SchedulerProcess::Collects() const {
  // Before it knows of earlier orders, a leg may lead to a task that is none yet.
  return due_ >= 0 && orders().complete(tick_ - 1);
}

void SchedulerProcess::Take(const answer_t& answer) {
  const bool has_reports = std::find(kReportChannels.begin(), kReportChannels.end(),
                                     answer.channel) != kReportChannels.end();
  if ((!has_reports && answer.channel != channel::kClearances) || !Answers(answer)) return;
  if (!has_reports) {
    const auto clearances = DecodeValid<clearances_t>(answer.data);
    if (!clearances || clearances->header.run_id != identity().run_id) return Reject();
    return Take(*clearances);
  }
  if (!Collects() || answer.data.empty()) return;
  const auto states = DecodeValid<agent_states_t>(answer.data);
  if (!states || states->header.run_id != identity().run_id || !fusion_->Take(*states)) {
    Reject();
  }
}

void SchedulerProcess::Take(const clearances_t& clearances) {
  if (!Possible(clearances, *scenario()) || !FromWire(clearances, WireLimits(*scenario()))) {
    return Reject();
  }
  clearances_.insert_or_assign(clearances.decision, clearances);
  if (clearances_.size() > kMostClearances) clearances_.erase(clearances_.begin());
}

bool SchedulerProcess::HasClearances() const {
  return scenario()->separation() == nullptr || in_force_ < 0 || clearances_.contains(in_force_);
}

void SchedulerProcess::Take(const clock_t& clock) {
  if (!Possible(clock, *scenario())) return Reject();
  Follow(clock);
  // A world that starts again may go back to an earlier tick, and what an earlier start of it said
  // may still be sent again for the log.
  if (clock.header.boot_id < world_boot_ && ++outdated_ < kMostOutdated) return;
  outdated_ = 0;
  const bool is_new_start = clock.header.boot_id != world_boot_;
  if (clock.phase != ClockPhase::kEnded && clock.tick <= tick_) repeat_tick_ = clock.tick;
  if (clock.tick == tick_ && due_ >= 0) ++n_repeats_;
  // One that names another decision than the one before: one of the two is damaged.
  const bool is_other = clock.tick == tick_ && clock.decision != named_;
  if (clock.tick <= tick_ && !is_new_start && !is_other) return;
  n_repeats_ = 0;
  world_boot_ = clock.header.boot_id;
  tick_ = clock.tick;
  tick_us_ = clock.tick_us;
  in_force_ = clock.required_decision;
  named_ = clock.decision;
  due_ = clock.tick == schedule_tick_ ? -1 : clock.decision;
  set_sim_us(tick_us_);
  if (due_ >= 0) fusion_->Start(tick_, tick_us_, due_);
}

void SchedulerProcess::OnMissionStep(const Now& now) {
  if (due_ >= 0 && !HasOrders(tick_, world_boot_, now)) return;
  if (due_ >= 0 && scenario()->rules.DecisionAt(tick_) != due_) {
    Reject();  // the true clock comes again
    due_ = -1;
  }
  if (due_ >= 0 && !HasClearances()) return Ask(channel::kClearances, tick_us_, now);
  if (due_ >= 0 && fusion_->complete()) {
    AskNoMore(now);
    Decide(now);
    repeat_tick_ = -1;
    return;
  }
  if (due_ >= 0 && n_repeats_ >= kManyRepeats) {
    // Each class in turn, for a second.
    const auto turn = static_cast<std::size_t>(now.monotonic_us / kSecondUs);
    Ask(kReportChannels[turn % kReportChannels.size()], tick_us_, now);
  } else {
    AskNoMore(now);
  }
  if (schedule_packet_ && repeat_tick_ == schedule_tick_) {
    if (clearances_packet_) sender().Resend(clearances_packet_);
    sender().Resend(schedule_packet_);
  }
  repeat_tick_ = -1;
}

event_t SchedulerProcess::MakeEvent(EventKind kind) const {
  event_t event{};
  event.kind = NumberOf(kind);
  event.at_us = tick_us_;
  event.uav_id = event.worker_id = event.vehicle_id = event.task_id = event.charge_id = -1;
  return event;
}

std::vector<event_t> SchedulerProcess::EventsOf(const Decision& decision) {
  std::vector<event_t> events;
  const auto tell = [&](EventKind kind, const std::string& detail) -> event_t& {
    events.push_back(MakeEvent(kind));
    events.back().detail = detail;
    return events.back();
  };
  if (!decision.refused.empty()) tell(EventKind::kAnswerRefused, decision.refused);
  for (const std::string& unkept : decision.unkept) {
    // Once, as long as the reason stays the same.
    const bool told = std::find(unkept_.begin(), unkept_.end(), unkept) != unkept_.end();
    if (!told) tell(EventKind::kDirectiveUnkept, unkept);
  }
  unkept_ = decision.unkept;
  for (const Action& action : decision.withheld) {
    event_t& event =
        tell(EventKind::kActionWithheld,
             fmt::format("no altitude is free within {} min", kMostHoldUs / kMinuteUs));
    event.uav_id = action.uav.value;
    event.worker_id = action.worker.value;
    event.vehicle_id = action.vehicle.value;
    event.task_id = action.task.value;
    event.charge_id = action.charge.value;
  }
  return events;
}

void SchedulerProcess::Decide(const Now& now) {
  const TimeUs begin = stopwatch_();
  Situation situation = fusion_->Fuse(orders());
  if (const auto known = clearances_.find(in_force_); known != clearances_.end()) {
    situation.clearances = *FromWire(known->second, WireLimits(*scenario()));
  }
  Decision decision;
  Compute([&] { decision = KeepApart(situation, DecideWithDirectives(situation, policy_.get())); });
  schedule_t schedule{};
  schedule.decision = due_;
  schedule.tick = tick_;
  schedule.policy = policy_name_;
  schedule.weight = decision.weight;
  schedule.bound = decision.bound;
  schedule.candidates = decision.candidates;
  for (const Action& action : decision.actions) schedule.actions.push_back(ToWire(action));
  schedule.n = static_cast<std::int32_t>(schedule.actions.size());
  schedule.solve_us = stopwatch_() - begin;
  std::optional<clearances_t> clearances;
  if (situation.site->separation) {
    clearances = ToWire(decision.clearances);
    clearances->decision = due_;
    clearances->tick = tick_;
  }
  Publish(std::move(schedule), std::move(clearances), EventsOf(decision), now);
  schedule_tick_ = tick_;
  due_ = -1;
}

void SchedulerProcess::Publish(schedule_t schedule, std::optional<clearances_t> clearances,
                               std::vector<event_t> events, const Now& now) {
  if (!process_name::IsOneOfSchedulers(identity().name)) {
    for (event_t& event : events) Announce(std::move(event), now);
    if (clearances) {
      clearances_packet_ =
          sender().Send(channel::kClearances, std::move(*clearances), tick_us_, now);
      Take(*DecodeValid<clearances_t>(clearances_packet_->bytes));
    }
    schedule_packet_ = sender().Send(channel::kSchedule, std::move(schedule), tick_us_, now);
    return;
  }
  proposal_t proposal{};
  header_t inside{};
  inside.run_id = identity().run_id;
  inside.sender = identity().name;
  proposal.schedule = std::move(schedule);
  proposal.schedule.header = inside;
  if (clearances) {
    clearances->header = inside;
    proposal.clearances.push_back(std::move(*clearances));
  }
  proposal.n_clearances = static_cast<std::int32_t>(proposal.clearances.size());
  for (event_t& event : events) event.header = inside;
  proposal.events = std::move(events);
  proposal.n_events = static_cast<std::int32_t>(proposal.events.size());
  schedule_packet_ = sender().Send(channel::kProposal, std::move(proposal), tick_us_, now);
}

}  // namespace muster::scheduler
