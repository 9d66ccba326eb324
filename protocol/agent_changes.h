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

/// What the receivers of the reports of one agent class know: each agent as last listed, which is a
/// function of time until something happens to it. The sender keeps the same object as its
/// receivers, so that it sees what it need not send.
class ToldAgents {
 public:
  ToldAgents(std::shared_ptr<const Scenario> scenario, AgentKind kind);

  /// Whether that can be in this mission. A report for a decision's tick is whole: a decision rests
  /// on what is said, not on what follows from it.
  bool Possible(const agent_changes_t& changes) const;

  /// Takes in whole states; agents that cannot be, and those told of for a later tick, are left
  /// out.
  void Take(const agent_states_t& states);
  /// The whole states that these changes stand for, of agents first_id to last_id, with the same
  /// header; takes them in. None, and nothing is taken in: they are impossible, or an agent that is
  /// not listed has not been told of for the base tick.
  std::optional<agent_states_t> Expand(const agent_changes_t& changes);

  /// What of `agents` (ascending and consecutive ids, as ToWire has them at that tick) has to be
  /// said, where what was told before was said by this sender for the tick before; takes it in.
  /// Headers are not filled. Messages stay near one datagram's 64 kB.
  std::vector<agent_changes_t> ChangesSince(std::int64_t tick, std::int32_t applied_decision,
                                            std::span<const agent_t> agents);

 private:
  struct Told {
    AgentState agent;        ///< as last listed, and what follows from that
    std::int64_t tick = -1;  ///< newest that it has been told of for, listed or not
  };
  /// The listed agents; none: those changes cannot be.
  std::optional<std::vector<AgentState>> ReadListed(const agent_changes_t& changes) const;
  std::optional<AgentState> Read(const agent_t& wire, TimeUs t) const;
  void ReadActivity(const agent_t& wire, TimeUs t, AgentState* agent) const;
  Told& Of(std::int32_t id) { return told_[static_cast<std::size_t>(id)]; }

  std::shared_ptr<const Scenario> scenario_;
  AgentKind kind_;
  std::vector<Told> told_;  ///< [n_agents]
};

}  // namespace muster
