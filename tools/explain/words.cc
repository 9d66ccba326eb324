#include "tools/explain/words.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/agent.h"

namespace muster::tools {

std::string ClockWords(TimeUs t) {
  const std::int64_t s = t / kSecondUs;
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string AgentName(AgentKind kind, std::int32_t id) {
  return fmt::format("{}:{}", ToString(kind), id);
}

std::string Words(const Action& action) {
  const std::string uav = AgentName(AgentKind::kUav, action.uav.value);
  const std::string worker = AgentName(AgentKind::kWorker, action.worker.value);
  const std::string vehicle = AgentName(AgentKind::kVehicle, action.vehicle.value);
  switch (action.kind) {
    case ActionKind::kUavStays:
      return uav + " stays";
    case ActionKind::kWorkerStays:
      return worker + " stays";
    case ActionKind::kVehicleStays:
      return vehicle + " stays";
    case ActionKind::kUavToTask:
      return fmt::format("{} goes to task:{}", uav, action.task.value);
    case ActionKind::kWorkerToTask:
      return fmt::format("{} goes to task:{}", worker, action.task.value);
    case ActionKind::kUavToCharge:
      return fmt::format("{} goes to charge:{}", uav, action.charge.value);
    case ActionKind::kVehicleToCharge:
      return fmt::format("{} goes to charge:{}", vehicle, action.charge.value);
    case ActionKind::kSense:
      return fmt::format("{} and {} sense task:{}", uav, worker, action.task.value);
    case ActionKind::kCharge:
      return fmt::format("{} charges {} at charge:{}", vehicle, uav, action.charge.value);
    case ActionKind::kGoTo:
      return fmt::format("{} goes to ({:.2f}, {:.2f}) km",
                         action.uav.valid()      ? uav
                         : action.worker.valid() ? worker
                                                 : vehicle,
                         action.to.x_m / 1000, action.to.y_m / 1000);
    case ActionKind::kNone:
      break;
  }
  return "nothing";
}

int MovesIn(const schedule_t& schedule) {
  return static_cast<int>(
      std::count_if(schedule.actions.begin(), schedule.actions.end(),
                    [](const action_t& a) { return !IsStay(static_cast<ActionKind>(a.kind)); }));
}

nlohmann::ordered_json ActionJson(const action_t& action) {
  return {{"kind", action.kind},          {"symbol", ToString<ActionKind>(action.kind)},
          {"uav", action.uav_id},         {"worker", action.worker_id},
          {"vehicle", action.vehicle_id}, {"task", action.task_id},
          {"charge", action.charge_id},   {"weight", action.weight}};
}

}  // namespace muster::tools
