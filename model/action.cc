#include "model/action.h"

#include <fmt/format.h>

namespace muster {

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
