#pragma once

#include <cstdint>
#include <memory>
#include <muster/agent_changes_t.hpp>
#include <muster/agent_states_t.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "model/scenario.h"
#include "protocol/convert.h"

namespace muster {

/// Where the changes of that class are published.
std::string_view ChangesChannelOf(AgentKind kind);

/// What the receivers of the reports of one agent class know: each agent as it was last listed.
/// From that its state follows for any later time, until something happens to it. The sender keeps
/// the same object as its receivers, so it knows what it need not send.
class ToldAgents {
 public:
  ToldAgents(std::shared_ptr<const Scenario> scenario, AgentKind kind);

  /// Whether these changes are possible in this mission. They are not at a decision's tick: there
  /// reports are whole, so that a decision rests only on states that were sent.
  bool Possible(const agent_changes_t& changes) const;

  /// Takes in whole states, except those of impossible agents and of agents that are known at a
  /// later tick.
  void Take(const agent_states_t& states);
  /// Takes the changes in and returns the whole states that they stand for, of agents first_id to
  /// last_id, with the same header. Returns none and takes nothing in if the changes are impossible
  /// or an agent that they do not list is not known at the base tick.
  std::optional<agent_states_t> Expand(const agent_changes_t& changes);

  /// What has to be sent of `agents` (ascending and consecutive ids, as ToWire makes them at that
  /// tick), if this sender has reported all of them for the tick before; takes it in. Headers are
  /// not filled. Messages stay near one datagram's 64 kB.
  std::vector<agent_changes_t> ChangesSince(std::int64_t tick, std::int32_t applied_decision,
                                            std::span<const agent_t> agents);

 private:
  struct Told {
    AgentState agent;        ///< as last listed, and what follows from that
    std::int64_t tick = -1;  ///< the newest at which it is known, listed or not
  };
  /// The listed agents; none: the changes are impossible.
  std::optional<std::vector<AgentState>> ReadListed(const agent_changes_t& changes) const;
  std::optional<AgentState> Read(const agent_t& wire, TimeUs t) const;
  void ReadActivity(const agent_t& wire, TimeUs t, AgentState* agent) const;
  Told& Of(std::int32_t id) { return told_[static_cast<std::size_t>(id)]; }

  std::shared_ptr<const Scenario> scenario_;
  AgentKind kind_;
  std::vector<Told> told_;  ///< [n_agents]
};

}  // namespace muster
