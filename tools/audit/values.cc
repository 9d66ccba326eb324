#include "tools/audit/values.h"

#include <fmt/format.h>

#include <cmath>

namespace muster::tools::audit {
namespace {

constexpr double kCellSide_m = 1000;

}  // namespace

bool Near(double a_m, double b_m) { return std::abs(a_m - b_m) <= kTolerance_m; }
bool NearUs(std::int64_t a, std::int64_t b) {
  return a == b || (a != kForever && b != kForever && std::abs(a - b) <= kToleranceUs);
}
bool Within(double value, Interval range, double tolerance) {
  return range.low - tolerance <= value && value <= range.high + tolerance;
}
bool SameCell(Place a, Place b) {
  return std::floor(a.x_m / kCellSide_m) == std::floor(b.x_m / kCellSide_m) &&
         std::floor(a.y_m / kCellSide_m) == std::floor(b.y_m / kCellSide_m);
}

std::string Name(const action_t& a) {
  std::string text = IsWord<ActionKind>(a.kind) ? std::string(ToString<ActionKind>(a.kind))
                                                : fmt::format("kind {}", a.kind);
  const auto add = [&text](const char* name, int id) {
    if (id >= 0) text += fmt::format(" {}:{}", name, id);
  };
  add("uav", a.uav_id);
  add("worker", a.worker_id);
  add("vehicle", a.vehicle_id);
  add("task", a.task_id);
  add("charge", a.charge_id);
  return text;
}

std::string Name(const Activity& a) {
  return fmt::format("{} of uav:{} and {}:{} at {}:{} in [{}, {}] us", ToString(a.kind), a.uav,
                     ToString<AgentKind>(a.partner_class()), a.partner,
                     a.senses() ? "task" : "charge", a.site, a.start_us, a.end_us);
}

std::string_view TaskWords(std::int64_t status) {
  return status == TaskStatus::kSensing ? "being sensed" : ToString<TaskStatus>(status);
}

Activity FromWire(const activity_t& a) {
  return {
      static_cast<ActivityKind>(a.kind), a.uav_id, a.partner_id, a.site_id, a.start_us, a.end_us};
}

}  // namespace muster::tools::audit
