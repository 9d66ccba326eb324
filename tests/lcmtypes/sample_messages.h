#pragma once

#include <string>
#include <tuple>
#include <vector>

#include "lcmtypes/bus/codec.h"

namespace muster {

/// One valid message of each type of the channel table, strings and arrays not empty.
using AllMessages =
    std::tuple<agent_changes_t, agent_states_t, answer_t, clearances_t, clock_t, event_t, fault_t,
               log_status_t, order_t, orders_t, process_status_t, proposal_t, request_t, restore_t,
               roads_t, rulings_t, scenario_t, schedule_t, world_state_t>;
AllMessages SampleMessages();

}  // namespace muster
