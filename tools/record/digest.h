#pragma once

#include <string>

#include "tools/record/run_record.h"

namespace muster::tools {

/// SHA-256, in lower-case hexadecimal, over everything that a mission decided and everything that
/// came of it. Equal digests mean equal decisions and outcomes, bit for bit. Nothing in it is
/// measured in wall time, and nothing depends on the tick's length, on how the agents are split
/// into processes, on solve times or on the order of arrival.
///
/// The bytes, so that anyone can compute it again. Integers are two's complement and little-endian
/// (i8, i32, i64); f64 is the IEEE 754 bit pattern, little-endian. In this order:
///
/// 1. The 16 ASCII bytes "muster digest 1\n".
/// 2. Each decision, by ascending index: the byte 'D'; i32 index; i32 number of actions; then each
///    action: i8 kind; i32 uav_id, worker_id, vehicle_id, task_id, charge_id; f64 x_m, y_m, weight.
///    Actions are sorted by (kind, uav_id, worker_id, vehicle_id, task_id, charge_id).
/// 3. Each event of the kinds 0 to 10, sorted by (at_us, kind, uav_id, worker_id, vehicle_id,
///    task_id, charge_id), equal ones once: the byte 'E'; i64 at_us; i8 kind; i32 uav_id,
///    worker_id, vehicle_id, task_id, charge_id.
/// 4. Each task by ascending id, from the world_state_t of the last tick: the byte 'T'; i8 status;
///    i64 at_us of its first event of kind 5 (sensing done), -1 when there is none.
/// 5. Each UAV by ascending id, from the agent_states_t of the last tick: the byte 'U';
///    f64 range_left_m.
///
/// The parts 4 and 5 of a run whose scenario is not known are empty; status is -1 without a world
/// state.
std::string Digest(const RunRecord& record);

}  // namespace muster::tools
