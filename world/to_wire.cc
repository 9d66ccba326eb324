#include "world/to_wire.h"

#include "protocol/convert.h"

namespace muster::world {

event_t ToWire(const Event& event) {
  event_t wire{};
  wire.kind = NumberOf(event.kind);
  wire.at_us = event.at_us;
  wire.uav_id = event.uav.value;
  wire.worker_id = event.worker.value;
  wire.vehicle_id = event.vehicle.value;
  wire.task_id = event.task.value;
  wire.charge_id = event.charge.value;
  wire.detail = event.detail;
  return wire;
}

world_state_t WorldStateOf(const Referee& referee, std::int64_t tick) {
  world_state_t world{};
  world.tick = tick;
  world.done = referee.done();
  for (const TaskStatus status : referee.task_status()) {
    world.task_status.push_back(static_cast<std::int8_t>(status));
  }
  world.n_tasks = static_cast<std::int32_t>(world.task_status.size());
  for (const Activity& activity : referee.verdict().activities()) {
    world.activities.push_back(muster::ToWire(activity));
  }
  world.n_activities = static_cast<std::int32_t>(world.activities.size());
  return world;
}

rulings_t RulingsOf(const Verdict& verdict, std::int64_t tick) {
  rulings_t rulings{};
  rulings.tick = tick;
  for (const Ruling& ruling : verdict.rulings()) {
    rulings.rulings.push_back(muster::ToWire(ruling));
  }
  rulings.n = static_cast<std::int32_t>(rulings.rulings.size());
  return rulings;
}

}  // namespace muster::world
