#include "protocol/convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lcmtypes/bounds.h"
#include "lcmtypes/channels.h"
#include "model/measured.h"

namespace muster {
namespace {

bool Below(std::int32_t id, std::size_t count) {
  return id >= 0 && static_cast<std::size_t>(id) < count;
}
bool NoneOrBelow(std::int32_t id, std::size_t count) { return id == -1 || Below(id, count); }

/// Where the leg of a report ends. Exact where it matters: on arrival the position is the target,
/// and targets are places of the scenario; a free move under way is extrapolated.
Point Destination(const agent_t& wire, AgentKind kind, ActionKind action, TimeUs t,
                  const WireLimits& limits) {
  const Point here{wire.x_m, wire.y_m};
  if (t >= wire.arrive_us) return here;
  switch (action) {
    case ActionKind::kUavToTask:
    case ActionKind::kWorkerToTask:
    case ActionKind::kSense:
      return limits.tasks[static_cast<std::size_t>(wire.target_id)].at;
    case ActionKind::kUavToCharge:
    case ActionKind::kVehicleToCharge:
    case ActionKind::kCharge:
      return limits.charging_points[static_cast<std::size_t>(wire.target_id)].at;
    default:
      break;
  }
  if (const auto stop = limits.scenario.ways->NumberedStop(kind, wire.target_id)) return *stop;
  const Point from{wire.from_x_m, wire.from_y_m};
  if (t <= wire.depart_us) return here;
  const auto way_us = static_cast<double>(wire.arrive_us - wire.depart_us);
  const auto gone_us = static_cast<double>(t - wire.depart_us);
  const Point goal = Lerp(from, here, way_us / gone_us);
  // Most goals are whole millimetres, which arithmetic misses by little.
  const Point whole{std::round(goal.x_m * 1e3) / 1e3, std::round(goal.y_m * 1e3) / 1e3};
  return Lerp(from, whole, gone_us / way_us) == here ? whole : goal;
}

bool TargetFits(const agent_t& wire, ActionKind action, AgentKind kind, const WireLimits& limits) {
  switch (action) {
    case ActionKind::kNone:
    case ActionKind::kGoTo:
      return true;
    case ActionKind::kUavToTask:
      return kind == AgentKind::kUav && Below(wire.target_id, limits.tasks.size());
    case ActionKind::kWorkerToTask:
      return kind == AgentKind::kWorker && Below(wire.target_id, limits.tasks.size());
    case ActionKind::kUavToCharge:
      return kind == AgentKind::kUav && Below(wire.target_id, limits.charging_points.size());
    case ActionKind::kVehicleToCharge:
      return kind == AgentKind::kVehicle && Below(wire.target_id, limits.charging_points.size());
    case ActionKind::kSense:
      return kind != AgentKind::kVehicle && Below(wire.target_id, limits.tasks.size()) &&
             Below(wire.partner_id, kind == AgentKind::kUav ? limits.workers : limits.uavs);
    case ActionKind::kCharge:
      return kind != AgentKind::kWorker && Below(wire.target_id, limits.charging_points.size()) &&
             Below(wire.partner_id, kind == AgentKind::kUav ? limits.vehicles : limits.uavs);
    default:
      return false;
  }
}

/// Whether times that follow from these numbers are times.
bool NumbersFit(const agent_t& wire, AgentKind kind) {
  const auto is_rate = [](double m_s) { return m_s >= kSlowest_m_s && m_s <= kFastest_m_s; };
  // At departure it had what it has flown since, too.
  const auto is_range = [](double m) { return m >= 0 && m <= 3 * kLongestWay_m; };
  return is_rate(wire.speed_m_s) && is_range(wire.range_left_m) &&
         is_range(wire.range_at_departure_m) && wire.range_full_m >= 0 &&
         wire.range_full_m <= kLongestWay_m &&
         (kind != AgentKind::kVehicle || is_rate(wire.charge_rate_m_s));
}

/// Readers find the goal of a free move in the straight line from where the agent set out to where
/// it is (Destination). This is the place to name as the origin, if it was left `behind_us` ago.
Point BehindGoal(const AgentState& agent, Point here, TimeUs behind_us, TimeUs t) {
  const double part = static_cast<double>(behind_us) / static_cast<double>(agent.arrive_us - t);
  return Lerp(here, agent.to, -part);
}

/// The rest of a free move begins at agent.from now: a place and a time as far behind tell its
/// goal.
void TellGoal(const AgentState& agent, TimeUs set_out_us, TimeUs t, agent_t* wire) {
  const TimeUs behind_us = std::min(agent.arrive_us - t, t - set_out_us);
  const Point from = BehindGoal(agent, agent.from, behind_us, t);
  wire->from_x_m = from.x_m;
  wire->from_y_m = from.y_m;
  wire->depart_us = t - behind_us;
  if (agent.kind == AgentKind::kUav) {
    wire->range_at_departure_m += agent.range_per_m * agent.GoneM(from, agent.from);
  }
}

/// Whether the tick has that decision, or may have it: orders that ask for one may not be known
/// yet.
bool HasDecision(std::int64_t tick, std::int32_t decision, const Scenario& scenario) {
  return scenario.takes_orders() ? scenario.rules.MayDecide(tick, decision)
                                 : decision == scenario.rules.DecisionAt(tick);
}

}  // namespace

bool Possible(const clock_t& clock, const Scenario& scenario) {
  const Rules& rules = scenario.rules;
  return clock.tick >= 0 && clock.tick <= rules.last_tick() &&
         clock.tick_us == rules.TimeOf(clock.tick) && clock.limit_us == rules.limit_us &&
         HasDecision(clock.tick, clock.decision, scenario) &&
         clock.required_decision <=
             (scenario.takes_orders() ? clock.tick : clock.tick_us / rules.interval_us);
}

bool Possible(const world_state_t& world, const Rules& rules) {
  return world.tick >= 0 && world.tick <= rules.last_tick() &&
         world.header.sim_us == rules.TimeOf(world.tick);
}

bool Possible(const rulings_t& rulings, const Rules& rules) {
  return rulings.tick >= 0 && rulings.tick <= rules.last_tick() &&
         std::all_of(rulings.rulings.begin(), rulings.rulings.end(), [&](const ruling_t& ruling) {
           return ruling.at_us <= rules.TimeOf(rulings.tick);
         });
}

bool Possible(const schedule_t& schedule, const Scenario& scenario) {
  return schedule.tick >= 0 && schedule.tick <= scenario.rules.last_tick() &&
         schedule.decision >= 0 && HasDecision(schedule.tick, schedule.decision, scenario);
}

bool Possible(const clearances_t& clearances, const Scenario& scenario) {
  return clearances.tick >= 0 && clearances.tick <= scenario.rules.last_tick() &&
         clearances.decision >= 0 && HasDecision(clearances.tick, clearances.decision, scenario);
}

std::string_view ChannelOf(AgentKind kind) {
  return ByKind(kind, channel::kUavs, channel::kWorkers, channel::kVehicles);
}

agent_t ToWire(const AgentState& agent, TimeUs t, std::span<const Task> tasks) {
  const Point here = PositionAt(agent, t);
  agent_t wire{};
  wire.id = agent.id;
  wire.x_m = here.x_m;
  wire.y_m = here.y_m;
  wire.speed_m_s = agent.speed_m_s;
  wire.range_left_m = RangeAt(agent, t, tasks);
  wire.range_full_m = agent.range_full_m;
  wire.charge_rate_m_s = agent.charge_rate_m_s;
  wire.from_x_m = agent.from.x_m;
  wire.from_y_m = agent.from.y_m;
  wire.range_at_departure_m = agent.range_at_departure_m;
  wire.depart_us = agent.depart_us;
  wire.arrive_us = agent.arrive_us;
  wire.online_from_us = agent.online_from_us;
  wire.online_until_us = agent.online_until_us;
  wire.busy_until_us = agent.busy_until_us;
  wire.status = static_cast<std::int8_t>(StatusAt(agent, t));
  wire.action = static_cast<std::int8_t>(agent.action);
  wire.target_id = agent.target;
  wire.partner_id = agent.partner;
  wire.decision = agent.decision;
  if (agent.action == ActionKind::kGoTo && t < agent.arrive_us && agent.target < 0) {
    if (agent.measured && agent.depart_us == t && agent.measured->set_out_us < t) {
      TellGoal(agent, agent.measured->set_out_us, t, &wire);
    } else if (!agent.ways->straight(agent.kind) && agent.depart_us < t) {
      const Point from = BehindGoal(agent, here, t - agent.depart_us, t);
      wire.from_x_m = from.x_m;
      wire.from_y_m = from.y_m;
    }
  }
  if (TellsWholeLeg(agent, t)) {
    const Measured& told = *agent.measured;
    const double way = agent.range_per_m * agent.GoneM(told.origin, agent.from);
    wire.from_x_m = told.origin.x_m;
    wire.from_y_m = told.origin.y_m;
    wire.depart_us = told.set_out_us;
    if (agent.kind == AgentKind::kUav) wire.range_at_departure_m += way;
  }
  return wire;
}

std::vector<agent_states_t> StatesMessages(AgentKind kind, std::int64_t tick,
                                           std::int32_t applied_decision,
                                           std::span<const agent_t> agents) {
  constexpr std::size_t kAgentsPerMessage = 256;
  std::vector<agent_states_t> messages;
  for (std::size_t first = 0; first < agents.size(); first += kAgentsPerMessage) {
    const auto part = agents.subspan(first, std::min(kAgentsPerMessage, agents.size() - first));
    agent_states_t& states = messages.emplace_back();
    states.kind = NumberOf(kind);
    states.tick = tick;
    states.applied_decision = applied_decision;
    states.agents.assign(part.begin(), part.end());
    states.n = static_cast<std::int32_t>(part.size());
  }
  return messages;
}

std::vector<agent_states_t> PartsOf(const agent_states_t& states) {
  std::vector<agent_states_t> parts = StatesMessages(
      static_cast<AgentKind>(states.kind), states.tick, states.applied_decision, states.agents);
  std::int64_t seq = states.header.seq;
  for (agent_states_t& part : parts) {
    part.header = states.header;
    part.header.seq = seq++;
  }
  return parts;
}

std::optional<AgentState> FromWire(const agent_t& wire, AgentKind kind, TimeUs t,
                                   const WireLimits& limits) {
  const auto action = static_cast<ActionKind>(wire.action);
  if (!Below(wire.id, limits.agents(kind)) || !TargetFits(wire, action, kind, limits)) return {};
  if (wire.depart_us < 0 || wire.depart_us > t || wire.arrive_us < wire.depart_us) return {};
  if (!NumbersFit(wire, kind)) return {};
  AgentState agent;
  // A measured agent's leg is always one by the ways of the present (GoRound).
  const bool measured = limits.scenario.agents(kind)[static_cast<std::size_t>(wire.id)].measured;
  agent.ways = &limits.scenario.WaysAt(t);
  agent.leg_ways = measured ? agent.ways : &limits.scenario.WaysAt(wire.depart_us);
  agent.kind = kind;
  agent.id = wire.id;
  agent.speed_m_s = wire.speed_m_s;
  agent.range_full_m = wire.range_full_m;
  agent.charge_rate_m_s = wire.charge_rate_m_s;
  agent.online_from_us = wire.online_from_us;
  agent.online_until_us = wire.online_until_us;
  agent.from = {wire.from_x_m, wire.from_y_m};
  agent.to = Destination(wire, kind, action, t, limits);
  agent.depart_us = wire.depart_us;
  agent.arrive_us = wire.arrive_us;
  agent.range_at_departure_m = wire.range_at_departure_m;
  agent.action = action;
  agent.target = wire.target_id;
  agent.partner = wire.partner_id;
  agent.decision = wire.decision;
  agent.busy_until_us = wire.busy_until_us;
  if (kind == AgentKind::kUav && action != ActionKind::kNone) {
    agent.range_per_m =
        RangePerMetre(UavId(wire.id), wire.decision, limits.disturbances, limits.seed);
  }
  agent.failed = wire.status == AgentStatus::kFailed;
  if (measured) {
    ReadMeasured({wire.x_m, wire.y_m}, wire.range_left_m, t, limits.scenario.rules, &agent);
  }
  if (action == ActionKind::kGoTo && !agent.ways->straight(kind) && agent.target < 0 &&
      agent.depart_us < t && t < agent.arrive_us) {
    // The origin that is told stands for the goal: the way is known from here on.
    agent.from = {wire.x_m, wire.y_m};
    agent.depart_us = t;
    agent.range_at_departure_m = wire.range_left_m;
  }
  return agent;
}

activity_t ToWire(const Activity& activity) {
  activity_t wire{};
  wire.kind = NumberOf(activity.kind);
  wire.uav_id = activity.uav.value;
  wire.partner_id = activity.partner;
  wire.site_id = activity.site;
  wire.start_us = activity.start_us;
  wire.end_us = activity.end_us;
  return wire;
}

std::optional<Activity> FromWire(const activity_t& wire, const WireLimits& limits) {
  const bool sensing = wire.kind == ActivityKind::kSensing;
  if (!IsWord<ActivityKind>(wire.kind) || !Below(wire.uav_id, limits.uavs) ||
      !Below(wire.partner_id, sensing ? limits.workers : limits.vehicles) ||
      !Below(wire.site_id, sensing ? limits.tasks.size() : limits.charging_points.size()) ||
      wire.start_us < 0 || wire.end_us < wire.start_us) {
    return {};
  }
  Activity activity;
  activity.kind = static_cast<Activity::Kind>(wire.kind);
  activity.uav = UavId(wire.uav_id);
  activity.partner = wire.partner_id;
  activity.site = wire.site_id;
  activity.start_us = wire.start_us;
  activity.end_us = wire.end_us;
  return activity;
}

ruling_t ToWire(const Ruling& ruling) {
  ruling_t wire{};
  wire.agent_kind = NumberOf(ruling.agent_kind);
  wire.agent_id = ruling.agent;
  wire.kind = NumberOf(ruling.kind);
  wire.at_us = ruling.at_us;
  return wire;
}

std::string LossDetail(std::string_view process) { return fmt::format("{} is lost", process); }

std::optional<Ruling> FromWire(const ruling_t& wire, const WireLimits& limits) {
  if (!IsWord<AgentKind>(wire.agent_kind) || !IsWord<RulingKind>(wire.kind)) return {};
  const auto kind = static_cast<AgentKind>(wire.agent_kind);
  if (!Below(wire.agent_id, limits.agents(kind)) || wire.at_us < 0) return {};
  return Ruling{kind, wire.agent_id, static_cast<Ruling::Kind>(wire.kind), wire.at_us};
}

clearances_t ToWire(const std::vector<Clearance>& clearances) {
  clearances_t wire{};
  for (const Clearance& c : clearances) {
    clearance_t& one = wire.clearances.emplace_back();
    one.uav_id = c.uav;
    one.decision = c.decision;
    one.from_m = c.from_m;
    one.to_m = c.to_m;
    one.begin_us = c.begin_us;
  }
  wire.n = static_cast<std::int32_t>(wire.clearances.size());
  return wire;
}

std::optional<std::vector<Clearance>> FromWire(const clearances_t& wire, const WireLimits& limits) {
  std::vector<Clearance> clearances;
  for (const clearance_t& one : wire.clearances) {
    if (!Below(one.uav_id, limits.uavs)) return {};
    clearances.push_back({one.uav_id, one.decision, one.from_m, one.to_m, one.begin_us});
  }
  return clearances;
}

action_t ToWire(const Action& action) {
  action_t wire{};
  wire.kind = NumberOf(action.kind);
  wire.uav_id = action.uav.value;
  wire.worker_id = action.worker.value;
  wire.vehicle_id = action.vehicle.value;
  wire.task_id = action.task.value;
  wire.charge_id = action.charge.value;
  wire.x_m = action.to.x_m;
  wire.y_m = action.to.y_m;
  wire.weight = action.weight;
  return wire;
}

std::optional<Action> FromWire(const action_t& wire, const WireLimits& limits) {
  if (!IsWord<ActionKind>(wire.kind) || !NoneOrBelow(wire.uav_id, limits.uavs) ||
      !NoneOrBelow(wire.worker_id, limits.workers) ||
      !NoneOrBelow(wire.vehicle_id, limits.vehicles) ||
      !NoneOrBelow(wire.task_id, limits.tasks.size()) ||
      !NoneOrBelow(wire.charge_id, limits.charging_points.size()) || !std::isfinite(wire.x_m) ||
      !std::isfinite(wire.y_m)) {
    return {};
  }
  Action action;
  action.kind = static_cast<ActionKind>(wire.kind);
  action.uav = UavId(wire.uav_id);
  action.worker = WorkerId(wire.worker_id);
  action.vehicle = VehicleId(wire.vehicle_id);
  action.task = TaskId(wire.task_id);
  action.charge = ChargeId(wire.charge_id);
  action.to = {wire.x_m, wire.y_m};
  action.weight = wire.weight;
  if (!HasItsIds(action)) return {};
  return action;
}

}  // namespace muster
