#pragma once

#include <cstdint>
#include <map>
#include <muster/agent_changes_t.hpp>
#include <muster/agent_states_t.hpp>
#include <muster/answer_t.hpp>
#include <muster/clearances_t.hpp>
#include <muster/clock_t.hpp>
#include <muster/event_t.hpp>
#include <muster/fault_t.hpp>
#include <muster/log_status_t.hpp>
#include <muster/order_t.hpp>
#include <muster/orders_t.hpp>
#include <muster/process_status_t.hpp>
#include <muster/proposal_t.hpp>
#include <muster/request_t.hpp>
#include <muster/restore_t.hpp>
#include <muster/roads_t.hpp>
#include <muster/rulings_t.hpp>
#include <muster/scenario_t.hpp>
#include <muster/schedule_t.hpp>
#include <muster/world_state_t.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "base/interval_set.h"
#include "lcmtypes/bus/bus.h"

namespace muster {

/// How many numbers below the highest are missing; at most 10^12 are counted, so that damaged or
/// forged numbers of many starts make no sum that no message can carry.
std::int64_t GapsIn(const IntervalSet& seqs);

using Message =
    std::variant<scenario_t, clock_t, world_state_t, rulings_t, agent_states_t, agent_changes_t,
                 schedule_t, event_t, fault_t, process_status_t, log_status_t, request_t, restore_t,
                 answer_t, order_t, orders_t, roads_t, clearances_t, proposal_t>;
const header_t& HeaderOf(const Message& message);

/// The message that the packet is; none where it is not a valid one of its channel's type.
std::optional<Message> DecodeMessage(const Packet& packet);

/// Decodes a process's packets, and counts and drops those that are not for it. A message passes if
/// it belongs to this run, comes from another process that may publish on its channel and is of no
/// earlier launcher, is within the ranges that need no scenario, and is not numbered as if mission
/// time ran backwards. Doubles pass, because a repeated question needs a repeated answer.
class Inbox {
 public:
  struct Counters {
    std::int64_t received = 0;  ///< opened, doubles included
    std::int64_t rejected = 0;  ///< undecodable, foreign, forged or out of range
  };

  Inbox(std::int64_t run_id, std::string own_name, std::int64_t own_boot_id = 0);

  std::optional<Message> Open(const Packet& packet);
  /// The same for a packet that was decoded already: whether its message is accepted.
  bool Admit(const Packet& packet, const std::optional<Message>& message);

  const Counters& counters() const { return counters_; }
  /// For a receiver that finds a message impossible in the light of the scenario.
  void Reject() { ++counters_.rejected; }

 private:
  /// Notes the message's number; false when the number is impossible.
  bool Count(const Message& message);

  std::int64_t run_id_;
  std::string own_name_;
  std::int64_t own_boot_id_;
  Counters counters_;
  struct Start {
    std::int64_t newest_seq = -1;
    std::int64_t newest_sim_us = 0;  ///< of the highest seq that is no heartbeat's
    int doubts = 0;                  ///< messages since then that were behind that
  };
  std::map<std::pair<std::string, std::int64_t>, Start> starts_;  ///< by sender, boot_id
};

}  // namespace muster
