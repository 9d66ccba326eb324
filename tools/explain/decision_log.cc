#include "tools/explain/decision_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <type_traits>
#include <utility>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "protocol/mission_reader.h"
#include "protocol/process.h"
#include "scheduler/fusion.h"

namespace muster::tools {
namespace {

auto KeyOf(const event_t& e) {
  return std::tie(e.at_us, e.kind, e.uav_id, e.worker_id, e.vehicle_id, e.task_id, e.charge_id,
                  e.fault_id, e.detail);
}

/// Of an agent_states_t, a clock_t, ...; -1: of a message that is of no tick.
std::int64_t TickOf(const Message& message) {
  return std::visit(
      []<class T>(const T& m) -> std::int64_t {
        if constexpr (requires { m.tick; } && !std::is_same_v<T, orders_t>) {
          return m.tick;
        } else {
          return -1;
        }
      },
      message);
}

}  // namespace

DecisionLog ReadDecisionLog(MessageSource* source) {
  DecisionLog log;
  MissionReader reader;
  const auto decision_at = [&](std::int64_t tick) -> LoggedDecision* {
    const Rules& rules = reader.scenario()->rules;
    const std::int32_t d = tick < 0 || tick > rules.last_tick() ? -1 : rules.DecisionAt(tick);
    if (d < 0) return nullptr;
    LoggedDecision& decision = log.decisions[d];
    decision.decision = d;
    decision.at_us = rules.TimeOf(tick);
    return &decision;
  };
  const auto told = [&](std::int64_t tick, const Packet& packet) {
    if (LoggedDecision* decision = decision_at(tick)) decision->told.push_back(packet);
  };
  source->Rewind();
  const auto take = [&](const Message& message, const Packet& packet) {
    Handle(
        message,
        [&](const scenario_t&) {
          if (!log.scenario_packets.empty()) return;
          log.scenario = *reader.scenario();
          log.scenario_packets = {packet};
        },
        [&](const roads_t&) {
          if (log.scenario_packets.size() == 1) log.scenario_packets.push_back(packet);
        },
        [&](const clock_t& clock) {
          LoggedDecision* decision =
              clock.phase == ClockPhase::kRunning ? decision_at(clock.tick) : nullptr;
          if (decision != nullptr && clock.decision == decision->decision) {
            decision->clock = packet;
          }
          LoggedDecision* before =
              clock.phase == ClockPhase::kRunning ? decision_at(clock.tick - 1) : nullptr;
          if (before != nullptr) before->in_force = clock.required_decision >= before->decision;
        },
        [&](const agent_states_t& states) { told(states.tick, packet); },
        [&](const rulings_t& rulings) { told(rulings.tick, packet); },
        [&](const world_state_t& world) {
          told(world.tick, packet);
          if (!log.last_world || world.tick > log.last_world->tick) log.last_world = world;
        },
        [&](const schedule_t& schedule) {
          LoggedDecision* decision = decision_at(schedule.tick);
          if (decision != nullptr) decision->schedules.push_back(schedule);
        },
        [&](const clearances_t& clearances) {
          LoggedDecision* decision = decision_at(clearances.tick);
          if (decision != nullptr) decision->clearances = packet;
        },
        [&](const event_t& event) { log.events.push_back(event); });
  };
  // By tick: what came before the tick's orders, which say whether it has a decision.
  std::multimap<std::int64_t, std::pair<Message, Packet>> waiting;
  const auto take_waiting = [&] {
    take(waiting.begin()->second.first, waiting.begin()->second.second);
    waiting.erase(waiting.begin());
  };
  const auto visit = [&](const Message& message, const Packet& packet) {
    if (const std::int64_t tick = TickOf(message); !reader.orders().complete(tick)) {
      waiting.emplace(tick, std::pair(message, packet));
      return;
    }
    take(message, packet);
    while (!waiting.empty() && reader.orders().complete(waiting.begin()->first)) take_waiting();
  };
  while (const auto event = source->NextEvent()) reader.Add(event->packet, visit);
  if (!reader.scenario()) throw InputError(source->name() + ": the log has no scenario");
  while (!waiting.empty()) take_waiting();  // of a log that lacks orders
  log.run_id = *reader.run_id();
  log.orders = std::make_shared<const OrderBook>(reader.TakeOrders());
  log.scenario = *log.orders->scenario();
  std::stable_sort(log.events.begin(), log.events.end(),
                   [](const event_t& a, const event_t& b) { return KeyOf(a) < KeyOf(b); });
  log.events.erase(
      std::unique(log.events.begin(), log.events.end(),
                  [](const event_t& a, const event_t& b) { return KeyOf(a) == KeyOf(b); }),
      log.events.end());
  return log;
}

const Packet* ClearancesBefore(const LoggedDecision& decision, const DecisionLog& log) {
  if (!decision.clock || log.scenario.separation() == nullptr) return nullptr;
  const auto clock = DecodeValid<clock_t>(decision.clock->bytes);
  const auto before = clock ? log.decisions.find(clock->required_decision) : log.decisions.end();
  if (before == log.decisions.end() || !before->second.clearances) return nullptr;
  return &*before->second.clearances;
}

std::string WhatIsMissing(const LoggedDecision& decision, const DecisionLog& log) {
  const Scenario& scenario = log.scenario;
  PerKind<std::vector<bool>> heard;
  for (const AgentKind kind : kAgentKinds) {
    heard[kind].resize(scenario.agents(kind).size());
  }
  bool world = false, rulings = false;
  for (const Packet& packet : decision.told) {
    world = world || packet.channel == channel::kWorld;
    if (packet.channel == channel::kRulings) {
      rulings = true;
      // An agent that is ruled to have failed may be silent.
      const auto list = DecodeValid<rulings_t>(packet.bytes);
      for (const ruling_t& r : list->rulings) {
        if (r.kind == RulingKind::kReleased) continue;
        auto& of_kind = heard[static_cast<AgentKind>(r.agent_kind)];
        const auto id = static_cast<std::size_t>(r.agent_id);
        if (id < of_kind.size()) of_kind[id] = true;
      }
    }
    const auto states = DecodeValid<agent_states_t>(packet.bytes);
    if (!states) continue;
    auto& of_kind = heard[static_cast<AgentKind>(states->kind)];
    for (const agent_t& agent : states->agents) {
      const auto id = static_cast<std::size_t>(agent.id);
      if (id < of_kind.size()) of_kind[id] = true;
    }
  }
  std::vector<std::string> lacks;
  if (!decision.clock) lacks.push_back("clock_t");
  if (!world) lacks.push_back("world_state_t");
  if (!rulings) lacks.push_back("rulings_t");
  if (!log.orders->complete(scenario.rules.TickOf(decision.at_us))) lacks.push_back("orders_t");
  const auto clock = decision.clock ? DecodeValid<clock_t>(decision.clock->bytes) : std::nullopt;
  if (clock && clock->required_decision >= 0 && scenario.separation() != nullptr &&
      ClearancesBefore(decision, log) == nullptr) {
    lacks.push_back(fmt::format("clearances_t of decision {}", clock->required_decision));
  }
  for (const AgentKind kind : kAgentKinds) {
    const auto& of_kind = heard[kind];
    const auto n = std::count(of_kind.begin(), of_kind.end(), false);
    if (n == 0) continue;
    lacks.push_back(
        fmt::format("the state of {}:{}", ToString(kind),
                    std::find(of_kind.begin(), of_kind.end(), false) - of_kind.begin()));
    if (n > 1) lacks.back() += fmt::format(" and {} more", n - 1);
  }
  return fmt::format("{}", fmt::join(lacks, ", "));
}

std::optional<scheduler::Situation> SituationOf(const LoggedDecision& decision,
                                                const DecisionLog& log) {
  const std::int64_t tick = log.scenario.rules.TickOf(decision.at_us);
  // As it was then: later orders are not known at that tick.
  std::optional<OrderBook> then;
  if (log.orders->takes_orders() && log.orders->complete(tick)) then = log.orders->UpTo(tick);
  const OrderBook& orders = then ? *then : *log.orders;
  scheduler::Fusion fusion(orders.scenario());
  fusion.Start(tick, decision.at_us, decision.decision);
  for (const Packet& packet : decision.told) {
    if (fusion.complete()) break;  // as the scheduler, which then decides
    if (packet.channel == channel::kWorld) {
      static_cast<void>(fusion.Take(*DecodeValid<world_state_t>(packet.bytes)));
    } else if (packet.channel == channel::kRulings) {
      static_cast<void>(fusion.Take(*DecodeValid<rulings_t>(packet.bytes)));
    } else {
      static_cast<void>(fusion.Take(*DecodeValid<agent_states_t>(packet.bytes)));
    }
  }
  if (!fusion.complete() || !log.orders->complete(tick)) return {};
  scheduler::Situation situation = fusion.Fuse(orders);
  if (const Packet* before = ClearancesBefore(decision, log)) {
    const auto clearances = DecodeValid<clearances_t>(before->bytes);
    auto known = clearances ? FromWire(*clearances, WireLimits(log.scenario)) : std::nullopt;
    if (known) situation.clearances = std::move(*known);
  }
  return situation;
}

std::vector<Action> CommandsOf(const LoggedDecision& decision, const Scenario& scenario) {
  std::vector<Action> actions;
  if (decision.schedules.empty() || !decision.in_force) return actions;
  const WireLimits limits(scenario);
  for (const action_t& wire : decision.schedules.front().actions) {
    if (const auto action = FromWire(wire, limits)) actions.push_back(*action);
  }
  return actions;
}

PolicyOfLog LoggedPolicy(const DecisionLog& log) {
  for (const auto& [d, logged] : log.decisions) {
    if (logged.schedules.empty()) continue;
    const std::string& name = logged.schedules.front().policy;
    const auto& known = scheduler::Policies();
    const bool ours = std::any_of(known.begin(), known.end(), [&](const auto& policy) {
      return policy.name == scheduler::BaseName(name);
    });
    return {name, ours ? scheduler::MakePolicy(name) : nullptr};
  }
  return {};
}

}  // namespace muster::tools
