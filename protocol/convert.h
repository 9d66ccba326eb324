#pragma once

#include <muster/action_t.hpp>
#include <muster/activity_t.hpp>
#include <muster/agent_states_t.hpp>
#include <muster/agent_t.hpp>
#include <muster/clearances_t.hpp>
#include <muster/clock_t.hpp>
#include <muster/ruling_t.hpp>
#include <muster/rulings_t.hpp>
#include <muster/schedule_t.hpp>
#include <muster/world_state_t.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "model/agent.h"

namespace muster {

/// What of a scenario a wire message must fit into. The scenario must outlive it.
struct WireLimits {
  const Scenario& scenario;
  const std::vector<Task>& tasks;
  const std::vector<ChargingPoint>& charging_points;
  std::size_t uavs = 0, workers = 0, vehicles = 0;
  const Disturbances& disturbances;
  std::uint64_t seed = 0;

  explicit WireLimits(const Scenario& of)
      : scenario(of),
        tasks(of.tasks),
        charging_points(of.charging_points),
        uavs(of.uavs.size()),
        workers(of.workers.size()),
        vehicles(of.vehicles.size()),
        disturbances(of.disturbances),
        seed(of.seed) {}
  std::size_t agents(AgentKind kind) const { return ByKind(kind, uavs, workers, vehicles); }
};

/// Whether that clock, or a world's state, rulings or schedule of that tick, can be in a mission of
/// these rules. A process that followed an impossible one would wait for a tick that never comes,
/// or its reports would be refused.
bool Possible(const clock_t& clock, const Scenario& scenario);
bool Possible(const world_state_t& world, const Rules& rules);
bool Possible(const rulings_t& rulings, const Rules& rules);
bool Possible(const schedule_t& schedule, const Scenario& scenario);
bool Possible(const clearances_t& clearances, const Scenario& scenario);

/// Where the states of that class are published.
std::string_view ChannelOf(AgentKind kind);

/// The state at time t, as its agent process reports it.
agent_t ToWire(const AgentState& agent, TimeUs t, std::span<const Task> tasks);
/// Messages with these agents, headers not filled: each near one datagram's 64 kB, so that little
/// is lost with a fragment.
std::vector<agent_states_t> StatesMessages(AgentKind kind, std::int64_t tick,
                                           std::int32_t applied_decision,
                                           std::span<const agent_t> agents);

/// The same states in such messages, numbered from theirs on. They were never sent; the number
/// tells them apart.
std::vector<agent_states_t> PartsOf(const agent_states_t& states);

/// The inverse, for a report of time t; nothing when an id, time or number is impossible. The wire
/// does not carry the activity (Settle() attaches it) nor the wind on the leg under way, which is
/// drawn again (and shows in the difference of two reports).
std::optional<AgentState> FromWire(const agent_t& wire, AgentKind kind, TimeUs t,
                                   const WireLimits& limits);

activity_t ToWire(const Activity& activity);
std::optional<Activity> FromWire(const activity_t& wire, const WireLimits& limits);

ruling_t ToWire(const Ruling& ruling);
/// event_t.detail of an agent that has failed because that process is lost.
std::string LossDetail(std::string_view process);
std::optional<Ruling> FromWire(const ruling_t& wire, const WireLimits& limits);

/// Header, decision and tick are not filled.
clearances_t ToWire(const std::vector<Clearance>& clearances);
/// None where one names a UAV that the scenario does not have.
std::optional<std::vector<Clearance>> FromWire(const clearances_t& wire, const WireLimits& limits);

action_t ToWire(const Action& action);
std::optional<Action> FromWire(const action_t& wire, const WireLimits& limits);

}  // namespace muster
