#include "model/action.h"

#include <fmt/format.h>

#include "base/check.h"

namespace muster {

std::string_view Symbol(ActionKind kind) {
  switch (kind) {
    case ActionKind::kNone:
      return "none";
    case ActionKind::kUavStays:
      return "Ui";
    case ActionKind::kWorkerStays:
      return "Wj";
    case ActionKind::kVehicleStays:
      return "Vk";
    case ActionKind::kUavToTask:
      return "UiTx";
    case ActionKind::kWorkerToTask:
      return "WjTx";
    case ActionKind::kUavToCharge:
      return "UiCy";
    case ActionKind::kVehicleToCharge:
      return "VkCy";
    case ActionKind::kSense:
      return "UiTxWj";
    case ActionKind::kCharge:
      return "UiCyVk";
    case ActionKind::kGoTo:
      return "go";
  }
  MUSTER_CHECK(false, "kind={}", static_cast<int>(kind));
  return {};
}

std::string ToString(const Action& action) {
  std::string text(Symbol(action.kind));
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
