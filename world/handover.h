#pragma once

#include <cstdint>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "model/scenario.h"
#include "protocol/convert.h"
#include "protocol/sender.h"

namespace muster::world {

/// The states that the newest verdict rests on. An agent process that starts again goes on from
/// them; it needs only that verdict and what follows, and the world repeats those.
class Handover {
 public:
  /// A report for the tick under way.
  void Add(AgentKind kind, const Packet& packet) { reports_[kind].push_back(packet); }
  /// The same for a report that came as changes: the whole states that they stand for.
  void Add(AgentKind kind, agent_states_t states) { told_[kind].push_back(std::move(states)); }
  /// Call when the tick under way is judged: the reports added since the last call are its reports.
  /// `applied` is the decision in force.
  void Judge(std::int64_t tick, TimeUs sim_us, std::int32_t applied);
  /// An agent that no process has reported, as the verdict leaves it.
  void AddUnreported(AgentKind kind, const agent_t& agent) { unreported_[kind].push_back(agent); }

  std::int64_t tick() const { return tick_; }  ///< -1: none is judged
  /// Messages agent_states_t; those of unreported agents are the world's own.
  std::vector<std::vector<std::uint8_t>> StatesOf(AgentKind kind, const Identity& world,
                                                  const Now& now) const;

 private:
  std::int64_t tick_ = -1;
  TimeUs sim_us_ = 0;  ///< of that tick
  std::int32_t applied_ = -1;
  PerKind<std::vector<Packet>> reports_, judged_;
  PerKind<std::vector<agent_states_t>> told_, judged_told_;
  PerKind<std::vector<agent_t>> unreported_;
};

}  // namespace muster::world
