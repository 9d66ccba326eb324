#include "world/restoring.h"

#include <algorithm>
#include <muster/clock_t.hpp>
#include <set>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::world {
namespace {

/// If a verdict may have been given without some process: every living process answers twice in
/// this time.
constexpr TimeUs kHearAllUs = 600'000;
/// How long to wait for a report that must have been made, but that perhaps no process has any
/// more.
constexpr TimeUs kGiveUpUs = 10 * kSecondUs;

bool IsLoss(const std::optional<Ruling>& failure) {
  return failure && failure->kind == Ruling::Kind::kLost;
}

}  // namespace

Restoring::Restoring(const Scenario& scenario, std::int64_t run_id)
    : scenario_(scenario), limits_(scenario), run_id_(run_id) {
  for (const AgentKind kind : kAgentKinds) {
    told_[kind].resize(scenario.agents(kind).size());
  }
}

bool Restoring::Take(const answer_t& answer) {
  for (const AgentKind kind : kAgentKinds) {
    if (answer.channel != ChannelOf(kind)) continue;
    if (answer.data.empty()) {
      not_begun_ = true;
      return true;
    }
    const auto states = DecodeValid<agent_states_t>(answer.data);
    if (!states || states->header.run_id != run_id_ ||
        static_cast<AgentKind>(states->kind) != kind || !IsTick(states->tick)) {
      return false;
    }
    // An earlier start's word on lost agents, meant for their process.
    if (states->header.sender == process_name::kWorld) return true;
    std::vector<AgentState> agents;
    for (const agent_t& wire : states->agents) {
      const auto agent = FromWire(wire, kind, scenario_.rules.TimeOf(states->tick), limits_);
      if (!agent) return false;
      agents.push_back(*agent);
    }
    applied_[states->tick] = states->applied_decision;
    const header_t& header = states->header;
    reports_[states->tick].try_emplace({header.sender, header.boot_id, header.seq},
                                       Packet{answer.channel, answer.data});
    for (const AgentState& agent : agents) {
      Told& told = told_[kind][static_cast<std::size_t>(agent.id)];
      if (states->tick > told.newest()) told.owner = header.sender;
      told.states.try_emplace(states->tick, agent);
    }
  }
  if (answer.data.empty()) return true;
  if (answer.channel == channel::kOrders) {
    auto book = DecodeValid<order_book_t>(answer.data);
    if (!book || book->header.run_id != run_id_ || (book->tick >= 0 && !IsTick(book->tick))) {
      return false;
    }
    if (!book_ || book->tick > book_->tick) book_ = std::move(book);
  }
  if (answer.channel == channel::kWorld) {
    auto world = DecodeValid<world_state_t>(answer.data);
    if (!world || world->header.run_id != run_id_ || !IsTick(world->tick)) return false;
    worlds_.emplace(world->tick, std::move(*world));
  }
  if (answer.channel == channel::kClock) {
    const auto clock = DecodeValid<clock_t>(answer.data);
    if (!clock || clock->header.run_id != run_id_ || !Possible(*clock, scenario_)) {
      return false;
    }
    applied_.emplace(clock->tick, clock->required_decision);
    clock_ = std::max(clock_, clock->tick);
  }
  if (answer.channel == channel::kRulings) {
    auto rulings = DecodeValid<rulings_t>(answer.data);
    if (!rulings || rulings->header.run_id != run_id_ || !IsTick(rulings->tick)) return false;
    rulings_.emplace(rulings->tick, std::move(*rulings));
  }
  return true;
}

Verdict Restoring::VerdictOn(std::int64_t tick) const {
  std::vector<Activity> activities;
  std::vector<Ruling> rulings;
  for (const activity_t& wire : worlds_.at(tick).activities) {
    if (const auto activity = FromWire(wire, limits_)) activities.push_back(*activity);
  }
  for (const ruling_t& wire : rulings_.at(tick).rulings) {
    if (const auto ruling = FromWire(wire, limits_)) rulings.push_back(*ruling);
  }
  return Verdict(std::move(activities), std::move(rulings));
}

Restoring::Verdicts Restoring::AllVerdicts() const {
  Verdicts verdicts;
  for (const auto& [tick, world] : worlds_) {
    if (rulings_.contains(tick)) verdicts.emplace(tick, VerdictOn(tick));
  }
  return verdicts;
}

std::optional<Restoring::State> Restoring::At(std::int64_t tick) const {
  State state;
  state.tick = tick;
  if (const auto reports = reports_.find(tick); reports != reports_.end()) {
    for (const auto& [message, packet] : reports->second) state.reports.push_back(packet);
  }
  if (tick == 0) return state;
  const auto world = worlds_.find(tick - 1);
  if (world == worlds_.end() || !rulings_.contains(tick - 1) ||
      world->second.task_status.size() != scenario_.tasks.size()) {
    return {};
  }
  const auto applied = applied_.find(tick);
  state.applied_decision = applied == applied_.end() ? applied_.rbegin()->second : applied->second;
  if (const auto next = applied_.find(tick + 1); next != applied_.end()) {
    state.next_decision = next->second;
  }
  for (const std::int8_t status : world->second.task_status) {
    state.task_status.push_back(static_cast<TaskStatus>(status));
  }
  state.verdict = VerdictOn(tick - 1);
  return state;
}

std::optional<Restoring::State> Restoring::Newest() const {
  if (not_begun_) return State{};
  std::int64_t tick = scenario_.rules.last_tick();
  for (const AgentKind kind : kAgentKinds) {
    for (const Told& agent : told_[kind]) tick = std::min(tick, agent.newest());
  }
  return tick < 0 ? std::nullopt : At(tick);
}

std::optional<Restoring::State> Restoring::NewestWithoutLost(Gap gap) const {
  const Verdicts verdicts = AllVerdicts();
  if (not_begun_ || verdicts.empty()) return Newest();
  // One half of a verdict or the clock after it tells of it, too.
  const std::int64_t verdict =
      std::max({worlds_.rbegin()->first, rulings_.rbegin()->first, clock_ - 1});
  std::int64_t newest = -1;
  for (const AgentKind kind : kAgentKinds) {
    for (const Told& agent : told_[kind]) {
      if (agent.newest() < 0) return {};
      newest = std::max(newest, agent.newest());
    }
  }
  const std::int64_t awaited_from = std::max(newest - 1, verdict);
  std::int64_t tick = newest >= awaited_from ? newest : verdict + 1;
  for (const AgentKind kind : kAgentKinds) {
    for (const Told& agent : told_[kind]) {
      if (agent.newest() >= awaited_from) tick = std::min(tick, agent.newest());
    }
  }
  tick = std::min(tick, scenario_.rules.last_tick());
  std::optional<State> state = At(tick);
  if (!state) return {};
  std::set<std::string> lost_owners, present_owners;
  for (const AgentKind kind : kAgentKinds) {
    for (const Told& agent : told_[kind]) {
      // One that has told the next tick has told this one, too, and perhaps cannot tell it again.
      state->is_certain &= agent.newest() <= tick || agent.states.contains(tick);
      const AgentState& any = agent.states.begin()->second;
      const std::optional<Ruling> before = FailureOf(any, verdicts, tick - 1);
      std::optional<Ruling> failure = before;
      if (agent.newest() >= awaited_from) {
        // A verdict on this very tick may have been given without it.
        failure = FailureOf(any, verdicts, tick);
        if (!IsLoss(failure)) {
          if (IsLoss(before)) state->lost.push_back({any, before->at_us, true});
          present_owners.insert(agent.owner);
          continue;
        }
      }
      std::optional<Lost> lost = LostAgent(agent, failure, tick, verdicts, Gap::kWait);
      if (!lost && gap == Gap::kAccept) {
        lost = LostAgent(agent, failure, tick, verdicts, gap);
        state->given_up.insert(agent.owner);
      }
      if (!lost) return {};
      state->is_certain &= failure.has_value();
      state->lost.push_back(*lost);
      lost_owners.insert(agent.owner);
    }
  }
  // What they say of this tick came too late. A process of which one agent is silent is not lost.
  std::erase_if(state->reports, [&](const Packet& packet) {
    const std::string sender = DecodeHeader(packet)->sender;
    return lost_owners.contains(sender) && !present_owners.contains(sender);
  });
  return state;
}

std::optional<Ruling> Restoring::FailureOf(const AgentState& agent, const Verdicts& verdicts,
                                           std::int64_t tick) {
  const auto verdict = verdicts.find(tick);
  if (verdict == verdicts.end()) return {};
  for (const Ruling& ruling : verdict->second.rulings_of(agent.kind, agent.id)) {
    if (ruling.fails()) return ruling;
  }
  return {};
}

std::optional<Restoring::Lost> Restoring::LostAgent(const Told& told,
                                                    const std::optional<Ruling>& failure,
                                                    std::int64_t tick, const Verdicts& verdicts,
                                                    Gap gap) const {
  const TimeUs failed_us = failure ? failure->at_us : kNever;
  // Its last report before the failure, or one that tells of it. A process that is cut off says
  // more than the world has heard.
  const Rules& rules = scenario_.rules;
  const auto tells = [&](const auto& report) {
    return report.second.failed && rules.TimeOf(report.first) >= failed_us;
  };
  auto report = std::prev(told.states.end());
  while (report != told.states.begin() && !tells(*report) &&
         rules.TimeOf(report->first) >= failed_us) {
    --report;
  }
  auto [t, agent] = *report;
  if (!tells(*report) && gap == Gap::kWait) {
    const bool is_last =
        rules.TimeOf(t) < failed_us && (failed_us == kNever || failed_us <= rules.TimeOf(t + 1));
    if (!is_last) return {};
    // What it did until it was lost is in the verdict on this report and the next one.
    for (const std::int64_t needed : {t, t + 1}) {
      if (needed < tick && !verdicts.contains(needed)) return {};
    }
  }
  for (auto next = verdicts.lower_bound(t); next != verdicts.end() && next->first < tick; ++next) {
    Settle(&agent, next->second, rules.TimeOf(next->first), scenario_.tasks);
  }
  if (!failure) return Lost{agent, rules.TimeOf(tick - 1) + 1};
  // An agent that had failed for another reason before does not return with its process.
  return Lost{agent, IsLoss(failure) ? failed_us : std::max(rules.TimeOf(t), failed_us) + 1};
}

TimeUs GiveUpUs(TimeUs lost_after_us) { return std::max(kGiveUpUs, lost_after_us); }

TimeUs ListenUs(const Restoring::State& state, bool goes_on, TimeUs lost_after_us) {
  if (!state.is_certain) return GiveUpUs(lost_after_us);
  if (!state.lost.empty()) return std::max(kHearAllUs, lost_after_us);
  return goes_on ? kHearAllUs : 0;
}

}  // namespace muster::world
