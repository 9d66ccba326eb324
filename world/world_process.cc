#include "world/world_process.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "base/sha256.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"
#include "world/to_wire.h"

namespace muster::world {
namespace {

using Presence = Peers::Presence;

constexpr TimeUs kLookUs = 20'000;
/// First and longest pause before it asks again; BackOff lengthens the latter after a long wait.
constexpr TimeUs kRepeatUs = 2'000;
constexpr TimeUs kLongestRepeatUs = 40'000;
/// Longest time for which it expects answers to stay as fast as they were lately.
constexpr TimeUs kMostStatesUs = 10'000;
constexpr TimeUs kMostScheduleUs = 200'000;
/// After one report the other reports are on their way, too. They take at most this long.
constexpr TimeUs kNextReportUs = 10'000;
/// Moving an agent, writing and reading its whole state takes about that.
constexpr TimeUs kWholeStateUs = 1;
/// A process that has not reported for so long may have started again, and may need the last
/// decision.
constexpr TimeUs kMissedUs = 300'000;
/// The recorder says at least every 200 ms what the log holds; one such message may be lost.
constexpr TimeUs kRecorderSilentUs = 450'000;

PerKind<ToldAgents> ToldOf(const std::shared_ptr<const Scenario>& shared) {
  return {ToldAgents(shared, AgentKind::kUav), ToldAgents(shared, AgentKind::kWorker),
          ToldAgents(shared, AgentKind::kVehicle)};
}

}  // namespace

std::set<std::string> SchedulerNames(int schedulers) {
  if (schedulers == 1) return {process_name::kScheduler};
  std::set<std::string> names;
  for (int i = 1; i <= schedulers; ++i) {
    names.insert(fmt::format("{}-{}", process_name::kScheduler, i));
  }
  return names;
}

WorldProcess::WorldProcess(const Identity& identity, Window window, ScenarioText text,
                           const WorldOptions& options)
    : Process(identity, window),
      text_(std::move(text)),
      desk_(ParseScenario(text_, "scenario"), options.orders),
      scenario_(desk_.scenario()),
      limits_(scenario_),
      options_(options),
      referee_(scenario_),
      clock_(scenario_.rules, options.rate),
      attendance_(scenario_, Peers(options.lost_after_us, this->identity().boot_id == 0)),
      restoring_(scenario_, this->identity().run_id),
      recorder_ready_(!options.recorded),
      told_(ToldOf(desk_.book().scenario())),
      driver_words_(scenario_),
      repeat_(kRepeatUs, kLongestRepeatUs, kSecondUs),
      schedulers_(SchedulerNames(options.schedulers)),
      ballot_(schedulers_) {
  for (const AgentKind kind : kAgentKinds) {
    for (const AgentSpec& spec : scenario_.agents(kind)) {
      const auto id = static_cast<std::int32_t>(agents_[kind].size());
      agents_[kind].push_back(StartOf(kind, id, spec, *scenario_.ways));
    }
  }
  for (const Outage& outage : options.faults.outages) {
    if (outage.agent < 0 || static_cast<std::size_t>(outage.agent) >= agents_[outage.kind].size()) {
      throw InputError("command line", "--outage",
                       fmt::format("{} {}", ToString(outage.kind), outage.agent),
                       "an agent of the scenario");
    }
    referee_.Add(outage);
  }
  for (const HiddenClosure& closure : options.faults.closures) {
    if (IsPossible(closure, scenario_)) continue;
    throw InputError("command line", "--closure", closure.fault,
                     "a scenario with roads, or with the key air for zone_unknown");
  }
}

void WorldProcess::OnMessage(const Message& message, const Packet& packet, const Now& now) {
  attendance_.peers().Hear(HeaderOf(message).sender, now.monotonic_us);
  Handle(
      message,
      [&](const agent_states_t& states) {
        if (packet.channel == ChannelOf(static_cast<AgentKind>(states.kind))) Take(states, &packet);
      },
      [&](const agent_changes_t& changes) { Take(changes, packet); },
      [&](const schedule_t& schedule) { Take(schedule, packet, now); },
      [&](const clearances_t& clearances) { Take(clearances, packet); },
      [&](const proposal_t& proposal) { Take(proposal, now); },
      [&](const request_t& request) { Answer(request, now); },
      [&](const answer_t& answer) { Take(answer); },
      [&](const event_t& event) {
        if (packet.channel != channel::kDriver || !driver_words_.Hear(event)) return;
        sender().Send(channel::kEvent, event_t(event), clock_.sim_us(), now);
      },
      [&](const order_t& order) {
        if (!desk_.book().takes_orders() || wait_ == Wait::kRestore) return;
        if (!desk_.Admits(order, identity().run_id)) return inbox().Reject();
        if (desk_.Hear(order)) return;
        const auto answer = answers_.find(desk_.AnsweredAt(order.id));
        if (answer != answers_.end()) sender().Resend(answer->second);
      },
      [&](const log_status_t&) {
        recorder_ready_ = true;
        recorder_heard_us_ = now.monotonic_us;
      },
      [&](const process_status_t& status) {
        if (status.name == status.header.sender) attendance_.peers().Introduce(status.name);
        attendance_.peers().SetDeciding(status.header.sender,
                                        status.state == ProcessState::kDeciding);
        if (status.state != ProcessState::kEnded) {
          if (ended()) sender().Resend(clock_packet_);  // it has not heard
          return;
        }
        attendance_.Leave(status.header.sender);
        if (attendance_.deserted() && ended()) repeat_.Stop();
      });
}

bool WorldProcess::IsForTick(std::int64_t tick) const {
  return wait_ != Wait::kRestore && tick == clock_.tick() && !ended();
}

void WorldProcess::Take(const answer_t& answer) {
  if (!Answers(answer)) return;
  if (wait_ == Wait::kRestore) {
    // A leg may lead to what an order has added.
    const OrderBook& book = desk_.book();
    if (book.takes_orders() && answer.channel != channel::kOrders && book.tick() < answer.tick &&
        !answer.data.empty()) {
      return;
    }
    if (!restoring_.Take(answer)) inbox().Reject();
    if (answer.channel == channel::kOrders && restoring_.book()) desk_.Take(*restoring_.book());
    return;
  }
  // Whole states, since changes rest on what this process has not heard.
  const auto states = DecodeValid<agent_states_t>(answer.data);
  if (!states || states->header.run_id != identity().run_id ||
      answer.channel != ChannelOf(static_cast<AgentKind>(states->kind))) {
    return inbox().Reject();
  }
  const Packet packet{answer.channel, answer.data};
  Take(*states, &packet);
}

void WorldProcess::Take(const agent_changes_t& changes, const Packet& packet) {
  const auto kind = static_cast<AgentKind>(changes.kind);
  if (!IsForTick(changes.tick) || packet.channel != ChangesChannelOf(kind)) return;
  if (static_cast<std::size_t>(changes.last_id) >= agents_[kind].size()) return inbox().Reject();
  for (std::int32_t id = changes.first_id; id <= changes.last_id; ++id) {
    if (!attendance_.MayReport(kind, id, changes.header.sender)) return inbox().Reject();
  }
  if (const auto states = told_[kind].Expand(changes)) return Take(*states, nullptr);
  if (!told_[kind].Possible(changes)) return inbox().Reject();
  base_lacks_[kind] = true;
}

void WorldProcess::Take(const agent_states_t& states, const Packet* packet) {
  const auto kind = static_cast<AgentKind>(states.kind);
  if (!IsForTick(states.tick)) return;
  std::vector<AgentState> agents;
  agents.reserve(states.agents.size());
  for (const agent_t& wire : states.agents) {
    const std::optional<AgentState> agent = FromWire(wire, kind, clock_.sim_us(), limits_);
    if (!agent) return inbox().Reject();
    agents.push_back(*agent);
  }
  for (const AgentState& agent : agents) {
    if (!attendance_.MayReport(kind, agent.id, states.header.sender)) return inbox().Reject();
  }
  const auto lacks_reason = [this](const AgentState& agent) {
    return SaysToFail(agent) && driver_words_.Awaits(agent);
  };
  if (std::any_of(agents.begin(), agents.end(), lacks_reason)) return;
  bool news = false;
  for (const AgentState& agent : agents) {
    if (!attendance_.Report(kind, agent.id, states.header.sender)) continue;
    TakeIn(agent);
    news = true;
  }
  if (!news) return;
  has_news_ = true;
  if (packet == nullptr) return handover_.Add(kind, states);
  told_[kind].Take(states);
  handover_.Add(kind, *packet);
}

bool WorldProcess::SaysToFail(const AgentState& agent) const {
  return agent.measured && agent.failed && !referee_.has_failed(agent.kind, agent.id);
}

void WorldProcess::TakeIn(AgentState agent) {
  if (SaysToFail(agent)) {
    agent.failed = false;
    referee_.Add({agent.kind,
                  agent.id,
                  clock_.sim_us(),
                  kNever,
                  {FailureReason::Cause::kSaid, driver_words_.WhyFailed(agent)}});
  }
  agents_.at(agent.kind, agent.id) = agent;
}

void WorldProcess::Answer(const request_t& request, const Now& now) {
  if (request.channel == channel::kScenario && scenario_packet_) {
    TellScenarioAgain();
    if (clock_packet_) sender().Resend(clock_packet_);
  }
  if (wait_ == Wait::kRestore) return;
  if (request.channel == channel::kOrders && desk_.book().takes_orders()) {
    Process::Answer(request, desk_.book().tick(), BookBytes(desk_.book(), identity()),
                    clock_.sim_us(), now);
  }
  if (request.channel == channel::kClearances && clearances_packet_) {
    Process::Answer(request, clearances_decision_, clearances_packet_->bytes, clock_.sim_us(), now);
  }
  for (const AgentKind kind : kAgentKinds) {
    if (request.channel != ChannelOf(kind)) continue;
    const auto answer = [&](std::vector<std::uint8_t> bytes) {
      Process::Answer(request, handover_.tick(), std::move(bytes), clock_.sim_us(), now);
    };
    if (handover_.tick() < 0 && clock_.tick() == 0) answer({});
    for (auto& states : handover_.StatesOf(kind, identity(), now)) {
      answer(std::move(states));
    }
  }
}

void WorldProcess::FindClosures() {
  if (options_.faults.closures.empty() || desk_.book().complete(clock_.tick())) return;
  const std::int64_t last_tick = clock_.tick() - 1;
  const Commands commands{commanded_, clock_.required_decision(), clock_.TimeOf(last_tick)};
  static const std::vector<Action> kNone;
  const Commands none{kNone};
  for (const HiddenClosure& closure : options_.faults.closures) {
    const std::string id = OrderIdOf(closure);
    if (desk_.AnsweredAt(id) >= 0) continue;
    if (!IsToldOrMet(closure, clock_.sim_us(), scenario_, agents_,
                     schedule_tick_ == last_tick ? commands : none)) {
      continue;
    }
    desk_.Give(id, OrderOf(closure, clock_.sim_us(), scenario_.rules));
  }
}

void WorldProcess::SayOfClosures(const Now& now) {
  const TimeUs t = clock_.sim_us();
  const TimeUs before = clock_.tick() > 0 ? clock_.TimeOf(clock_.tick() - 1) : -1;
  const auto say = [&](const HiddenClosure& closure, EventKind kind, TimeUs at_us) {
    if (at_us <= before || at_us > t) return;
    event_t event{};
    event.kind = NumberOf(kind);
    event.at_us = at_us;
    event.uav_id = event.worker_id = event.vehicle_id = event.task_id = event.charge_id = -1;
    event.fault_id = closure.fault;
    event.detail = identity().name;
    sender().Send(channel::kEvent, std::move(event), t, now);
  };
  for (const HiddenClosure& closure : options_.faults.closures) {
    say(closure, EventKind::kFaultApplied, closure.from_us);
    say(closure, EventKind::kFaultEnded, closure.until_us);
  }
}

void WorldProcess::TakeOrders(const Now& now) {
  if (!desk_.book().takes_orders()) return;
  FindClosures();
  const std::int64_t tick = clock_.tick();
  orders_packet_ = sender().Send(
      channel::kOrders, desk_.Decide(tick, referee_.task_status(), agents_), clock_.sim_us(), now);
  const auto orders = DecodeValid<orders_t>(orders_packet_->bytes);
  desk_.Take(*orders);
  if (orders->n_taken + orders->n_refused > 0) answers_[tick] = orders_packet_;
  for (const TakenOrder& order : desk_.book().TakenAt(tick)) referee_.Take(order);
}

void WorldProcess::PublishClock(const Now& now) {
  set_sim_us(clock_.sim_us());
  clock_packet_ = sender().Send(channel::kClock, clock_.ToWire(), clock_.sim_us(), now);
}

void WorldProcess::Judge(const Now& now) {
  const TimeUs t = clock_.sim_us();
  base_lacks_ = {};
  ForgetQuestions();
  for (const std::string& name : attendance_.TakeBack()) {
    referee_.EndOutages(FailureReason::LossOf(name), t);
    SayOfProcess(Event::Kind::kProcessBack, name, now);
  }
  referee_.Judge(t, clock_.decision(), &agents_);
  handover_.Judge(clock_.tick(), t, clock_.required_decision());
  for (const AgentKind kind : kAgentKinds) {
    for (const AgentState& agent : agents_[kind]) {
      if (attendance_.reported(kind, agent.id)) continue;
      handover_.AddUnreported(kind, muster::ToWire(agent, t, scenario_.tasks));
    }
  }
  const std::int64_t tick = clock_.tick();
  world_packet_ = sender().Send(channel::kWorld, WorldStateOf(referee_, tick), t, now);
  rulings_packet_ = sender().Send(channel::kRulings, RulingsOf(referee_.verdict(), tick), t, now);
  PublishEvents(now);
  SayOfClosures(now);
}

void WorldProcess::PublishEvents(const Now& now) {
  for (const Event& event : referee_.TakeEvents()) {
    desk_.EndFulfilled(event);
    desk_.DecideIfReopened(event);
    if (event.kind == Event::Kind::kSensingDone &&
        scenario_.tasks[event.task.index()].revisit_us != kNever) {
      desk_.Revisit(event.task, event.at_us);
    }
    const bool applied = event.kind == Event::Kind::kFaultApplied;
    if (!applied) sender().Send(channel::kEvent, ToWire(event), clock_.sim_us(), now);
    const bool failed = applied || event.kind == Event::Kind::kAgentFailed;
    if (event.by_fault.empty()) continue;
    event_t confirmation = ToWire(event);
    confirmation.kind = NumberOf(failed ? EventKind::kFaultApplied : EventKind::kFaultEnded);
    confirmation.fault_id = event.by_fault;
    confirmation.detail = identity().name;
    sender().Send(channel::kEvent, std::move(confirmation), clock_.sim_us(), now);
  }
}

void WorldProcess::WaitFor(Wait wait, const Now& now) {
  wait_ = wait;
  asked_us_ = now.monotonic_us;
  const TimeUs whole_us = clock_.decision() >= 0 ? AllWholeUs() : 0;
  const TimeUs first_us =
      wait == Wait::kStates ? std::max(states_time_.Patience(kRepeatUs, kMostStatesUs), whole_us)
      : wait == Wait::kSchedule ? schedule_time_.Patience(kRepeatUs, kMostScheduleUs)
                                : kRepeatUs;
  repeat_ = BackOff(first_us, kLongestRepeatUs, kSecondUs);
  repeat_.Start(now.monotonic_us);
  attendance_.peers().AwaitFrom(now.monotonic_us);
  if (wait == Wait::kSchedule) ballot_.Open(now.monotonic_us);
  look_us_ = now.monotonic_us;
}

TimeUs WorldProcess::AllWholeUs() const {
  const std::size_t n =
      scenario_.uavs.size() + scenario_.workers.size() + scenario_.vehicles.size();
  return static_cast<TimeUs>(n) * kWholeStateUs;
}

void WorldProcess::StopWaiting() {
  wait_ = Wait::kClock;
  repeat_.Stop();
}

void WorldProcess::SayOfProcess(Event::Kind kind, const std::string& name, const Now& now) {
  Event event;
  event.kind = kind;
  event.at_us = clock_.sim_us();
  event.detail = name;
  sender().Send(channel::kEvent, ToWire(event), clock_.sim_us(), now);
}

void WorldProcess::FindLost(const Now& now) {
  if (!options_.goes_on || clock_.phase() != Phase::kRunning || now.monotonic_us < look_us_) return;
  look_us_ = now.monotonic_us + kLookUs;
  Peers& peers = attendance_.peers();
  if (wait_ == Wait::kStates) {
    for (const std::string& name : attendance_.Owing()) {
      if (peers.Overdue(name, now.monotonic_us)) Lose(name, now);
    }
  }
  const auto is_overdue = [&](const std::string& name) {
    return peers.Overdue(name, now.monotonic_us);
  };
  if (wait_ == Wait::kSchedule && ballot_.empty() &&
      std::all_of(schedulers_.begin(), schedulers_.end(), is_overdue)) {
    for (const std::string& name : schedulers_) Lose(name, now);
    StopWaiting();  // This decision will not be in force: no clock names it.
  }
}

bool WorldProcess::LogHolds(const Now& now) const {
  if (!options_.recorded) return false;
  const TimeUs longest_us = std::max(options_.lost_after_us / 4, kRecorderSilentUs);
  return sender().HeldUs(now) > longest_us || now.monotonic_us - recorder_heard_us_ > longest_us;
}

void WorldProcess::Lose(const std::string& name, const Now& now) {
  if (!attendance_.Lose(name)) return;
  SayOfProcess(Event::Kind::kProcessLost, name, now);
  // Nobody knows what became of its agents since they were heard.
  attendance_.ForEachAgentOf(name, [&](AgentKind kind, std::int32_t id) {
    referee_.Add(
        {kind, id, clock_.TimeOf(clock_.tick() - 1) + 1, kNever, FailureReason::LossOf(name)});
  });
}

void WorldProcess::TellScenario(const Now& now) {
  scenario_t scenario{};
  scenario.sha256 = Sha256(text_.json);
  scenario.json = text_.json;
  scenario_packet_ = sender().Send(channel::kScenario, std::move(scenario), 0, now);
  if (text_.roads.empty()) return;
  roads_t roads{};
  roads.sha256 = Sha256(text_.roads);
  roads.roads = text_.roads;
  roads_packet_ = sender().Send(channel::kRoads, std::move(roads), 0, now);
}

void WorldProcess::TellScenarioAgain() {
  sender().Resend(scenario_packet_);
  if (roads_packet_) sender().Resend(roads_packet_);
}

void WorldProcess::Begin(const Now& now) {
  if (clock_.phase() == Phase::kReady) set_state(ProcessState::kReady);
  PublishClock(now);
  WaitFor(Wait::kStates, now);
}

void WorldProcess::OnStep(const Now& now) {
  attendance_.peers().NoteAwake(now.monotonic_us);
  if (LogHolds(now)) attendance_.peers().NoteHeld(now.monotonic_us);
  if (!scenario_packet_) {
    TellScenario(now);
    if (identity().boot_id > 0) {
      WaitFor(Wait::kRestore, now);
      AskForState(now);
    } else {
      TakeOrders(now);
      Begin(now);
    }
  }
  if (wait_ == Wait::kRestore) {
    if (!repeat_.Fire(now.monotonic_us)) return;
    if (!RestoreState(now)) return AskForState(now);
  }
  FindLost(now);
  GoOn(now);
}

void WorldProcess::GoOn(const Now& now) {
  if (wait_ == Wait::kStates && attendance_.complete() && recorder_ready_) {
    states_time_.Note(now.monotonic_us - asked_us_);
    if (clock_.phase() == Phase::kReady) {
      clock_.Start(now.monotonic_us);
      set_state(ProcessState::kRunning);
      PublishClock(now);
    }
    Judge(now);
    if (clock_.awaits_decision()) return WaitFor(Wait::kSchedule, now);
    StopWaiting();
  }
  if (wait_ == Wait::kSchedule) CloseBallot(now);
  if (wait_ == Wait::kClock) {
    PublishEvents(now);  // of the decision just taken
    if (!clock_.is_last()) {
      if (now.monotonic_us >= clock_.NextTickUs()) StartTick(now);
      return;
    }
    wait_ = Wait::kLog;
  }
  if (wait_ == Wait::kLog) {
    if (options_.recorded && !sender().drained()) return;
    clock_.End();
    set_state(ProcessState::kEnded);
    PublishClock(now);
    return WaitFor(Wait::kNothing, now);
  }
  if (std::exchange(has_news_, false) && wait_ == Wait::kStates) {
    const TimeUs next_us =
        states_time_.known() ? states_time_.Patience(kRepeatUs, kNextReportUs) : kNextReportUs;
    repeat_ = BackOff(std::max(next_us, AllWholeUs()), kLongestRepeatUs, kSecondUs);
    repeat_.Start(now.monotonic_us);
  }
  if (repeat_.Fire(now.monotonic_us)) Repeat(now);
}

void WorldProcess::StartTick(const Now& now) {
  clock_.Advance();
  attendance_.StartTick();
  TakeOrders(now);
  PublishClock(now);
  WaitFor(Wait::kStates, now);
}

void WorldProcess::Repeat(const Now& now) {
  if (!ended()) {
    if (clock_.phase() == Phase::kReady) TellScenarioAgain();
    const bool schedule_lacks =
        clock_.tick() == schedule_tick_ + 1 || now.monotonic_us - asked_us_ > kMissedUs;
    if (schedule_packet_ && wait_ == Wait::kStates && schedule_lacks) {
      if (clearances_packet_) sender().Resend(clearances_packet_);
      sender().Resend(schedule_packet_);
    }
    if (orders_packet_) sender().Resend(orders_packet_);
    if (world_packet_) sender().Resend(world_packet_);
    if (rulings_packet_) sender().Resend(rulings_packet_);
    for (const AgentKind kind : kAgentKinds) {
      if (wait_ == Wait::kStates && base_lacks_[kind]) {
        Request(ChannelOf(kind), clock_.sim_us(), now);
      }
    }
  }
  sender().Resend(clock_packet_);
}

TimeUs WorldProcess::OwnWakeUs() const {
  if (wait_ == Wait::kClock) return clock_.NextTickUs();
  // If it slept until something arrives, it would take itself for held up and never miss a process.
  const bool misses = options_.goes_on && wait_ != Wait::kNothing;
  return std::min({repeat_.due_us(), misses ? attendance_.peers().AwakeUntilUs() : kNever,
                   wait_ == Wait::kSchedule ? ballot_.due_us() : kNever});
}

}  // namespace muster::world
