#include "model/action.h"

#include <fmt/format.h>

namespace muster {

std::optional<ActionShape> ShapeOf(ActionKind kind) {
  switch (kind) {
    case ActionKind::kUavStays:
      return ActionShape{.uav = true};
    case ActionKind::kWorkerStays:
      return ActionShape{.worker = true};
    case ActionKind::kVehicleStays:
      return ActionShape{.vehicle = true};
    case ActionKind::kUavToTask:
      return ActionShape{.uav = true, .task = true};
    case ActionKind::kWorkerToTask:
      return ActionShape{.worker = true, .task = true};
    case ActionKind::kUavToCharge:
      return ActionShape{.uav = true, .charge = true};
    case ActionKind::kVehicleToCharge:
      return ActionShape{.vehicle = true, .charge = true};
    case ActionKind::kSense:
      return ActionShape{.uav = true, .worker = true, .task = true};
    case ActionKind::kCharge:
      return ActionShape{.uav = true, .vehicle = true, .charge = true};
    case ActionKind::kNone:
    case ActionKind::kGoTo:
      return std::nullopt;
  }
  return std::nullopt;
}

bool HasItsIds(const Action& a) {
  const auto shape = ShapeOf(a.kind);
  const int agents = a.uav.valid() + a.worker.valid() + a.vehicle.valid();
  if (!shape) {
    return a.kind == ActionKind::kGoTo && agents == 1 && !a.task.valid() && !a.charge.valid();
  }
  return a.uav.valid() == shape->uav && a.worker.valid() == shape->worker &&
         a.vehicle.valid() == shape->vehicle && a.task.valid() == shape->task &&
         a.charge.valid() == shape->charge;
}

std::string ToString(const Action& action) {
  std::string text(ToString(action.kind));
  const auto add = [&text](const char* name, std::int32_t id) {
    if (id >= 0) text += fmt::format(" {}:{}", name, id);
  };
  add("uav", action.uav.value);
  add("worker", action.worker.value);
  add("vehicle", action.vehicle.value);
  add("task", action.task.value);
  add("charge", action.charge.value);
  return text;
}

}  // namespace muster
