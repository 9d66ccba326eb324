#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/codec.h"

namespace muster::tools {

/// One message of a hand-made log, open to edits before it is encoded.
struct FakeMessage {
  std::string channel;
  std::variant<scenario_t, clock_t, world_state_t, rulings_t, agent_states_t, schedule_t, event_t,
               fault_t, process_status_t>
      body;

  header_t& header();
  Packet Encoded() const;
};

using FakeLog = std::vector<FakeMessage>;

/// A valid log of a small mission, made by the test's own arithmetic and by nothing of the world's
/// or the scheduler's. 2 UAVs, 2 workers, 1 vehicle, 2 tasks, 1 charging point; three decisions, 10
/// min apart; run 7; senders "world", "uav", "worker", "vehicle", "scheduler". In minutes and
/// kilometres:
///   decision 0: UiTxWj(0, 0, 0): UAV from (1, 1) to (4, 1) by 3, worker from (1, 3) by 7.211,
///               sensing until 9.211; UiTx(1, 1): UAV from (9, 8) to (9, 9); VkCy: vehicle from
///               (8, 1) to (6, 1)
///   decision 1: UiCyVk(0, 0, 0): UAV to (6, 1) by 12, charging 7 km until 13.167;
///               UiTxWj(1, 1, 1): worker from (9, 7) by 14, sensing until 16
///   decision 2: UiCy(1, 0): UAV 8.544 km to (6, 1); the others stay
/// `tick_us` divides 10 min. More cost of task 0 makes its sensing longer and changes nothing else.
FakeLog MakeFakeMission(std::int64_t tick_us = 60'000'000, double task0_cost_m = 2000);

/// Numbers every sender's messages anew, from 0, after messages were added or taken out.
void Renumber(FakeLog* log);

std::vector<Packet> Encoded(const FakeLog& log);

/// Applies `edit` to every message of that type.
template <class Message>
void ForEach(FakeLog* log, const std::function<void(Message&)>& edit) {
  for (FakeMessage& message : *log) {
    if (auto* body = std::get_if<Message>(&message.body)) edit(*body);
  }
}

}  // namespace muster::tools
