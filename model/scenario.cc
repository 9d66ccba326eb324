#include "model/scenario.h"

#include <algorithm>
#include <functional>

namespace muster {

bool Task::IsPlain() const {
  return reported_us == 0 && due_us == kNever && expires_us == kNever && revisit_us == kNever &&
         priority == Priority::kNormal && name.empty() && external_id.empty() && source.empty();
}

double WorthOf(const Task& task, TimeUs start_us, const Rules& rules) {
  const double worth = rules.priority_worth[static_cast<std::size_t>(task.priority)];
  return start_us <= task.due_us ? worth : worth * rules.late_worth;
}

bool Scenario::IsOpen() const {
  const Rules usual;
  return room.any() || rules.priority_worth != usual.priority_worth ||
         rules.late_worth != usual.late_worth || rules.patience_us != usual.patience_us ||
         std::any_of(std::begin(kAgentKinds), std::end(kAgentKinds),
                     [this](AgentKind kind) {
                       return std::any_of(agents(kind).begin(), agents(kind).end(),
                                          std::mem_fn(&AgentSpec::measured));
                     }) ||
         !std::all_of(tasks.begin(), tasks.end(), [](const Task& task) { return task.IsPlain(); });
}

void AddRoom(const Room& room, Scenario* scenario) {
  Task vacant;
  vacant.reported_us = kNever;
  scenario->tasks.insert(scenario->tasks.end(), room.tasks, vacant);
  // What is never online, and possible otherwise.
  AgentSpec uav, worker, vehicle;
  uav.speed_m_s = worker.speed_m_s = vehicle.speed_m_s = 1;
  uav.range_full_m = 1;
  vehicle.charge_rate_m_s = 1;
  scenario->uavs.insert(scenario->uavs.end(), room.agents.uavs, uav);
  scenario->workers.insert(scenario->workers.end(), room.agents.workers, worker);
  scenario->vehicles.insert(scenario->vehicles.end(), room.agents.vehicles, vehicle);
  scenario->room.tasks += room.tasks;
  for (const AgentKind kind : kAgentKinds) scenario->room.agents[kind] += room.agents[kind];
}

}  // namespace muster
