#include "world/world_process.h"

#include <fmt/format.h>

#include <algorithm>
#include <muster/clock_t.hpp>

#include "base/check.h"
#include "base/sha256.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"

namespace muster::world {
namespace {

constexpr TimeUs kLookUs = 20'000;
/// So long a restarted world listens, where a verdict may have been given without somebody: who
/// has listened answers twice in this time.
constexpr TimeUs kHearAllUs = 600'000;
/// So long it waits for a report that must have been made, and that perhaps nobody has any more.
constexpr TimeUs kGiveUpUs = 10 * kSecondUs;

std::string LostDetail(const std::string& process) { return process + " is lost"; }

event_t ToWire(const Event& event) {
  event_t wire{};
  wire.kind = NumberOf(event.kind);
  wire.at_us = event.at_us;
  wire.uav_id = event.uav.value;
  wire.worker_id = event.worker.value;
  wire.vehicle_id = event.vehicle.value;
  wire.task_id = event.task.value;
  wire.charge_id = event.charge.value;
  wire.detail = event.detail;
  return wire;
}

}  // namespace

WorldProcess::WorldProcess(Identity identity, int window, std::string json,
                           const WorldOptions& options)
    : Process(std::move(identity), window),
      json_(std::move(json)),
      scenario_(ParseScenario(json_, "scenario")),
      limits_(scenario_),
      options_(options),
      referee_(scenario_),
      peers_(options.lost_after_us, this->identity().boot_id == 0),
      restoring_(scenario_, this->identity().run_id) {
  last_tick_ = scenario_.rules.last_tick();
  for (const AgentKind kind : kAgentKinds) {
    const std::size_t n = scenario_.agents(kind).size();
    agents_.of(kind).resize(n);
    owners_[static_cast<int>(kind)].resize(n);
    heard_[static_cast<int>(kind)].assign(n, Heard::kNot);
    missing_ += n;
  }
  recorder_ready_ = !options.recorded;
  for (const Outage& outage : options.outages) {
    if (outage.agent < 0 ||
        static_cast<std::size_t>(outage.agent) >= agents_.of(outage.kind).size()) {
      throw InputError("command line", "--outage",
                       fmt::format("{} {}", ToString(outage.kind), outage.agent),
                       "an agent of the scenario");
    }
    referee_.Add(outage);
  }
}

void WorldProcess::OnMessage(const Message& message, const Packet& packet, const Now& now) {
  peers_.Hear(HeaderOf(message).sender, now.monotonic_us);
  Handle(
      message, [&](const agent_states_t& states) { Take(states, packet); },
      [&](const schedule_t& schedule) { Take(schedule, packet, now); },
      [&](const request_t& request) { Answer(request, now); },
      [&](const restore_t& restore) {
        if (wait_ == Wait::kRestore && !restoring_.Take(restore)) inbox().Reject();
      },
      [&](const log_status_t&) { recorder_ready_ = true; },
      [&](const process_status_t& status) {
        if (static_cast<ProcessState>(status.state) != ProcessState::kEnded) return;
        members_.erase(status.header.sender);
        if (members_.empty() && phase_ == Phase::kEnded) repeat_.Stop();
      });
}

void WorldProcess::Take(const agent_states_t& states, const Packet& packet) {
  const auto kind = static_cast<AgentKind>(states.kind);
  const auto k = static_cast<std::size_t>(states.kind);
  if (wait_ == Wait::kRestore || states.tick != tick_ || phase_ == Phase::kEnded ||
      packet.channel != ChannelOf(kind))
    return;
  const TimeUs t = tick_us(tick_);
  const std::string& sender = states.header.sender;
  std::vector<AgentState> agents;
  for (const agent_t& wire : states.agents) {
    const std::optional<AgentState> agent = FromWire(wire, kind, t, limits_);
    if (!agent) return inbox().Reject();
    agents.push_back(*agent);
  }
  bool news = false;
  for (const AgentState& agent : agents) {
    const auto id = static_cast<std::size_t>(agent.id);
    if (!owners_[k][id].empty() && owners_[k][id] != sender) {
      throw InputError(
          fmt::format("{} {} is reported by two processes, {} and {}: give each its --ids",
                      ToString(kind), id, owners_[k][id], sender));
    }
    owners_[k][id] = sender;
    members_.insert(sender);
    // One that is lost is awaited from the next tick on.
    if (heard_[k][id] != Heard::kNot) continue;
    --missing_;
    heard_[k][id] = Heard::kYes;
    news = true;
    agents_.of(kind)[id] = agent;
  }
  if (news) reports_[k].push_back(packet);
}

void WorldProcess::Take(const schedule_t& schedule, const Packet& packet, const Now& now) {
  if (wait_ != Wait::kSchedule || schedule.decision != DecisionAt(tick_) ||
      schedule.tick != tick_) {
    return;
  }
  std::vector<Action> actions;
  for (const action_t& wire : schedule.actions) {
    const std::optional<Action> action = FromWire(wire, limits_);
    if (!action) {
      inbox().Reject();
      return;
    }
    actions.push_back(*action);
  }
  referee_.Take(schedule.decision, actions);
  members_.insert(schedule.header.sender);
  scheduler_name_ = schedule.header.sender;
  if (peers_.presence(scheduler_name_) != Peers::Presence::kThere) {
    peers_.set_presence(scheduler_name_, Peers::Presence::kThere);
    SayOfProcess(Event::Kind::kProcessBack, scheduler_name_, now);
  }
  schedule_packet_ = std::make_shared<const Packet>(packet);
  required_decision_ = schedule.decision;
  wait_ = Wait::kClock;
  repeat_.Stop();
}

void WorldProcess::Answer(const request_t& request, const Now& now) {
  if (request.channel == channel::kScenario && scenario_packet_) {
    sender().Resend(scenario_packet_);
    if (clock_packet_) sender().Resend(clock_packet_);
  }
  if (wait_ == Wait::kRestore) return;
  for (const AgentKind kind : kAgentKinds) {
    if (request.channel != ChannelOf(kind)) continue;
    // The states that the newest verdict rests on: whoever goes on from them needs only that
    // verdict and what follows, and that is what this process repeats.
    const auto& packets = judged_reports_[static_cast<int>(kind)];
    const auto answer = [&](std::vector<std::uint8_t> bytes) {
      restore_t restore{};
      restore.channel = request.channel;
      restore.tick = judged_tick_;
      restore.data = std::move(bytes);
      restore.n = static_cast<std::int32_t>(restore.data.size());
      sender().Send(channel::kRestore, std::move(restore), tick_us(tick_), now);
    };
    if (judged_tick_ < 0 && tick_ == 0) answer({});
    for (const Packet& packet : packets) answer(packet.bytes);
    for (std::vector<std::uint8_t>& bytes : StatesOfLost(kind, now)) answer(std::move(bytes));
  }
}

void WorldProcess::AskForState(const Now& now) {
  for (const std::string_view name : {channel::kUavs, channel::kWorkers, channel::kVehicles,
                                      channel::kWorld, channel::kRulings, channel::kClock}) {
    request_t request{};
    request.channel = name;
    sender().Send(channel::kRequest, std::move(request), 0, now);
  }
}

bool WorldProcess::RestoreState(const Now& now) {
  const std::optional<Restoring::State> state =
      options_.goes_on ? restoring_.NewestWithoutLost() : restoring_.Newest();
  if (!state) return false;
  // Whoever is there has answered by then.
  const TimeUs enough_us = !state->is_certain     ? std::max(kGiveUpUs, options_.lost_after_us)
                           : !state->lost.empty() ? std::max(kHearAllUs, options_.lost_after_us)
                           : options_.goes_on     ? kHearAllUs
                                                  : 0;
  if (peers_.AwaitedUs(now.monotonic_us) < enough_us) return false;
  tick_ = state->tick;
  if (tick_ > 0) {
    referee_.Restore(tick_us(tick_ - 1), state->task_status, state->verdict);
    phase_ = Phase::kRunning;
    set_state(ProcessState::kRunning);
    required_decision_ = state->applied_decision;
    if (state->next_decision && *state->next_decision < DecisionAt(tick_)) {
      passed_over_ = DecisionAt(tick_);
    }
    if (options_.rate > 0) {
      started_us_ = now.monotonic_us - ToUs(ToSeconds(tick_us(tick_)) / options_.rate);
    }
  }
  for (const AgentKind kind : kAgentKinds) {
    auto& owners = owners_[static_cast<int>(kind)];
    for (std::size_t id = 0; id < owners.size(); ++id) {
      owners[id] = restoring_.OwnerOf(kind, static_cast<std::int32_t>(id));
    }
  }
  Begin(now);
  // This tick may have been judged before, with what its reporters can no longer repeat.
  for (const Packet& packet : state->reports) {
    if (const auto states = DecodeValid<agent_states_t>(packet.bytes)) Take(*states, packet);
  }
  for (const Restoring::Lost& lost : state->lost) RestoreLost(lost);
  return true;
}

void WorldProcess::RestoreLost(const Restoring::Lost& lost) {
  const AgentKind kind = lost.agent.kind;
  const auto k = static_cast<std::size_t>(kind);
  const auto id = static_cast<std::size_t>(lost.agent.id);
  const std::string& owner = owners_[k][id];
  if (!lost.returns) {
    agents_.of(kind)[id] = lost.agent;
    missing_ -= heard_[k][id] == Heard::kNot;
    heard_[k][id] = Heard::kNotAwaited;
  }
  using Presence = Peers::Presence;
  peers_.set_presence(owner,
                      lost.returns || peers_.heard(owner) ? Presence::kReturning : Presence::kLost);
  referee_.Add({kind, lost.agent.id, lost.from_us, kNever, LostDetail(owner)});
}

void WorldProcess::PublishClock(const Now& now) {
  clock_t clock{};
  clock.tick = tick_;
  clock.tick_us = tick_us(tick_);
  clock.limit_us = scenario_.rules.limit_us;
  clock.decision = DecisionAt(tick_);
  clock.required_decision = required_decision_;
  clock.phase = NumberOf(phase_);
  set_sim_us(clock.tick_us);
  clock_packet_ = sender().Send(channel::kClock, clock, clock.tick_us, now);
}

void WorldProcess::Judge(const Now& now) {
  const TimeUs t = tick_us(tick_);
  for (const AgentKind kind : kAgentKinds) {
    const int k = static_cast<int>(kind);
    judged_reports_[k] = std::exchange(reports_[k], {});
  }
  TakeBack(now);
  judged_tick_ = tick_;
  judged_applied_ = required_decision_;
  referee_.Judge(t, DecisionAt(tick_), &agents_);
  for (const AgentKind kind : kAgentKinds) {
    const int k = static_cast<int>(kind);
    unreported_[k].clear();
    for (std::size_t id = 0; id < heard_[k].size(); ++id) {
      if (heard_[k][id] == Heard::kYes) continue;
      unreported_[k].push_back(ToWire(agents_.of(kind)[id], t, scenario_.tasks));
    }
  }
  world_state_t world{};
  world.tick = tick_;
  world.done = referee_.done();
  world.n_tasks = static_cast<std::int32_t>(scenario_.tasks.size());
  for (const TaskStatus status : referee_.task_status()) {
    world.task_status.push_back(static_cast<std::int8_t>(status));
  }
  for (const Activity& activity : referee_.verdict().activities()) {
    world.activities.push_back(ToWire(activity));
  }
  world.n_activities = static_cast<std::int32_t>(world.activities.size());
  rulings_t rulings{};
  rulings.tick = tick_;
  for (const Ruling& ruling : referee_.verdict().rulings()) {
    rulings.rulings.push_back(ToWire(ruling));
  }
  rulings.n = static_cast<std::int32_t>(rulings.rulings.size());
  world_packet_ = sender().Send(channel::kWorld, std::move(world), t, now);
  rulings_packet_ = sender().Send(channel::kRulings, std::move(rulings), t, now);
  PublishEvents(now);
}

void WorldProcess::PublishEvents(const Now& now) {
  for (const Event& event : referee_.TakeEvents()) {
    const bool applied = event.kind == Event::Kind::kFaultApplied;
    if (!applied) sender().Send(channel::kEvent, ToWire(event), tick_us(tick_), now);
    const bool failed = applied || event.kind == Event::Kind::kAgentFailed;
    if (!failed && event.kind != Event::Kind::kAgentBack) continue;
    const bool ordered =
        std::any_of(options_.outages.begin(), options_.outages.end(),
                    [&](const Outage& outage) { return outage.detail == event.detail; });
    if (!ordered) continue;
    event_t confirmation = ToWire(event);
    confirmation.kind = NumberOf(failed ? EventKind::kFaultApplied : EventKind::kFaultEnded);
    confirmation.fault_id = event.detail;
    confirmation.detail = identity().name;
    sender().Send(channel::kEvent, std::move(confirmation), tick_us(tick_), now);
  }
}

void WorldProcess::WaitFor(Wait wait, const Now& now) {
  wait_ = wait;
  repeat_.Start(now.monotonic_us);
  peers_.AwaitFrom(now.monotonic_us);
  look_us_ = now.monotonic_us;
}

template <class Visit>
void WorldProcess::ForEachAgentOf(const std::string& owner, Visit visit) {
  for (const AgentKind kind : kAgentKinds) {
    const auto& owners = owners_[static_cast<int>(kind)];
    for (std::size_t id = 0; id < owners.size(); ++id) {
      if (owners[id] == owner) visit(kind, id);
    }
  }
}

void WorldProcess::SayOfProcess(Event::Kind kind, const std::string& name, const Now& now) {
  Event event;
  event.kind = kind;
  event.at_us = tick_us(tick_);
  event.detail = name;
  sender().Send(channel::kEvent, ToWire(event), tick_us(tick_), now);
}

void WorldProcess::FindLost(const Now& now) {
  if (!options_.goes_on || phase_ != Phase::kRunning || now.monotonic_us < look_us_) return;
  look_us_ = now.monotonic_us + kLookUs;
  if (wait_ == Wait::kStates) {
    std::set<std::string> owing;
    for (const AgentKind kind : kAgentKinds) {
      const auto k = static_cast<std::size_t>(kind);
      for (std::size_t id = 0; id < heard_[k].size(); ++id) {
        if (heard_[k][id] == Heard::kNot) owing.insert(owners_[k][id]);
      }
    }
    for (const std::string& name : owing) {
      if (peers_.Overdue(name, now.monotonic_us)) Lose(name, now);
    }
  }
  if (wait_ == Wait::kSchedule && peers_.Overdue(scheduler_name_, now.monotonic_us)) {
    if (peers_.presence(scheduler_name_) == Peers::Presence::kThere) {
      SayOfProcess(Event::Kind::kProcessLost, scheduler_name_, now);
    }
    peers_.set_presence(scheduler_name_, Peers::Presence::kLost);
    // This decision will not be in force: no clock names it.
    wait_ = Wait::kClock;
    repeat_.Stop();
  }
}

void WorldProcess::Lose(const std::string& name, const Now& now) {
  const bool is_new = peers_.presence(name) == Peers::Presence::kThere;
  peers_.set_presence(name, Peers::Presence::kLost);
  if (is_new) SayOfProcess(Event::Kind::kProcessLost, name, now);
  ForEachAgentOf(name, [&](AgentKind kind, std::size_t id) {
    Heard& heard = heard_[static_cast<int>(kind)][id];
    if (heard == Heard::kNot) {
      --missing_;
      heard = Heard::kNotAwaited;
    }
    // Nobody knows what became of it since it was heard.
    if (is_new) {
      referee_.Add(
          {kind, static_cast<std::int32_t>(id), tick_us(tick_ - 1) + 1, kNever, LostDetail(name)});
    }
  });
}

void WorldProcess::TakeBack(const Now& now) {
  for (const std::string& name : peers_.NamesOf(Peers::Presence::kReturning)) {
    if (name == scheduler_name_) continue;
    bool complete = true;
    ForEachAgentOf(name, [&](AgentKind kind, std::size_t id) {
      complete &= heard_[static_cast<int>(kind)][id] == Heard::kYes;
    });
    if (!complete) continue;
    peers_.set_presence(name, Peers::Presence::kThere);
    referee_.EndOutages(LostDetail(name), tick_us(tick_));
    SayOfProcess(Event::Kind::kProcessBack, name, now);
  }
}

std::vector<std::vector<std::uint8_t>> WorldProcess::StatesOfLost(AgentKind kind,
                                                                  const Now& now) const {
  std::vector<std::vector<std::uint8_t>> messages;
  if (judged_tick_ < 0) return messages;
  for (agent_states_t& states :
       StatesMessages(kind, judged_tick_, judged_applied_, unreported_[static_cast<int>(kind)])) {
    states.header.run_id = identity().run_id;
    states.header.sender = identity().name;
    states.header.boot_id = identity().boot_id;
    states.header.sim_us = tick_us(judged_tick_);
    states.header.wall_us = now.wall_us;
    messages.push_back(Encode(states));
  }
  return messages;
}

void WorldProcess::Begin(const Now& now) {
  if (phase_ == Phase::kReady) set_state(ProcessState::kReady);
  PublishClock(now);
  WaitFor(Wait::kStates, now);
}

void WorldProcess::OnStep(const Now& now) {
  peers_.NoteAwake(now.monotonic_us);
  if (!scenario_packet_) {
    scenario_t scenario{};
    scenario.sha256 = Sha256(json_);
    scenario.json = json_;
    scenario_packet_ = sender().Send(channel::kScenario, std::move(scenario), 0, now);
    if (identity().boot_id > 0) {
      WaitFor(Wait::kRestore, now);
      AskForState(now);
    } else {
      Begin(now);
    }
  }
  if (wait_ == Wait::kRestore) {
    if (!repeat_.Fire(now.monotonic_us)) return;
    if (!RestoreState(now)) return AskForState(now);
  }
  FindLost(now);
  // Each turn of the loop is one step of the lockstep that needs no further input.
  while (true) {
    if (wait_ == Wait::kStates && StatesComplete() && recorder_ready_) {
      if (phase_ == Phase::kReady) {
        phase_ = Phase::kRunning;
        started_us_ = now.monotonic_us;
        set_state(ProcessState::kRunning);
        PublishClock(now);
      }
      Judge(now);
      if (DecisionAt(tick_) > passed_over_) {
        WaitFor(Wait::kSchedule, now);
        return;
      }
      wait_ = Wait::kClock;
      repeat_.Stop();
      continue;
    }
    if (wait_ == Wait::kClock) {
      PublishEvents(now);  // of the decision just taken
      if (tick_ == last_tick_) {
        wait_ = Wait::kLog;
        continue;
      }
      if (now.monotonic_us < OwnWakeUs()) return;
      StartTick(now);
    }
    if (wait_ == Wait::kLog) {
      if (options_.recorded && !sender().drained()) return;
      phase_ = Phase::kEnded;
      set_state(ProcessState::kEnded);
      PublishClock(now);
      WaitFor(Wait::kNothing, now);
      return;
    }
    break;
  }
  if (repeat_.Fire(now.monotonic_us)) Repeat();
}

void WorldProcess::StartTick(const Now& now) {
  ++tick_;
  missing_ = 0;
  for (const AgentKind kind : kAgentKinds) {
    auto& heard = heard_[static_cast<int>(kind)];
    std::fill(heard.begin(), heard.end(), Heard::kNot);
    missing_ += heard.size();
  }
  for (const std::string& name : peers_.NamesOf(Peers::Presence::kLost)) {
    ForEachAgentOf(name, [&](AgentKind kind, std::size_t id) {
      heard_[static_cast<int>(kind)][id] = Heard::kNotAwaited;
      --missing_;
    });
  }
  PublishClock(now);
  WaitFor(Wait::kStates, now);
}

void WorldProcess::Repeat() {
  if (phase_ == Phase::kEnded) {
    sender().Resend(clock_packet_);
    return;
  }
  if (phase_ == Phase::kReady) sender().Resend(scenario_packet_);
  if (schedule_packet_ && wait_ == Wait::kStates) sender().Resend(schedule_packet_);
  if (world_packet_) sender().Resend(world_packet_);
  if (rulings_packet_) sender().Resend(rulings_packet_);
  sender().Resend(clock_packet_);
}

TimeUs WorldProcess::OwnWakeUs() const {
  if (wait_ == Wait::kClock && options_.rate > 0) {
    return started_us_ + ToUs(ToSeconds(tick_us(tick_ + 1)) / options_.rate);
  }
  return wait_ == Wait::kClock ? 0 : repeat_.due_us();
}

}  // namespace muster::world
