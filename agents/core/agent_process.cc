#include "agents/core/agent_process.h"

#include <algorithm>
#include <muster/agent_states_t.hpp>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/own_rule.h"

namespace muster::agents {
namespace {

/// A process that has the schedule answers sooner. After this time a move goes to the goal that the
/// report tells.
constexpr TimeUs kGoalPatienceUs = 4 * kSecondUs;
/// However far apart decisions are, a log tells everything at least so often, in ticks.
constexpr std::int64_t kWholeEvery = 60;
/// A goal and what a report tells of it are this close.
constexpr double kSameGoal_m = 1;

/// Converts all or nothing.
template <class Wire, class Model>
bool FromWireAll(const std::vector<Wire>& wires, const WireLimits& limits,
                 std::vector<Model>* out) {
  for (const Wire& wire : wires) {
    const std::optional<Model> model = FromWire(wire, limits);
    if (!model) return false;
    out->push_back(*model);
  }
  return true;
}

}  // namespace

AgentProcess::AgentProcess(const Identity& identity, int window, AgentKind kind, IdRange ids,
                           std::size_t most_whole, std::unique_ptr<DriverPort> drivers)
    : Follower(identity, window),
      kind_(kind),
      ids_(ids),
      most_whole_(most_whole),
      drivers_(std::move(drivers)) {}

void AgentProcess::OnMissionMessage(const Message& message, const Packet& packet, const Now& now) {
  Handle(
      message, [&](const answer_t& answer) { Take(answer); },
      [&](const request_t& request) { Answer(request, now); },
      [&](const clock_t& clock) { Take(clock); },
      [&](const world_state_t& world) {
        Take(world);
        if (activities_ && world.tick == tick_) world_packet_ = packet;
      },
      [&](const rulings_t& rulings) {
        Take(rulings);
        if (rulings_ && rulings.tick == tick_) rulings_packet_ = packet;
      },
      [&](const clearances_t& clearances) { Take(clearances, packet); },
      [&](const schedule_t& schedule) { Take(schedule); });
}

void AgentProcess::OnScenario() {
  const auto& specs = scenario()->agents(kind_);
  const auto n = static_cast<std::int32_t>(specs.size());
  const auto [first, last] = ids_.value_or(std::pair(0, n - 1));
  if (first < 0 || last >= n || first > last) {
    throw InputError("command line", "--ids", fmt::format("{}-{}", first, last),
                     fmt::format("ids of the scenario's {}s, 0-{}", ToString(kind_), n - 1));
  }
  for (std::int32_t id = first; id <= last; ++id) {
    agents_.push_back(StartOf(kind_, id, specs[static_cast<std::size_t>(id)], *scenario()->ways));
  }
  if (specs.size() > most_whole_) {
    told_.emplace(scenario(), kind_);
  }
  for (std::int32_t id = first; drivers_ && id <= last; ++id) {
    if (!drivers_->drives(id)) continue;
    if (!specs[static_cast<std::size_t>(id)].measured) {
      throw InputError("command line", "--driver", fmt::format("{}:{}", ToString(kind_), id),
                       "an agent that the scenario has as \"measured\": true");
    }
    driven_.push_back(id);
  }
  restored_ = identity().boot_id == 0;
  if (restored_) {
    set_state(ProcessState::kReady);
    BeginDriving();
  }
}

void AgentProcess::BeginDriving() {
  if (std::exchange(is_driving_, true)) return;  // they hear of all that has become of their agents
  for (const std::int32_t id : driven_) drivers_->Begin(*scenario(), Agent(id), tick_us_);
}

void AgentProcess::Take(const answer_t& answer) {
  if (restored_ || !Answers(answer)) return;
  if (answer.channel == channel::kSchedule) {
    if (const auto schedule = DecodeValid<schedule_t>(answer.data)) TakeGoals(*schedule);
    return;
  }
  if (answer.channel != ChannelOf(kind_)) return;
  if (answer.data.empty()) {  // the mission has not begun
    restored_ = true;
    set_state(ProcessState::kReady);
    BeginDriving();
    return;
  }
  const auto states = DecodeValid<agent_states_t>(answer.data);
  if (!states || states->header.run_id != identity().run_id ||
      static_cast<AgentKind>(states->kind) != kind_) {
    Reject();
    return;
  }
  // Another process of the class answers with its own agents, and may be ahead of ours.
  const auto is_ours = [this](const agent_t& wire) {
    return wire.id >= agents_.front().id && wire.id <= agents_.back().id;
  };
  if (std::none_of(states->agents.begin(), states->agents.end(), is_ours)) return;
  if (states->tick < std::max(tick_, restore_from_)) return;
  if (!orders().complete(states->tick)) {  // a leg may lead to what an order has added
    lacks_orders_of_ = states->tick;
    return;
  }
  if (states->tick > tick_) {
    tick_ = states->tick;
    restored_states_.clear();
    still_unknown_.clear();
    goalless_.clear();
    for (const AgentState& agent : agents_) still_unknown_.insert(agent.id);
  }
  tick_us_ = states->header.sim_us;
  applied_decision_ = states->applied_decision;
  for (const agent_t& wire : states->agents) {
    if (still_unknown_.count(wire.id) == 0) continue;
    const auto agent = FromWire(wire, kind_, tick_us_, WireLimits(*scenario()));
    if (!agent) {
      Reject();
      continue;
    }
    Agent(wire.id) = *agent;
    restored_states_.push_back(wire);
    still_unknown_.erase(wire.id);
    if (agent->action == ActionKind::kGoTo && agent->arrive_us > tick_us_)
      goalless_.insert(wire.id);
  }
  goals_asked_us_ = kNever;
  if (still_unknown_.empty() && goalless_.empty()) GoOn();
}

void AgentProcess::TakeGoals(const schedule_t& schedule) {
  if (goalless_.empty()) return;
  for (const action_t& wire : schedule.actions) {
    const auto action = FromWire(wire, WireLimits(*scenario()));
    if (!action || action->kind != ActionKind::kGoTo) continue;
    const auto id = goalless_.find(MemberOf(*action, kind_));
    if (id == goalless_.end()) continue;
    AgentState& agent = Agent(*id);
    if (agent.decision != schedule.decision || Distance(agent.to, action->to) > kSameGoal_m) {
      continue;
    }
    agent.to = action->to;
    goalless_.erase(id);
  }
  if (still_unknown_.empty() && goalless_.empty()) GoOn();
}

void AgentProcess::GoOn() {
  restored_ = true;
  says_whole_ = true;
  for (const std::int32_t id : driven_) {
    AgentState& agent = Agent(id);
    // It has said so, and may not have been ruled to have.
    if (!agent.failed || agent.action == ActionKind::kNone) continue;
    agent.failed = false;
    failures_.emplace(id, "its driver had failed before its process started again");
  }
  BeginDriving();
  set_state(ProcessState::kRunning);
  clock_.reset();
  activities_.reset();
  rulings_.reset();
  schedule_.reset();
}

void AgentProcess::Answer(const request_t& request, const Now& now) {
  if (!restored_) return;
  const auto answer = [&](std::int64_t tick, const Packet& packet) {
    if (repeats_others()) Process::Answer(request, tick, packet.bytes, tick_us_, now);
  };
  if (request.channel == ChannelOf(kind_)) {
    if (tick_ < 0) answer(-1, {});
    Answer(request, published_, now);
    // Said again, its changes would tell nothing to who asks.
    if (published_before_.states) Answer(request, published_before_, now);
    says_whole_ = true;
  }
  if (request.channel == channel::kClearances) {
    for (const auto& [decision, packet] : clearances_packets_) answer(decision, packet);
  }
  // The newest verdict, too: it may have been given without a process that is lost.
  if (request.channel == channel::kWorld) {
    if (activities_) answer(tick_, world_packet_);
    answer(consumed_.tick, consumed_.world);
  }
  if (request.channel == channel::kRulings) {
    if (rulings_) answer(tick_, rulings_packet_);
    answer(consumed_.tick, consumed_.rulings);
  }
}

void AgentProcess::Answer(const request_t& request, const Published& published, const Now& now) {
  if (!published.states) {
    for (const SentPacket& packet : published.packets) {
      Process::Answer(request, published.tick, packet->bytes, tick_us_, now);
    }
    return;
  }
  for (const agent_states_t& part : PartsOf(*published.states)) {
    Process::Answer(request, published.tick, Encode(part), tick_us_, now);
  }
}

void AgentProcess::Take(const clock_t& clock) {
  if (!Possible(clock, *scenario())) return Reject();
  if (clock.phase == ClockPhase::kEnded && drivers_) drivers_->Bye("the mission is over");
  if (clock.tick < restore_from_) TrustOwnStates();
  if (!restored_) return;
  Follow(clock);
  if (clock.phase != ClockPhase::kEnded && (clock.tick == tick_ || clock.tick == tick_ - 1)) {
    repeat_tick_ = clock.tick;
  }
  if (clock.tick == tick_ + 1) clock_ = clock;
}

void AgentProcess::Take(const world_state_t& world) {
  if (!Possible(world, scenario()->rules)) return Reject();
  if (world.tick < restore_from_) TrustOwnStates();
  if (world.tick > tick_ && restored_) {
    // The world has judged a tick that this process does not know: its agents' states of that tick
    // came from an earlier start of it. Go on from them.
    restored_ = false;
    awaits_drivers_ = false;
    restore_from_ = world.tick;
    for (const AgentState& agent : agents_) still_unknown_.insert(agent.id);
    return;
  }
  if (world.tick != tick_) return;
  if (activities_) {
    const bool outdated = world.header.boot_id < verdict_boot_;
    if (outdated && ++outdated_verdicts_ == kMostOutdated) {
      verdict_boot_ = world.header.boot_id;
      outdated_verdicts_ = 0;
    }
    return;
  }
  std::vector<Activity> activities;
  if (FromWireAll(world.activities, WireLimits(*scenario()), &activities)) {
    activities_ = std::move(activities);
    verdict_boot_ = world.header.boot_id;
    outdated_verdicts_ = 0;
  } else {
    Reject();
  }
}

void AgentProcess::TrustOwnStates() {
  if (restored_ || still_unknown_.size() < agents_.size()) return;
  restored_ = true;
  restore_from_ = 0;
  still_unknown_.clear();
}

void AgentProcess::Take(const rulings_t& rulings) {
  if (!Possible(rulings, scenario()->rules)) return Reject();
  if (rulings.tick != tick_ || rulings_) return;
  std::vector<Ruling> list;
  if (FromWireAll(rulings.rulings, WireLimits(*scenario()), &list)) {
    rulings_ = std::move(list);
  } else {
    Reject();
  }
}

void AgentProcess::Take(const schedule_t& schedule) {
  if (!Possible(schedule, *scenario())) return Reject();
  if (!restored_) return TakeGoals(schedule);
  if (orders().complete(schedule.tick) &&
      scenario()->rules.DecisionAt(schedule.tick) != schedule.decision) {
    return Reject();
  }
  // One that a damaged clock did not ask for is wanted by the next clock.
  const bool is_wanted =
      schedule.tick == tick_ || (clock_ && schedule.decision == clock_->required_decision);
  if (!is_wanted || schedule.decision <= applied_decision_ || schedule_) return;
  std::vector<Action> actions;
  if (FromWireAll(schedule.actions, WireLimits(*scenario()), &actions)) {
    schedule_ = std::move(actions);
    schedule_decision_ = schedule.decision;
  } else {
    Reject();
  }
}

bool AgentProcess::NeedsClearances() const {
  return kind_ == AgentKind::kUav && scenario()->separation() != nullptr;
}

void AgentProcess::Take(const clearances_t& clearances, const Packet& packet) {
  if (!NeedsClearances()) return;
  if (!Possible(clearances, *scenario())) return Reject();
  const bool is_wanted =
      clearances.tick == tick_ || (clock_ && clearances.decision == clock_->required_decision);
  if (!is_wanted || clearances.decision == clearances_decision_) return;
  const auto list = FromWire(clearances, WireLimits(*scenario()));
  if (!list) return Reject();
  clearances_.clear();
  for (const Clearance& clearance : *list) clearances_[clearance.uav] = clearance;
  clearances_decision_ = clearances.decision;
  clearances_packets_[clearances.decision] = packet;
  if (clearances_packets_.size() > 2) clearances_packets_.erase(clearances_packets_.begin());
}

bool AgentProcess::CanAdvance() const {
  if (!clock_ || clock_->tick != tick_ + 1) return false;
  if (tick_ < 0) return true;
  if (!activities_ || !rulings_) return false;
  const std::int32_t required = clock_->required_decision;
  return required <= applied_decision_ ||
         (schedule_ && schedule_decision_ == required &&
          (!NeedsClearances() || clearances_decision_ == required));
}

void AgentProcess::OnMissionStep(const Now& now) {
  if (!restored_ && still_unknown_.empty() && !goalless_.empty()) {
    if (goals_asked_us_ == kNever) goals_asked_us_ = now.monotonic_us;
    if (now.monotonic_us - goals_asked_us_ < kGoalPatienceUs) {
      return Ask(channel::kSchedule, tick_us_, now);
    }
    goalless_.clear();
    GoOn();
  }
  if (!restored_) {
    const bool lacks_orders = !orders().complete(lacks_orders_of_);
    return Ask(lacks_orders ? channel::kOrders : ChannelOf(kind_), tick_us_, now);
  }
  if (!restored_states_.empty()) {
    // As they were: what these agents know beyond the wire only comes with the next verdict.
    Publish(std::exchange(restored_states_, {}), true, now);
  }
  if (awaits_drivers_ || (listen_us_ != kNever && now.monotonic_us >= listen_us_)) {
    HearDrivers(now);
  }
  if (awaits_drivers_) {
    // What is asked again is said again; the present tick is not there yet.
    if (repeat_tick_ >= 0 && repeat_tick_ == published_.tick && !sender().holds_back()) {
      Resend(published_);
    }
    repeat_tick_ = -1;
    return;
  }
  if (CanAdvance()) {
    if (tick_ >= 0 && !HasOrders(tick_, verdict_boot_, now)) return;
    if (!HasOrders(clock_->tick, clock_->header.boot_id, now)) return;
    AskNoMore(now);
    Advance(now);
    repeat_tick_ = -1;
    return;
  }
  AskNoMore(now);
  if (repeat_tick_ >= 0 && !sender().holds_back()) {
    Resend(repeat_tick_ == published_.tick ? published_ : published_before_);
  }
  repeat_tick_ = -1;
}

void AgentProcess::Advance(const Now& now) {
  if (tick_ >= 0) {
    consumed_ = {tick_, std::move(world_packet_), std::move(rulings_packet_)};
    const Verdict verdict(std::move(*activities_), std::move(*rulings_));
    for (AgentState& agent : agents_) Settle(&agent, verdict, tick_us_, scenario()->tasks);
    for (const TakenOrder& order : orders().TakenAt(tick_)) {
      for (AgentState& agent : agents_) Obey(&agent, order, tick_us_, *scenario());
    }
    if (clock_->required_decision > applied_decision_) {
      Apply(*schedule_, schedule_decision_, tick_us_);
      applied_decision_ = schedule_decision_;
    }
    // The decision that was due is not in force: no scheduler is left.
    const std::int32_t due = scenario()->rules.DecisionAt(tick_);
    if (due > clock_->required_decision) ActAlone(due);
  }
  const TimeUs before = tick_us_;
  tick_ = clock_->tick;
  tick_us_ = clock_->tick_us;
  clock_.reset();
  activities_.reset();
  rulings_.reset();
  schedule_.reset();
  set_sim_us(tick_us_);
  if (driven_.empty()) return ReportTick(now);
  TellDrivers(before);
  awaits_drivers_ = true;
  HearDrivers(now);
}

void AgentProcess::TellDrivers(TimeUs before) {
  for (const std::int32_t id : driven_) {
    if (!failures_.contains(id)) drivers_->Tell(Agent(id), before, tick_us_);
  }
}

void AgentProcess::HearDrivers(const Now& now) {
  const bool is_complete = drivers_->Listen();
  if (awaits_drivers_ && is_complete) {
    awaits_drivers_ = false;
    ApplyReports();
    ReportTick(now);
  }
  const TimeUs patience_us = drivers_->patience_us();
  listen_us_ = awaits_drivers_         ? now.monotonic_us
               : patience_us == kNever ? kNever
                                       : now.monotonic_us + patience_us;
}

void AgentProcess::ApplyReports() {
  for (const MeasuredReport& report : drivers_->TakeReports(tick_us_)) {
    AgentState& agent = Agent(report.agent);
    // Said before it knew of what it does now.
    if (report.kind == MeasuredReport::Kind::kPlace && IsOld(agent, report)) continue;
    const std::string problem = report.kind == MeasuredReport::Kind::kFailed
                                    ? report.reason
                                    : ApplyReport(&agent, report, tick_us_, scenario()->tasks);
    if (!problem.empty() && !agent.failed)
      failures_.emplace(report.agent, "its driver: " + problem);
    if (report.kind == MeasuredReport::Kind::kNotReady && agent.not_ready()) {
      unsaid_waits_[report.agent] = report.reason;
    }
  }
  for (const std::int32_t id : driven_) {
    ExpectOnward(&Agent(id), tick_us_, scenario()->rules.TickAfter(tick_us_));
  }
}

void AgentProcess::ReportTick(const Now& now) {
  for (AgentState& agent : agents_) {
    FollowWays(&agent, orders().TakenAt(tick_), tick_us_, *scenario());
  }
  std::vector<agent_t> wires;
  wires.reserve(agents_.size());
  for (AgentState& agent : agents_) {
    if (agent.measured && !std::binary_search(driven_.begin(), driven_.end(), agent.id)) {
      SayAsComputed(&agent, tick_us_);
    }
    wires.push_back(ToWire(agent, tick_us_, scenario()->tasks));
    if (failures_.contains(agent.id)) wires.back().status = NumberOf(AgentStatus::kFailed);
  }
  Publish(std::move(wires), SpeaksWhole(), now);
  says_whole_ = false;
}

void AgentProcess::SayOfDriver(EventKind kind, std::int32_t id, const std::string& words,
                               const Now& now) {
  event_t event{};
  event.kind = NumberOf(kind);
  event.at_us = tick_us_;
  event.uav_id = kind_ == AgentKind::kUav ? id : -1;
  event.worker_id = kind_ == AgentKind::kWorker ? id : -1;
  event.vehicle_id = kind_ == AgentKind::kVehicle ? id : -1;
  event.task_id = event.charge_id = -1;
  event.detail = words;
  published_.words.push_back(sender().Send(channel::kDriver, std::move(event), tick_us_, now));
}

void AgentProcess::SayOfDrivers(const Now& now) {
  for (const auto& [id, reason] : failures_) {
    if (!Agent(id).failed) SayOfDriver(EventKind::kDriverFailed, id, reason, now);
  }
  for (const auto& [id, reason] : std::exchange(unsaid_waits_, {})) {
    SayOfDriver(EventKind::kDriverWaits, id, reason, now);
  }
  if (!drivers_) return;
  for (const DriverMessage& message : drivers_->TakeMessages()) {
    SayOfDriver(message.calls_help ? EventKind::kDriverCalls : EventKind::kDriverSays,
                message.agent, message.text, now);
  }
}

void AgentProcess::Resend(const Published& published) {
  for (const SentPacket& packet : published.words) sender().Resend(packet);
  for (const SentPacket& packet : published.packets) sender().Resend(packet);
}

bool AgentProcess::SpeaksWhole() const {
  const Rules& rules = scenario()->rules;
  return !told_ || says_whole_ || published_.tick != tick_ - 1 || tick_ % kWholeEvery == 0 ||
         tick_ == rules.last_tick() || rules.DecisionAt(tick_) >= 0;
}

void AgentProcess::Apply(const std::vector<Action>& actions, std::int32_t decision, TimeUs t) {
  for (const Action& action : actions) {
    const std::int32_t id = MemberOf(action, kind_);
    if (id < agents_.front().id || id > agents_.back().id) continue;
    AgentState& agent = Agent(id);
    if (!agent.idle(t)) continue;  // a command for a busy agent is refused: its partner is released
    if (IsPair(action.kind) &&
        MatchFails(action, decision, scenario()->disturbances, scenario()->seed)) {
      continue;
    }
    Begin(&agent, action, decision, t, scenario()->disturbances, scenario()->seed, HoldOf(id, t));
  }
  for (const std::int32_t id : driven_) {
    const auto clearance = clearances_.find(id);
    if (!NeedsClearances() || clearance == clearances_.end()) continue;
    if (clearance->second.decision == decision) drivers_->GiveAltitude(clearance->second);
  }
}

void AgentProcess::ActAlone(std::int32_t decision) {
  for (AgentState& agent : agents_) {
    const auto action = OwnAction(agent, tick_us_, *scenario());
    if (!action) continue;
    Begin(&agent, *action, decision, tick_us_, scenario()->disturbances, scenario()->seed);
  }
}

TimeUs AgentProcess::HoldOf(std::int32_t id, TimeUs t) const {
  const auto clearance = clearances_.find(id);
  if (!NeedsClearances() || clearance == clearances_.end()) return 0;
  return std::max<TimeUs>(0, clearance->second.begin_us - t);
}

void AgentProcess::Publish(std::vector<agent_t> wires, bool whole, const Now& now) {
  published_before_ = std::move(published_);
  published_ = {tick_, {}, {}, {}};
  SayOfDrivers(now);
  std::vector<SentPacket>& packets = published_.packets;
  if (whole) {
    for (agent_states_t& states : StatesMessages(kind_, tick_, applied_decision_, wires)) {
      if (told_) told_->Take(states);
      packets.push_back(sender().Send(ChannelOf(kind_), std::move(states), tick_us_, now));
    }
    return;
  }
  for (agent_changes_t& changes : told_->ChangesSince(tick_, applied_decision_, wires)) {
    packets.push_back(sender().Send(ChangesChannelOf(kind_), std::move(changes), tick_us_, now));
  }
  agent_states_t& states = published_.states.emplace();
  states.header = *DecodeHeader(*packets.front());
  states.kind = NumberOf(kind_);
  states.tick = tick_;
  states.applied_decision = applied_decision_;
  states.agents = std::move(wires);
  states.n = static_cast<std::int32_t>(states.agents.size());
}

}  // namespace muster::agents
