#include "protocol/agent_changes.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#include "base/check.h"
#include "lcmtypes/channels.h"
#include "model/feasibility.h"
#include "muster/fields.h"

namespace muster {
namespace {

constexpr std::size_t kListedPerMessage = 256;

struct BitComparison {
  bool same = true;
  void operator()(const char*, double a, double b) {
    same = same && std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  }
  template <class Integer>
  void operator()(const char*, Integer a, Integer b) {
    same = same && a == b;
  }
};

/// Bit for bit.
bool Same(const agent_t& a, const agent_t& b) {
  BitComparison comparison;
  VisitFields(comparison, a, b);
  return comparison.same;
}

/// A report tells the goal of a free move only up to rounding, so an agent on a free move is always
/// listed. Otherwise outcomes would depend on how many agents a process has.
bool IsOnFreeMove(const agent_t& wire, TimeUs t) {
  return wire.action == ActionKind::kGoTo && t < wire.arrive_us;
}

}  // namespace

std::string_view ChangesChannelOf(AgentKind kind) {
  return ByKind(kind, channel::kUavChanges, channel::kWorkerChanges, channel::kVehicleChanges);
}

ToldAgents::ToldAgents(std::shared_ptr<const Scenario> scenario, AgentKind kind)
    : scenario_(std::move(scenario)), kind_(kind), told_(scenario_->agents(kind).size()) {}

bool ToldAgents::Possible(const agent_changes_t& changes) const {
  return ReadListed(changes).has_value();
}

std::optional<std::vector<AgentState>> ToldAgents::ReadListed(
    const agent_changes_t& changes) const {
  const Rules& rules = scenario_->rules;
  if (static_cast<AgentKind>(changes.kind) != kind_ || changes.tick > rules.last_tick() ||
      rules.DecisionAt(changes.tick) >= 0 || changes.header.sim_us != rules.TimeOf(changes.tick) ||
      static_cast<std::size_t>(changes.last_id) >= told_.size()) {
    return {};
  }
  std::vector<AgentState> listed;
  listed.reserve(changes.agents.size());
  for (const agent_t& wire : changes.agents) {
    const std::optional<AgentState> agent = Read(wire, changes.header.sim_us);
    if (!agent) return {};
    listed.push_back(*agent);
  }
  return listed;
}

std::optional<AgentState> ToldAgents::Read(const agent_t& wire, TimeUs t) const {
  std::optional<AgentState> agent = FromWire(wire, kind_, t, WireLimits(*scenario_));
  if (agent) ReadActivity(wire, t, &*agent);
  return agent;
}

void ToldAgents::ReadActivity(const agent_t& wire, TimeUs t, AgentState* agent) const {
  if (!IsPair(agent->action) || agent->busy_until_us == kNever || agent->failed) return;
  const bool senses = agent->action == ActionKind::kSense;
  const bool is_uav = kind_ == AgentKind::kUav;
  Activity activity;
  activity.kind = senses ? Activity::Kind::kSensing : Activity::Kind::kCharging;
  activity.uav = UavId(is_uav ? agent->id : agent->partner);
  activity.partner = is_uav ? agent->partner : agent->id;
  activity.site = agent->target;
  activity.end_us = agent->busy_until_us;
  // When it starts follows from when it ends.
  if (senses) {
    const double cost_m = scenario_->tasks[static_cast<std::size_t>(agent->target)].cost_m;
    activity.start_us =
        activity.end_us - SensingUs(cost_m, scenario_->uavs[activity.uav.index()].speed_m_s);
  } else if (is_uav) {
    const double on_arrival_m = RangeAt(*agent, agent->arrive_us, scenario_->tasks);
    const AgentSpec& vehicle = scenario_->vehicles[static_cast<std::size_t>(agent->partner)];
    activity.start_us =
        activity.end_us - ChargingUs(agent->range_full_m, on_arrival_m, vehicle.charge_rate_m_s);
  } else {
    // A vehicle cannot know how long its UAV charges before it does.
    if (wire.status != AgentStatus::kCharging) return;
    activity.start_us = t;
  }
  agent->activity = activity;
}

void ToldAgents::Take(const agent_states_t& states) {
  const Rules& rules = scenario_->rules;
  if (static_cast<AgentKind>(states.kind) != kind_ || states.tick > rules.last_tick()) return;
  const TimeUs t = rules.TimeOf(states.tick);
  for (const agent_t& wire : states.agents) {
    if (static_cast<std::size_t>(wire.id) >= told_.size()) continue;
    Told& told = Of(wire.id);
    if (told.tick > states.tick) continue;
    std::optional<AgentState> agent = Read(wire, t);
    if (agent) told = {*agent, states.tick};
  }
}

std::optional<agent_states_t> ToldAgents::Expand(const agent_changes_t& changes) {
  const auto read = ReadListed(changes);
  if (!read) return {};
  const TimeUs t = changes.header.sim_us;
  agent_states_t states{};
  states.header = changes.header;
  states.kind = changes.kind;
  states.tick = changes.tick;
  states.applied_decision = changes.applied_decision;
  states.agents.reserve(static_cast<std::size_t>(changes.last_id - changes.first_id) + 1);
  auto listed = changes.agents.begin();
  for (std::int32_t id = changes.first_id; id <= changes.last_id; ++id) {
    if (listed != changes.agents.end() && listed->id == id) {
      states.agents.push_back(*listed++);
      continue;
    }
    const Told& told = Of(id);
    if (told.tick < changes.base_tick || told.tick > changes.tick) return {};
    states.agents.push_back(ToWire(told.agent, t, scenario_->tasks));
  }
  states.n = static_cast<std::int32_t>(states.agents.size());
  for (std::int32_t id = changes.first_id; id <= changes.last_id; ++id) {
    Of(id).tick = std::max(Of(id).tick, changes.tick);
  }
  for (const AgentState& agent : *read) {
    if (Of(agent.id).tick == changes.tick) Of(agent.id).agent = agent;
  }
  return states;
}

std::vector<agent_changes_t> ToldAgents::ChangesSince(std::int64_t tick,
                                                      std::int32_t applied_decision,
                                                      std::span<const agent_t> agents) {
  MUSTER_CHECK(!agents.empty() && tick > 0, "tick={}", tick);
  const TimeUs t = scenario_->rules.TimeOf(tick);
  std::vector<agent_changes_t> messages;
  const auto begin = [&](std::int32_t first_id) {
    agent_changes_t& changes = messages.emplace_back();
    changes.kind = NumberOf(kind_);
    changes.tick = tick;
    changes.applied_decision = applied_decision;
    changes.base_tick = tick - 1;
    changes.first_id = first_id;
  };
  begin(agents.front().id);
  for (const agent_t& wire : agents) {
    Told& told = Of(wire.id);
    MUSTER_CHECK(told.tick == tick - 1, "{}:{} tick={}", ToString(kind_), wire.id, tick);
    told.tick = tick;
    if (!IsOnFreeMove(wire, t) && Same(ToWire(told.agent, t, scenario_->tasks), wire)) continue;
    told.agent = *Read(wire, t);
    if (messages.back().agents.size() == kListedPerMessage) {
      messages.back().last_id = wire.id - 1;
      begin(wire.id);
    }
    messages.back().agents.push_back(wire);
  }
  messages.back().last_id = agents.back().id;
  for (agent_changes_t& changes : messages) {
    changes.n = static_cast<std::int32_t>(changes.agents.size());
  }
  return messages;
}

}  // namespace muster
